// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A small picture of a mesh in the lattice that a dialog asks for, and of the box at which its outside ends, as the view would first
// show them. It is drawn in 2D, triangle by triangle from behind; a mesh that is not known yet is left out.
import { BOX_EDGES, boxCorners, OUTSIDE_COLOUR } from '../../cage/outside_box';
import { gridLines } from '../../lattice/index_sets';
import type { Lattice } from '../../lattice/lattice';
import { cross, dot, normalized, sub, type Basis, type Vec3 } from '../../lattice/vec';
import { uprightDirection, type UpAxis } from '../../state/units';
import type { RestCorners } from '../../surface/patch_source';
import { h } from '../dom';

const WIDTH = 316; // CSS pixels
const HEIGHT = 190;
const MARGIN = 12;
const FROM: Vec3 = [3, -4, 2.4];
const DISC = 2.2;

interface Triangle {
  readonly corners: readonly [Vec3, Vec3, Vec3];
  readonly depth: number;
  readonly shade: number;
}

export class FitPreview {
  private readonly ratio = Math.min(window.devicePixelRatio, 2);
  readonly element = h('canvas', {
    class: 'fit-preview', role: 'img', 'aria-label': 'The mesh in its lattice', width: WIDTH * this.ratio, height: HEIGHT * this.ratio });
  private mesh: RestCorners | undefined;

  setMesh(mesh: RestCorners): void {
    this.mesh = mesh;
  }

  show(lattice: Lattice, up: UpAxis): void {
    const view = viewWith(up);
    const turned = (p: Vec3): Vec3 => [dot(view[0], p), -dot(view[1], p), dot(view[2], p)];
    const points = Array.from({ length: lattice.count }, (_, i) => turned([...lattice.points.subarray(3 * i, 3 * i + 3)] as unknown as Vec3));
    const box = lattice.outside ? boxCorners(lattice.frame, lattice.outside.widths).map(turned) : [];
    const place = fitted([...points, ...box]);
    const context = this.element.getContext('2d')!;
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    context.clearRect(0, 0, WIDTH, HEIGHT);
    for (const triangle of this.triangles(view, turned)) paint(context, triangle, place);
    this.drawCage(context, lattice, points.map(place));
    if (box.length > 0) drawBox(context, box.map(place));
  }

  private triangles(view: Basis, turned: (p: Vec3) => Vec3): Triangle[] {
    if (this.mesh === undefined) return [];
    const { origin, corners } = this.mesh;
    const found: Triangle[] = [];
    for (let at = 0; at < corners.length; at += 9) {
      const [a, b, c] = [at, at + 3, at + 6].map((i) =>
        [origin[0] + corners[i], origin[1] + corners[i + 1], origin[2] + corners[i + 2]] as const);
      const shade = Math.abs(dot(normalized(cross(sub(b, a), sub(c, a))), view[2])); // light from the eye, on both sides
      const shown = [turned(a), turned(b), turned(c)] as const;
      found.push({ corners: shown, depth: shown[0][2] + shown[1][2] + shown[2][2], shade });
    }
    return found.sort((a, b) => a.depth - b.depth);
  }

  private drawCage(context: CanvasRenderingContext2D, { size }: Lattice, places: readonly Vec3[]): void {
    const { color } = getComputedStyle(this.element);
    const lines = gridLines(size, () => false);
    context.strokeStyle = context.fillStyle = color;
    context.lineWidth = 0.6;
    drawLines(context, lines, places);
    context.beginPath();
    for (const [x, y] of places) {
      context.moveTo(x + DISC, y);
      context.arc(x, y, DISC, 0, 2 * Math.PI);
    }
    context.fill();
  }
}

function drawBox(context: CanvasRenderingContext2D, corners: readonly Vec3[]): void {
  context.strokeStyle = `#${OUTSIDE_COLOUR.toString(16)}`;
  context.lineWidth = 1;
  drawLines(context, BOX_EDGES, corners);
}

/** Lines between pairs of places. */
function drawLines(context: CanvasRenderingContext2D, pairs: ArrayLike<number>, places: readonly Vec3[]): void {
  context.beginPath();
  for (let i = 0; i < pairs.length; i += 2) {
    const [from, to] = [places[pairs[i]!]!, places[pairs[i + 1]!]!];
    context.moveTo(from[0], from[1]);
    context.lineTo(to[0], to[1]);
  }
  context.stroke();
}

/** Right, up and towards the viewer. */
function viewWith(up: UpAxis): Basis {
  const towards = normalized(uprightDirection(FROM, up));
  const right = normalized(cross(uprightDirection([0, 0, 1], up), towards));
  return [right, cross(towards, right), towards];
}

/** A map that puts all points into the picture. */
function fitted(points: readonly Vec3[]): (p: Vec3) => Vec3 {
  const [left, top] = [0, 1].map((axis) => points.reduce((least, p) => Math.min(least, p[axis]), Infinity));
  const [right, bottom] = [0, 1].map((axis) => points.reduce((most, p) => Math.max(most, p[axis]), -Infinity));
  const scale = Math.min((WIDTH - 2 * MARGIN) / (right - left || 1), (HEIGHT - 2 * MARGIN) / (bottom - top || 1));
  return ([x, y, z]) => [WIDTH / 2 + scale * (x - (left + right) / 2), HEIGHT / 2 + scale * (y - (top + bottom) / 2), z];
}

function paint(context: CanvasRenderingContext2D, { corners, shade }: Triangle, place: (p: Vec3) => Vec3): void {
  const grey = Math.round(90 + 120 * shade);
  context.fillStyle = context.strokeStyle = `rgb(${grey} ${grey} ${grey + 10})`;
  context.lineWidth = 0.5; // covers the gaps between neighbours
  context.beginPath();
  for (const corner of corners) {
    const [x, y] = place(corner);
    context.lineTo(x, y);
  }
  context.closePath();
  context.fill();
  context.stroke();
}
