// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** Edges of patches, numbered in the order of their first use: by patches, and in a patch by edges 0, 1, 2. */
export interface EdgeNumbers {
  /** Three per patch. */
  readonly edges: Uint32Array;
  /** How many edges the patches before a patch use; one entry more than patches. */
  readonly before: Uint32Array;
}

/** @param corners Three vertices per patch, each below `vertices`. Edge e joins corners e and (e + 1) modulo 3. */
export function numberEdges(corners: Uint32Array, vertices: number): EdgeNumbers {
  const edges = new Uint32Array(corners.length);
  const before = new Uint32Array(corners.length / 3 + 1);
  // The edges of each vertex with a higher one are a list, linked by number.
  const first = new Int32Array(vertices).fill(-1);
  const others = new Uint32Array(corners.length);
  const next = new Int32Array(corners.length);
  let count = 0;
  for (let at = 0; at < corners.length; ++at) {
    const patch = Math.floor(at / 3);
    const [p, q] = [corners[at]!, corners[3 * patch + ((at + 1) % 3)]!];
    const [low, high] = p < q ? [p, q] : [q, p];
    let edge = first[low]!;
    while (edge >= 0 && others[edge] !== high) edge = next[edge]!;
    if (edge < 0) {
      edge = count++;
      others[edge] = high;
      next[edge] = first[low]!;
      first[low] = edge;
    }
    edges[at] = edge;
    before[patch + 1] = count;
  }
  return { edges, before };
}
