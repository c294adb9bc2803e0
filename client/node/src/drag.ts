// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// usage: [LATTICED_SERVER=ADDRESS] node dist/drag.js IN.obj
// Uploads a mesh, lifts the top of the lattice around it by 1 in one gesture of ten steps, and prints
// of each update its chunks, its bytes, and the top of the decoded surface.
import { randomUUID } from 'node:crypto';
import { DracoPoints } from './draco_points.js';
import type { DeformRequest } from './generated/latticed/v1/DeformRequest.js';
import type { EditBatch } from './generated/latticed/v1/EditBatch.js';
import type { Scene__Output } from './generated/latticed/v1/Scene.js';
import { about, call, connect, type Services } from './services.js';
import { Surface } from './surface.js';
import { upload } from './upload.js';

const STEPS = 10;

// Moves the top layer of control points by `height` from where it was when the gesture began.
function lift(surface: Surface, step: number): EditBatch {
  const layer = surface.size[0] * surface.size[1];
  const top = layer * (surface.size[2] - 1);
  return {
    sequence: step,
    structureId: surface.structureId,
    gestureId: 'lift',
    gesturePhase: step === STEPS ? 'GESTURE_PHASE_COMMIT' : 'GESTURE_PHASE_UPDATE',
    edits: [{
      moveControlPoints: {
        indices: Array.from({ length: layer }, (_, i) => top + i),
        offset: { x: 0, y: 0, z: step / STEPS },
      },
    }],
  };
}

// Sends each step when the update that holds the previous step has come.
async function drag({ scenes }: Services, scene: Scene__Output): Promise<void> {
  const surface = new Surface(await DracoPoints.create());
  const stream = scenes.Deform(about(scene.id));
  const send = (request: DeformRequest) => { if (stream.writable) stream.write(request); };
  send({
    watch: { scene: scene.id, editorId: randomUUID(), view: { encoding: 'ENCODING_DRACO_POINTS' } },
  });
  let step = 0;
  for await (const event of stream) {
    if (event.heartbeat) send({ heartbeat: {} });
    const status = event.editResult?.status;
    if (status?.code) throw new Error(`edit ${event.editResult?.sequence} was refused: ${status.message}`);
    const update = await surface.take(event);
    if (!update) continue;
    send({ control: { ackedUpdateId: update.end.updateId } });
    if (update.end.appliedSequence < step) continue;
    const top = surface.bounds().high[2];
    console.log(`revision ${update.end.revision}: ${update.chunks} chunks, ${update.bytes} bytes, ` +
      `${surface.points} points, up to ${top}`);
    if (step < STEPS) send({ edit: lift(surface, ++step) });
    else stream.end();  // no more edits: the server ends the stream
  }
}

async function main(path: string): Promise<void> {
  const services = connect(process.env.LATTICED_SERVER ?? '127.0.0.1:50151');
  const mesh = await upload(services, path);
  const sceneId = randomUUID();
  const scene = await call<Scene__Output>((done) =>
    services.scenes.CreateScene({ sceneId, mesh: mesh.id }, about(sceneId), done));
  console.log(`${scene.patches} patches in ${scene.chunks} chunks`);
  await drag(services, scene);
  await call((done) => services.scenes.DeleteScene({ scene: scene.id }, about(scene.id), done));
}

const [path] = process.argv.slice(2);
if (path === undefined) {
  console.error('usage: [LATTICED_SERVER=ADDRESS] node dist/drag.js IN.obj');
  process.exit(2);
}
main(path).catch((error: unknown) => {
  console.error(`drag: ${error instanceof Error ? error.message : error}`);
  process.exit(1);
});
