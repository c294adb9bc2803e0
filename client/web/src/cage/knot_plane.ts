// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A knot plane that is not there yet: the sheet of the deformed volume where it would be, above everything else.
import { BufferAttribute, BufferGeometry, DoubleSide, Group, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial } from 'three';
import { evaluate } from '../lattice/bspline';
import { AXES, domain, type Axis } from '../lattice/grid';
import type { Lattice } from '../lattice/lattice';
import type { MutableVec3 } from '../lattice/vec';

const STEPS = 16; // quads along each side
const COLOUR = 0xff9f2e;

export class KnotPlane {
  /** Positions inside are relative to the origin of the lattice's frame. */
  readonly object = new Group();
  private readonly positions = new BufferAttribute(new Float32Array(3 * (STEPS + 1) ** 2), 3);
  private readonly sheet = new Mesh(new BufferGeometry(), new MeshBasicMaterial({
    color: COLOUR, transparent: true, opacity: 0.3, side: DoubleSide, depthTest: false, depthWrite: false }));
  private readonly edge = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: COLOUR, transparent: true, depthTest: false }));

  constructor() {
    this.sheet.geometry.setAttribute('position', this.positions).setIndex(quads());
    this.edge.geometry.setAttribute('position', this.positions).setIndex(border());
    for (const object of [this.sheet, this.edge]) {
      object.frustumCulled = false;
      object.renderOrder = 20;
    }
    this.object.add(this.sheet, this.edge);
  }

  /** Puts the plane across `axis` at a knot. */
  place(lattice: Lattice, axis: Axis, knot: number): void {
    const { origin } = lattice.frame;
    const [a, b] = AXES.filter((each) => each !== axis);
    const [[aBegin, aEnd], [bBegin, bEnd]] = [domain(lattice, a), domain(lattice, b)];
    const parameter: MutableVec3 = [0, 0, 0];
    parameter[axis] = knot;
    for (let i = 0, at = 0; i <= STEPS; ++i) {
      for (let j = 0; j <= STEPS; ++j, ++at) {
        parameter[a] = aBegin + (i / STEPS) * (aEnd - aBegin);
        parameter[b] = bBegin + (j / STEPS) * (bEnd - bBegin);
        const p = evaluate(lattice, parameter);
        this.positions.setXYZ(at, p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]);
      }
    }
    this.positions.needsUpdate = true;
    this.object.position.set(...origin);
  }

  dispose(): void {
    for (const { geometry, material } of [this.sheet, this.edge]) {
      geometry.dispose();
      material.dispose();
    }
    this.object.removeFromParent();
  }
}

function quads(): number[] {
  const row = STEPS + 1;
  const index: number[] = [];
  for (let i = 0; i < STEPS; ++i) {
    for (let j = 0; j < STEPS; ++j) {
      const at = i * row + j;
      index.push(at, at + row, at + 1, at + 1, at + row, at + row + 1);
    }
  }
  return index;
}

function border(): number[] {
  const row = STEPS + 1;
  const last = STEPS * row;
  return Array.from({ length: STEPS }, (_, i) =>
    [i, i + 1, last + i, last + i + 1, i * row, (i + 1) * row, i * row + STEPS, (i + 1) * row + STEPS]).flat();
}
