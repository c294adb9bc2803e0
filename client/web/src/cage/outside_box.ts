// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The box at whose faces a continuation outside the lattice ends, at rest, as lines.
import { BufferAttribute, BufferGeometry, Group, LineBasicMaterial, LineSegments } from 'three';
import { AXES, frameEdges } from '../lattice/grid';
import type { LatticeFrame } from '../lattice/lattice';
import { add, scale, sub, type Vec3 } from '../lattice/vec';

export const OUTSIDE_COLOUR = 0xff9f2e;

/** The point with these fractions of the frame's edges. */
export function placeInFrame(frame: LatticeFrame, fractions: Vec3): Vec3 {
  const edges = frameEdges(frame);
  return AXES.reduce<Vec3>((at, axis) => add(at, scale(edges[axis], fractions[axis])), frame.origin);
}

/** The middle of a side's outer face. Sides: begin and end of u, of v, of w; widths are in lengths of the frame's edges. */
export function middleOfSide(frame: LatticeFrame, widths: readonly number[], side: number): Vec3 {
  const axis = Math.floor(side / 2);
  const fractions: [number, number, number] = [0.5, 0.5, 0.5];
  fractions[axis] = side % 2 === 0 ? -widths[side]! : 1 + widths[side]!;
  return placeInFrame(frame, fractions);
}

/** The corners of the box that reaches so far beyond each side of a frame: bit 0 of a corner's index is the end of u, 1 of v, 2 of w. */
export function boxCorners(frame: LatticeFrame, widths: readonly number[]): Vec3[] {
  return Array.from({ length: 8 }, (_, corner) => placeInFrame(
    frame, AXES.map((axis) => ((corner >> axis) & 1 ? 1 + widths[2 * axis + 1]! : -widths[2 * axis]!)) as unknown as Vec3));
}

/** Pairs of corners. */
export const BOX_EDGES: readonly number[] = [0, 1, 2, 3, 4, 5, 6, 7, 0, 2, 1, 3, 4, 6, 5, 7, 0, 4, 1, 5, 2, 6, 3, 7];

export class OutsideBox {
  /** Positions inside are relative to the origin of the lattice's frame. */
  readonly object = new Group();
  private readonly positions = new BufferAttribute(new Float32Array(3 * 8), 3);
  private readonly lines = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: OUTSIDE_COLOUR, transparent: true, depthTest: false }));

  constructor() {
    this.lines.geometry.setAttribute('position', this.positions).setIndex([...BOX_EDGES]);
    this.lines.frustumCulled = false;
    this.lines.renderOrder = 20;
    this.object.add(this.lines);
  }

  place(frame: LatticeFrame, widths: readonly number[]): void {
    boxCorners(frame, widths).forEach((corner, i) => this.positions.setXYZ(i, ...sub(corner, frame.origin)));
    this.positions.needsUpdate = true;
    this.object.position.set(...frame.origin);
  }

  dispose(): void {
    this.lines.geometry.dispose();
    this.lines.material.dispose();
    this.object.removeFromParent();
  }
}
