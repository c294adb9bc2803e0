// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The edges of the deformed knot boxes. The surface's polynomial pieces meet there.
import { BufferAttribute, BufferGeometry, Color, LineSegments } from 'three';
import { knotBoxLines } from '../lattice/bspline';
import type { Lattice } from '../lattice/lattice';
import { effectiveLattice } from '../lattice/outside';
import { lineMaterial } from './cage_materials';

const STEPS = 8; // lines per edge, so that a quadratic or cubic curve looks smooth
const MOST_LINES = 40_000; // with more, edges get fewer lines, since they are computed for every edit

export class KnotBoxes {
  private readonly colour = new Color();
  readonly object = new LineSegments(new BufferGeometry(), lineMaterial(false, this.colour));

  constructor() {
    this.object.visible = false;
    this.object.frustumCulled = false;
    this.object.renderOrder = 9;
  }

  setColour(colour: Color): void {
    this.colour.copy(colour);
  }

  /** Follows the lattice. Computes nothing while the lines are not shown. */
  update(lattice: Lattice): void {
    if (!this.object.visible) return;
    const { origin } = lattice.frame;
    const edges = 3 * lattice.count;
    const lines = knotBoxLines(effectiveLattice(lattice), Math.min(Math.max(Math.floor(MOST_LINES / edges), 1), STEPS));
    const array = Float32Array.from(lines, (x, i) => x - origin[(i % 3) as 0 | 1 | 2]);
    const position = this.object.geometry.getAttribute('position') as BufferAttribute | undefined;
    if (position?.array.length === array.length) {
      position.array.set(array);
      position.needsUpdate = true;
    } else {
      this.object.geometry.dispose();
      this.object.geometry = new BufferGeometry().setAttribute('position', new BufferAttribute(array, 3));
    }
    this.object.position.set(...origin);
  }

  dispose(): void {
    this.object.geometry.dispose();
    this.object.material.dispose();
  }
}
