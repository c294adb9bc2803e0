// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Meshes made by formula, for a first look without a file. About two units across, z up, with texture coordinates.
import { bentLattice } from '../lattice/bent';
import { fitLattice } from '../lattice/fitted_lattice';
import type { Lattice } from '../lattice/lattice';
import { add, cross, normalized, scale, type Vec3 } from '../lattice/vec';
import type { MeshFile } from './mesh_file';

const TURN = 2 * Math.PI;

interface Grid {
  /** Quads along and across. */
  readonly rows: number;
  readonly columns: number;
  /** The point at fractions 0 to 1. Its ends join in each direction in which the grid is closed. */
  readonly at: (s: number, t: number) => Vec3;
  readonly closedRows: boolean;
  readonly closedColumns: boolean;
}

interface Sample {
  readonly label: string;
  readonly note: string;
  readonly obj: () => string;
  /** A sample with a lattice opens already deformed, beside its vertices-only shape. Others ask for a lattice. */
  readonly lattice?: () => Lattice;
}

export const SAMPLES = {
  beam: {
    label: 'Bent beam',
    note: '18 quads, compared with an ordinary lattice',
    obj: beam,
    lattice: () => bentLattice(fitLattice(BEAM_BOUNDS, { size: [9, 3, 3], degree: [3, 2, 2], padding: 0.05 }), Math.PI, Math.PI / 2),
  },
  knot: {
    label: 'Knot',
    note: '5,760 quads',
    obj: () => gridObj({ rows: 240, columns: 24, at: knot, closedRows: true, closedColumns: true }),
  },
  vase: {
    label: 'Vase',
    note: '4,608 quads',
    obj: () => gridObj({ rows: 48, columns: 96, at: vase, closedRows: false, closedColumns: true }),
  },
  slab: {
    label: 'Slab',
    note: '1,600 quads',
    obj: () => gridObj({ rows: 40, columns: 40, at: slab, closedRows: false, closedColumns: false }),
  },
} satisfies Record<string, Sample>;

export type SampleName = keyof typeof SAMPLES;

/** The deformed lattice in which a sample opens; undefined if it opens at rest. */
export function sampleLattice(name: SampleName): Lattice | undefined {
  const sample: Sample = SAMPLES[name];
  return sample.lattice?.();
}

/** A sample as the OBJ file that a person could have dropped. */
export function sampleFile(name: SampleName): MeshFile {
  return { name: `${name}.obj`, format: 'obj', content: new Blob([SAMPLES[name].obj()]) };
}

function gridObj({ rows, columns, at, closedRows, closedColumns }: Grid): string {
  const lines: string[] = [];
  const [pointRows, pointColumns] = [closedRows ? rows : rows + 1, closedColumns ? columns : columns + 1];
  for (let i = 0; i < pointRows; ++i) {
    for (let j = 0; j < pointColumns; ++j)
      lines.push(
        `v ${at(i / rows, j / columns)
          .map((x) => x.toFixed(7))
          .join(' ')}`,
      );
  }
  for (let i = 0; i <= rows; ++i) {
    for (let j = 0; j <= columns; ++j) lines.push(`vt ${(i / rows).toFixed(6)} ${(j / columns).toFixed(6)}`);
  }
  const corner = (i: number, j: number): string =>
    `${1 + (i % pointRows) * pointColumns + (j % pointColumns)}/${1 + i * (columns + 1) + j}`;
  for (let i = 0; i < rows; ++i) {
    for (let j = 0; j < columns; ++j) {
      lines.push(`f ${corner(i, j)} ${corner(i + 1, j)} ${corner(i + 1, j + 1)} ${corner(i, j + 1)}`);
    }
  }
  return lines.join('\n') + '\n';
}

const BEAM_QUADS = 4;
const BEAM_BOUNDS = { min: [-1, -0.125, -0.125], max: [1, 0.125, 0.125] } as const;

/** A box of 4 quads along x on each of four sides, and one at each end, with texture coordinates around and along it. */
function beam(): string {
  const quads = BEAM_QUADS;
  const [low, high] = [BEAM_BOUNDS.min, BEAM_BOUNDS.max];
  const lines: string[] = [];
  const ring = [[low[1], low[2]], [high[1], low[2]], [high[1], high[2]], [low[1], high[2]]];
  for (let i = 0; i <= quads; ++i) {
    for (const [y, z] of ring) lines.push(`v ${low[0] + ((high[0] - low[0]) * i) / quads} ${y} ${z}`);
  }
  for (let i = 0; i <= quads; ++i) {
    for (let j = 0; j <= 4; ++j) lines.push(`vt ${i / quads} ${j / 4}`);
  }
  const corner = (i: number, j: number): string => `${1 + 4 * i + (j % 4)}/${1 + 5 * i + j}`;
  for (let i = 0; i < quads; ++i) {
    for (let j = 0; j < 4; ++j) lines.push(`f ${corner(i, j)} ${corner(i, j + 1)} ${corner(i + 1, j + 1)} ${corner(i + 1, j)}`);
  }
  const cap = ['1', '6', '7', '2']; // texture coordinates of one quad's corners
  for (const [first, order] of [[0, [3, 2, 1, 0]], [quads, [0, 1, 2, 3]]] as const)
    lines.push(`f ${order.map((j) => `${1 + 4 * first + j}/${cap[j]}`).join(' ')}`);
  return lines.join('\n') + '\n';
}

/** A tube along the (2, 3) torus knot. Its circles span the torus's normal and the direction across normal and knot. */
function knot(s: number, t: number): Vec3 {
  const [phi, theta, around] = [2 * TURN * s, 3 * TURN * s, TURN * t];
  const radial: Vec3 = [Math.cos(phi), Math.sin(phi), 0];
  const outward = add(scale(radial, Math.cos(theta)), [0, 0, Math.sin(theta)]);
  const along: Vec3 = [-Math.sin(phi), Math.cos(phi), 0];
  const up = add(scale(radial, -Math.sin(theta)), [0, 0, Math.cos(theta)]);
  const tangent = add(scale(along, 2 * (0.68 + 0.3 * Math.cos(theta))), scale(up, 0.9));
  const across = normalized(cross(outward, tangent));
  const center = add(scale(radial, 0.68), scale(outward, 0.3));
  return add(center, add(scale(outward, 0.16 * Math.cos(around)), scale(across, 0.16 * Math.sin(around))));
}

/** A fluted vessel, open above and below. */
function vase(s: number, t: number): Vec3 {
  const height = 1 - s;
  const profile = 0.42 + 0.26 * Math.sin(TURN * (0.78 * height + 0.02)) + 0.1 * height * height;
  const radius = profile * (1 + 0.035 * Math.sin(Math.PI * height) * Math.cos(12 * TURN * t));
  return [radius * Math.cos(TURN * t), radius * Math.sin(TURN * t), 2 * height - 1];
}

/** A gently waved sheet. */
function slab(s: number, t: number): Vec3 {
  return [2 * s - 1, 2 * t - 1, 0.06 * Math.cos(2 * TURN * s) * Math.cos(2 * TURN * t)];
}
