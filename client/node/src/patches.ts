// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// usage: [LATTICED_SERVER=ADDRESS] node dist/patches.js IN.obj OUT.ply [TOLERANCE]
// Uploads a mesh, lifts the top of the lattice around it by 1, and makes the surface by itself: from the patch plan,
// the lattice, and one byte for each edge. Its triangles are within TOLERANCE (0.0001, world units) of the exact surface.
import { randomUUID } from 'node:crypto';
import { effectivePoints } from './effective_points.js';
import { evaluatePatches } from './evaluate_patches.js';
import type { Lattice__Output } from './generated/latticed/v1/Lattice.js';
import type { LatticeState__Output } from './generated/latticed/v1/LatticeState.js';
import type { Scene__Output } from './generated/latticed/v1/Scene.js';
import { PatchPlan } from './patch_plan.js';
import { writePly } from './ply.js';
import { about, call, connect, type Services } from './services.js';
import { upload } from './upload.js';

const HEIGHT = 1;

interface Update {
  revision: number;
  topologyId: string;
  lattice: Lattice__Output;
  edgeBytes: Buffer;
}

async function liftTop({ scenes }: Services, scene: string): Promise<void> {
  const state = await call<LatticeState__Output>((done) => scenes.GetLattice({ scene }, about(scene), done));
  const { u, v, w } = state.lattice!.size!;
  const top = Array.from({ length: u * v }, (_, i) => u * v * (w - 1) + i);
  const edits = [{ moveControlPoints: { indices: top, offset: { x: 0, y: 0, z: HEIGHT } } }];
  await call((done) => scenes.ApplyEdits(
    { scene, editorId: randomUUID(), sequence: 1, structureId: state.structureId, edits }, about(scene), done));
}

async function getUpdate({ scenes }: Services, scene: string): Promise<Update> {
  const view = { encoding: 'ENCODING_PATCHES', normals: 'NORMAL_MODE_NONE' } as const;
  const update: Partial<Update> = {};
  const bounds: [firstEdge: number, bytes: Buffer][] = [];
  for await (const event of scenes.GetUpdate({ scene, view }, about(scene))) {
    const state = event.patchLattice?.state ?? event.latticeState;
    if (state?.lattice && state.index === (state.indexes[0] ?? 0)) {  // of several, the first, and then their sum
      update.lattice = { ...state.lattice, controlPoints: effectivePoints(state) };
    }
    if (event.topology) update.topologyId = event.topology.topologyId;
    for (const { firstEdge, data } of event.chunks?.chunks ?? []) bounds.push([firstEdge, data]);
    if (event.updateEnd) update.revision = event.updateEnd.revision;
  }
  if (update.revision === undefined) throw new Error('the server sent no complete update');
  bounds.sort(([first], [second]) => first - second);  // an update of all edges has no gap
  return { ...update, edgeBytes: Buffer.concat(bounds.map(([, bytes]) => bytes)) } as Update;
}

async function main(input: string, output: string, tolerance: number): Promise<void> {
  const services = connect(process.env.LATTICED_SERVER ?? '127.0.0.1:50151');
  const mesh = await upload(services, input);
  const scene = randomUUID();
  await call<Scene__Output>((done) =>
    services.scenes.CreateScene({ sceneId: scene, mesh: mesh.id }, about(scene), done));
  await liftTop(services, scene);
  const { revision, topologyId, lattice, edgeBytes } = await getUpdate(services, scene);
  const plan = await PatchPlan.read(
    services.scenes.GetPatchPlan({ scene, topologyId, normals: 'NORMAL_MODE_NONE' }, about(scene)));
  const surface = evaluatePatches(plan, lattice, edgeBytes, tolerance);
  writePly(output, surface);
  const top = surface.points.reduce((highest, point) => Math.max(highest, point[2]), -Infinity);
  console.log(`revision ${revision}: ${plan.patches} patches, ${edgeBytes.length} bytes, ` +
    `${surface.triangles.length / 3} triangles within ${tolerance}, up to ${top}`);
  await call((done) => services.scenes.DeleteScene({ scene }, about(scene), done));
}

const [input, output, tolerance = '0.0001'] = process.argv.slice(2);
if (input === undefined || output === undefined || !(Number(tolerance) > 0)) {
  console.error('usage: [LATTICED_SERVER=ADDRESS] node dist/patches.js IN.obj OUT.ply [TOLERANCE]');
  process.exit(2);
}
main(input, output, Number(tolerance)).catch((error: unknown) => {
  console.error(`patches: ${error instanceof Error ? error.message : error}`);
  process.exit(1);
});
