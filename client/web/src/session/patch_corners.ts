// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Topology } from 'latticed/v1/event_pb';
import { Encoding, NormalMode } from 'latticed/v1/view_pb';
import type { RestCorners } from '../surface/patch_source';
import { vector } from '../wire/lattice_message';
import type { LatticedServer } from '../wire/latticed_server';

/** The corners of a scene's patches, as they are now. */
export async function cornersOf(server: LatticedServer, scene: string): Promise<RestCorners> {
  const call = { headers: { 'latticed-scene': scene } };
  const view = { segments: 1, encoding: Encoding.RAW, normals: NormalMode.NONE };
  let origin: [number, number, number] = [0, 0, 0];
  let topology: Topology | undefined;
  const chunks: { index: number; data: Uint8Array }[] = [];
  for await (const { event } of server.scenes.getUpdate({ scene, view }, call)) {
    if (event.case === 'topology') topology = event.value;
    else if (event.case === 'quantisation') origin = vector(event.value.origin);
    else if (event.case === 'chunks') chunks.push(...event.value.chunks);
  }
  const corners = new Float32Array(9 * Number(topology?.patchCount ?? 0n));
  const bytes = new Uint8Array(corners.buffer);
  let at = 0;
  for (const { data } of chunks.sort((a, b) => a.index - b.index)) {
    bytes.set(data, at);
    at += data.length;
  }
  return { origin, corners: inCornerOrder(corners, topology?.pattern?.points ?? []) };
}

/** Returns the points in the order of corners. In a pattern of one segment, a point has the index 1 at its corner. */
function inCornerOrder(points: Float32Array, pattern: readonly number[]): Float32Array {
  const place = [0, 1, 2].map((point) => [0, 1, 2].findIndex((corner) => pattern[3 * point + corner] === 1));
  if (place.join() === '0,1,2') return points;
  const corners = new Float32Array(points.length);
  for (let patch = 0; patch < points.length; patch += 9) {
    place.forEach((corner, point) =>
      corners.set(points.subarray(patch + 3 * point, patch + 3 * point + 3), patch + 3 * corner));
  }
  return corners;
}
