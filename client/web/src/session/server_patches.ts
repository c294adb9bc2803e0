// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { knotPlanes } from '../lattice/bspline';
import { AXES, domain, frameEdges } from '../lattice/grid';
import type { Lattice } from '../lattice/lattice';
import { coordinates, sub } from '../lattice/vec';
import type { PatchOrigins, PatchSource, RestCorners } from '../surface/patch_source';
import { LONG_CALL_MS } from '../wire/deadlines';
import { randomId } from '../wire/ids';
import { fromLattice } from '../wire/lattice_message';
import type { LatticedServer } from '../wire/latticed_server';
import { cornersOf } from './patch_corners';

/**
 * A scene's patch data, from the server.
 *
 * Corners at rest come from a temporary scene: the same mesh under the same lattices at rest, with one segment per patch.
 * It has the same patches in the same order. This way no mesh file is read here, whatever its format.
 */
export class ServerPatches implements PatchSource {
  constructor(
    private readonly server: LatticedServer,
    private readonly sceneId: string,
    readonly lattice: () => Lattice,
    private readonly lattices: () => readonly Lattice[],
  ) {}

  async origins(topologyId: string): Promise<PatchOrigins> {
    let corners = new Uint32Array();
    let barycentrics = new Float64Array();
    let vertices: Uint32Array | undefined;
    let weights: Float32Array | undefined;
    const call = { headers: { 'latticed-scene': this.sceneId } };
    for await (const part of this.server.scenes.getTopology({ scene: this.sceneId, topologyId }, call)) {
      const patches = Number(part.patchCount);
      if (!corners.length) {
        corners = new Uint32Array(3 * patches);
        barycentrics = new Float64Array(9 * patches);
      }
      if (part.vertices.length > 0) (vertices ??= new Uint32Array(3 * patches)).set(part.vertices, 3 * Number(part.firstPatch));
      if (part.weights.length > 0) (weights ??= new Float32Array(3 * patches)).set(part.weights, 3 * Number(part.firstPatch));
      corners.set(part.corners, 3 * Number(part.firstPatch));
      barycentrics.set(part.barycentrics, 9 * Number(part.firstPatch));
    }
    return { corners, barycentrics, vertices, weights };
  }

  async restCorners(): Promise<RestCorners> {
    const rest = `rest-${randomId()}`;
    const { mesh } = await this.server.scenes.getScene({ scene: this.sceneId });
    const atRest = this.lattices().map((lattice) => ({ ...fromLattice(lattice), controlPoints: [] }));
    const call = { headers: { 'latticed-scene': rest }, timeoutMs: LONG_CALL_MS };
    await this.server.scenes.createScene({
      sceneId: rest, mesh, lattices: atRest.map((value) => ({ source: { case: 'lattice' as const, value } })),
      labels: { 'rest-shape-of': this.sceneId }, idleTtl: { seconds: 60n } }, call);
    try {
      return await cornersOf(this.server, rest);
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
}
