// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The knot boxes where the lattice folds: their deformed edges in red, and their faces in a red that lets the mesh through.
import {
  BufferAttribute, BufferGeometry, Color, DoubleSide, Group, LineSegments, Mesh, MeshBasicMaterial,
} from 'three';
import { boxGrid, type BoxPlace } from '../lattice/box_grid';
import type { Lattice } from '../lattice/lattice';
import { continuedLattice } from '../lattice/outside';
import { lineMaterial } from './cage_materials';

const RED = new Color(0xff3b30);
const STEPS = 4; // of an edge: a face has 16 quads
const MOST_BOXES = 64; // drawn: they are evaluated for every edit

export class FoldedBoxes {
  readonly object = new Group();
  private boxes: readonly BoxPlace[] = [];
  private readonly lines = [lineMaterial(false, RED), lineMaterial(true, RED)];
  private readonly veil = new MeshBasicMaterial({ color: RED, opacity: 0.14, transparent: true, depthWrite: false, side: DoubleSide });
  private readonly edges = this.lines.map((material) => new LineSegments(new BufferGeometry(), material));
  private readonly faces = new Mesh(new BufferGeometry(), this.veil);

  constructor() {
    this.lines[1].uniforms['opacity'].value = 0.5;
    for (const object of [this.faces, ...this.edges]) {
      object.frustumCulled = false;
      object.renderOrder = 20;
      this.object.add(object);
    }
    this.object.visible = false;
  }

  /** How many boxes are drawn. */
  get count(): number {
    return this.boxes.length;
  }

  setBoxes(boxes: readonly BoxPlace[], lattice: Lattice): void {
    this.boxes = boxes.slice(0, MOST_BOXES);
    this.update(lattice);
  }

  /** Follows the lattice. */
  update(lattice: Lattice): void {
    this.object.visible = this.boxes.length > 0;
    if (!this.object.visible) return;
    const continued = continuedLattice(lattice); // the server numbers boxes with those outside
    const grids = this.boxes.map((box) => boxGrid(continued, box, STEPS));
    const lines = positions(grids.flatMap(({ edges }) => edges), lattice);
    for (const edge of this.edges) replace(edge, lines);
    replace(this.faces, positions(grids.flatMap(({ triangles }) => triangles), lattice));
    this.object.position.set(...lattice.frame.origin);
  }

  dispose(): void {
    for (const { geometry } of [this.faces, ...this.edges]) geometry.dispose();
    for (const material of [this.veil, ...this.lines]) material.dispose();
  }
}

/** Relative to the frame's origin, since the GPU has float32 only. */
function positions(points: readonly (readonly [number, number, number])[], { frame: { origin } }: Lattice): Float32Array {
  return Float32Array.from(points.flat(), (x, i) => x - origin[(i % 3) as 0 | 1 | 2]);
}

function replace(object: LineSegments | Mesh, array: Float32Array): void {
  object.geometry.dispose();
  object.geometry = new BufferGeometry().setAttribute('position', new BufferAttribute(array, 3));
}
