// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Topology } from 'latticed/v1/event_pb';
import { Encoding, NormalMode } from 'latticed/v1/view_pb';
import { knotPlanes } from '../lattice/bspline';
import { AXES, domain, frameEdges } from '../lattice/grid';
import type { Lattice } from '../lattice/lattice';
import { coordinates, sub } from '../lattice/vec';
import type { PatchOrigins, PatchSource, RestCorners } from '../surface/patch_source';
import { randomId } from '../wire/ids';
import { fromLattice, vector } from '../wire/lattice_message';
import type { LatticedServer } from '../wire/latticed_server';

/**
 * A scene's patch data, from the server.
 *
 * Corners at rest come from a temporary scene: the same mesh under the same knots at rest, with one segment per patch.
 * It has the same patches in the same order. This way no mesh file is read here, whatever its format.
 */
export class ServerPatches implements PatchSource {
  constructor(
    private readonly server: LatticedServer,
    private readonly sceneId: string,
    readonly lattice: () => Lattice,
  ) {}

  async origins(topologyId: string): Promise<PatchOrigins> {
    let corners = new Uint32Array();
    let barycentrics = new Float64Array();
    const call = { headers: { 'latticed-scene': this.sceneId } };
    for await (const part of this.server.scenes.getTopology({ scene: this.sceneId, topologyId }, call)) {
      const patches = Number(part.patchCount);
      if (!corners.length) {
        corners = new Uint32Array(3 * patches);
        barycentrics = new Float64Array(9 * patches);
      }
      corners.set(part.corners, 3 * Number(part.firstPatch));
      barycentrics.set(part.barycentrics, 9 * Number(part.firstPatch));
    }
    return { corners, barycentrics };
  }

  async restCorners(): Promise<RestCorners> {
    const rest = `rest-${randomId()}`;
    const { mesh } = await this.server.scenes.getScene({ scene: this.sceneId });
    const atRest = fromLattice(this.lattice());
    atRest.controlPoints = [];
    const call = { headers: { 'latticed-scene': rest } };
    await this.server.scenes.createScene({
      sceneId: rest, mesh, lattices: [{ source: { case: 'lattice', value: atRest } }],
      labels: { 'rest-shape-of': this.sceneId }, idleTtl: { seconds: 60n } }, call);
    try {
      return await this.cornersOf(rest, call);
    } finally {
      void this.server.scenes.deleteScene({ scene: rest }, call).catch(() => undefined);
    }
  }

  boxOf(x: number, y: number, z: number): number {
    const lattice = this.lattice();
    const place = coordinates(frameEdges(lattice.frame), sub([x, y, z], lattice.frame.origin));
    let box = 0;
    let stride = 1;
    for (const axis of AXES) {
      const fraction = place[axis];
      if (!(fraction >= 0 && fraction <= 1)) return -1;
      const planes = knotPlanes(lattice, axis);
      const [begin, end] = domain(lattice, axis);
      const knot = begin + fraction * (end - begin);
      box += stride * Math.min(planes.filter((plane) => plane <= knot).length - 1, planes.length - 2);
      stride *= planes.length - 1;
    }
    return box;
  }

  private async cornersOf(scene: string, call: { headers: Record<string, string> }): Promise<RestCorners> {
    const view = { segments: 1, encoding: Encoding.RAW, normals: NormalMode.NONE };
    let origin: [number, number, number] = [0, 0, 0];
    let topology: Topology | undefined;
    const chunks: { index: number; data: Uint8Array }[] = [];
    for await (const { event } of this.server.scenes.getUpdate({ scene, view }, call)) {
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
