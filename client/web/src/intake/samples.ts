// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Meshes made by formula, for a first look without a file. About two units across, z up, with texture coordinates.
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

export const SAMPLES = {
  knot: {
    label: 'Knot',
    note: '5,760 quads',
    grid: { rows: 240, columns: 24, at: knot, closedRows: true, closedColumns: true },
  },
  vase: {
    label: 'Vase',
    note: '4,608 quads',
    grid: { rows: 48, columns: 96, at: vase, closedRows: false, closedColumns: true },
  },
  slab: {
    label: 'Slab',
    note: '1,600 quads',
    grid: { rows: 40, columns: 40, at: slab, closedRows: false, closedColumns: false },
  },
} as const satisfies Record<string, { label: string; note: string; grid: Grid }>;

export type SampleName = keyof typeof SAMPLES;

/** A sample as the OBJ file that a person could have dropped. */
export function sampleFile(name: SampleName): MeshFile {
  return { name: `${name}.obj`, format: 'obj', content: new Blob([objText(SAMPLES[name].grid)]) };
}

function objText({ rows, columns, at, closedRows, closedColumns }: Grid): string {
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
