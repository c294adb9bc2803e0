// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Lattice } from '../lattice/lattice';
import { OutsideMap } from '../lattice/outside';
import { PlacedPoints } from '../lattice/placed_points';
import type { PatchOrigins, RestCorners } from './patch_source';

/**
 * The mesh under an ordinary lattice (Sederberg & Parry 1986), which moves vertices only: each face of the source stays a
 * flat triangle. A patch lies in one face, so its part of that triangle follows from the face's moved vertices and the
 * barycentrics of its corners.
 */
export class VerticesOnly {
  private readonly vertices: Float64Array;
  /** Per corner of a face, the number of its vertex. */
  private readonly vertexOf: Int32Array;
  private placed: { readonly lattice: Lattice; readonly outside: OutsideMap; readonly points: PlacedPoints } | undefined;

  constructor(private readonly origins: PatchOrigins, private readonly rest: RestCorners) {
    const { vertices, vertexOf } = sourceVertices(origins, rest);
    this.vertices = vertices;
    this.vertexOf = vertexOf;
  }

  /** Nine per patch, like RestCorners and about the same origin: the corners of all patches in the flat triangles. */
  corners(lattice: Lattice): Float32Array {
    if (this.placed?.lattice !== lattice) {
      const outside = new OutsideMap(lattice);
      this.placed = { lattice, outside, points: new PlacedPoints(outside.continued, this.vertices) };
    }
    const moved = this.placed.points.deformed(this.placed.outside.points(lattice.points, lattice.strength));
    const { corners, barycentrics } = this.origins;
    const { origin } = this.rest;
    const out = new Float32Array(barycentrics.length);
    for (let patch = 0; patch < corners.length; patch += 3) {
      for (let corner = 0; corner < 3; ++corner) {
        const at = 3 * (patch + corner);
        for (let k = 0; k < 3; ++k) {
          const vertex = 3 * this.vertexOf[corners[patch + k]];
          const share = barycentrics[at + k];
          for (let axis = 0; axis < 3; ++axis) out[at + axis] += share * (moved[vertex + axis] - origin[axis]);
        }
      }
    }
    return out;
  }
}

/** Every vertex of a face is the corner of a patch. Vertices at the same place are one. World positions. */
function sourceVertices({ corners, barycentrics }: PatchOrigins, { origin, corners: rest }: RestCorners): {
  vertices: Float64Array; vertexOf: Int32Array;
} {
  const vertexOf = new Int32Array(corners.reduce((most, corner) => Math.max(most, corner + 1), 0)).fill(-1);
  const known = new Map<string, number>();
  const vertices: number[] = [];
  for (let at = 0; at < barycentrics.length; at += 3) {
    const k = [0, 1, 2].find((i) => barycentrics[at + i] === 1);
    if (k === undefined) continue;
    const [x, y, z] = [rest[at], rest[at + 1], rest[at + 2]];
    const key = `${x} ${y} ${z}`;
    let vertex = known.get(key);
    if (vertex === undefined) {
      known.set(key, (vertex = known.size));
      vertices.push(origin[0] + x, origin[1] + y, origin[2] + z);
    }
    vertexOf[corners[3 * Math.floor(at / 9) + k]] = vertex;
  }
  if (corners.some((corner) => vertexOf[corner] < 0)) throw new Error('A vertex of the mesh is the corner of no patch.');
  return { vertices: Float64Array.from(vertices), vertexOf };
}
