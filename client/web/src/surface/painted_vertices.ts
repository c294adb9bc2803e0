// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The weights of a mesh's vertices, as a brush changes them and as the surface shows them: linear over each source triangle.
import type { DataTexture } from 'three';
import { NUMBERS_PER_POINT } from '../decode/chunk_form';
import type { DrawnPoints } from './largest_distance';
import type { PatchOrigins } from './patch_source';
import { patchTexture } from './patch_texture';

export class PaintedVertices {
  /** By the mesh's vertex, 0 to 1. Changed in place; `changed` shows it. */
  readonly weights: Float32Array;
  /** One texel per patch: the weights of its corners. */
  readonly texture: DataTexture;
  /** Per vertex, three times a patch that has it as a corner, and the number of that corner; -1 for a vertex without faces. */
  private readonly corners: Int32Array;

  /** Throws where the server does not tell the vertices of patches. */
  constructor(private readonly origins: PatchOrigins) {
    const { vertices, weights } = origins;
    if (!vertices) throw new Error('The server does not tell the vertices of this mesh.');
    const count = vertices.reduce((most, vertex) => Math.max(most, vertex + 1), 0);
    this.weights = new Float32Array(count).fill(1);
    this.corners = new Int32Array(count).fill(-1);
    vertices.forEach((vertex, at) => {
      if (weights) this.weights[vertex] = weights[at]!;
      const patch = Math.floor(at / 3);
      for (let corner = 0; corner < 3; ++corner) {
        if (origins.barycentrics[9 * patch + 3 * corner + (at % 3)] === 1) this.corners[vertex] = 3 * patch + corner;
      }
    });
    this.texture = patchTexture(vertices.length / 3, 1, (patch, out, at) => this.write(patch, out, at));
  }

  get count(): number {
    return this.weights.length;
  }

  /** World positions of the vertices where the surface is drawn; NaN for those that are not. */
  places({ places, numbers, origin, step }: DrawnPoints): Float64Array {
    const ofCorner = new Float64Array(9 * places.layout.patchCount).fill(NaN);
    places.eachPatch(1, (patch, pattern, firstPoint) => {
      pattern.corners.forEach((point, corner) => {
        const from = NUMBERS_PER_POINT * (firstPoint + point);
        for (let axis = 0; axis < 3; ++axis) ofCorner[9 * patch + 3 * corner + axis] = origin[axis]! + step * numbers[from + axis]!;
      });
    });
    const found = new Float64Array(3 * this.count).fill(NaN);
    this.corners.forEach((corner, vertex) => {
      if (corner >= 0) found.set(ofCorner.subarray(3 * corner, 3 * corner + 3), 3 * vertex);
    });
    return found;
  }

  /** Weights have changed. */
  changed(): void {
    const data = this.texture.image.data as Float32Array;
    for (let patch = 0; 3 * patch < this.origins.vertices!.length; ++patch) this.write(patch, data, 4 * patch);
    this.texture.needsUpdate = true;
  }

  private write(patch: number, out: Float32Array, at: number): void {
    const { barycentrics, vertices } = this.origins;
    for (let corner = 0; corner < 3; ++corner) {
      let weight = 0;
      for (let k = 0; k < 3; ++k) weight += barycentrics[9 * patch + 3 * corner + k]! * this.weights[vertices![3 * patch + k]!]!;
      out[at + corner] = weight;
    }
  }
}
