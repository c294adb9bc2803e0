// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Foreign pages in Chromium, of the same site (another port) and of another, that try to use this computer's server.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer.
import assert from 'node:assert/strict';
import { createServer, type Server } from 'node:http';
import type { AddressInfo } from 'node:net';
import { after, test } from 'node:test';
import { create, toBinary } from '@bufbuild/protobuf';
import { EditBatchSchema } from 'latticed/v1/edit_pb';
import { MeshFormat } from 'latticed/v1/mesh_pb';
import type { Page } from 'playwright-core';
import { randomId } from '@src/wire/ids';
import { uploadMesh } from '@src/wire/upload';
import { browser, direct, OBJ, page, server, until, useStage } from '../support/stage';

const SCENE = 'a-scene-of-this-computer';

let foreign: Server;
let edit: number[]; // a framed message that moves a control point

/** Every way in which a page can reach a server. An attempt returns its outcome. */
const WAYS: Record<string, { attempt: (page: Page) => Promise<string>; refused: string }> = {
  'fetch with CORS': { attempt: (page) => post(page, 'cors'), refused: 'TypeError: Failed to fetch' },
  'fetch without CORS': { attempt: (page) => post(page, 'no-cors'), refused: 'opaque' },
  'an image': { attempt: loadImage, refused: 'no image' },
  'a form': { attempt: submitForm, refused: 'answered' },
  'a WebSocket': { attempt: openSocket, refused: 'closed with 1006' },
};

function post(page: Page, mode: RequestMode): Promise<string> {
  return page.evaluate(
    ([url, bytes, how]) =>
      fetch(url, {
        method: 'POST', mode: how, body: Uint8Array.from(bytes), headers: { 'content-type': 'application/grpc-web+proto' },
      }).then(async (answer) => `${answer.type}${/grpc-status: *(\d+)/.exec(await answer.text())?.[0] ?? ''}`, String),
    [`${server.origin}/latticed.v1.SceneService/ApplyEdits`, edit, mode] as const,
  );
}

function loadImage(page: Page): Promise<string> {
  return page.evaluate((url) => new Promise<string>((resolve) => {
    const image = new Image();
    image.onload = () => resolve('an image');
    image.onerror = () => resolve('no image');
    image.src = url;
  }), `${server.origin}/export/${SCENE}.obj`);
}

/** Submits a form into a frame, so that the page stays. */
function submitForm(page: Page): Promise<string> {
  return page.evaluate((url) => new Promise<string>((resolve) => {
    const frame = document.createElement('iframe');
    const form = document.createElement('form');
    Object.assign(frame, { name: 'answer' });
    Object.assign(form, { method: 'POST', action: url, target: 'answer', enctype: 'text/plain' });
    document.body.append(frame, form);
    frame.onload = () => resolve('answered');
    form.submit();
  }), `${server.origin}/latticed.v1.SceneService/ApplyEdits`);
}

function openSocket(page: Page): Promise<string> {
  return page.evaluate((url) => new Promise<string>((resolve) => {
    const socket = new WebSocket(url, 'latticed.v1');
    socket.onopen = () => resolve('open');
    socket.onclose = ({ code }) => resolve(`closed with ${code}`);
  }), `${server.origin.replace('http', 'ws')}/ws/latticed.v1.SceneService/Deform?latticed-scene=${SCENE}`);
}

async function revision(): Promise<bigint> {
  return (await direct.scenes.getScene({ scene: SCENE })).revision;
}

/** The number of requests that the server has logged as stopped. */
function stopped(): number {
  return server.logged.split('\n').filter((line) => line.includes('HTTP request stopped')).length;
}

useStage({
  begin: async () => {
    const mesh = await uploadMesh(direct, { format: MeshFormat.OBJ }, new Blob([OBJ]));
    const { structureId } = await direct.scenes.createScene({ mesh: mesh.id, sceneId: SCENE });
    const message = toBinary(EditBatchSchema, create(EditBatchSchema, {
      scene: SCENE, editorId: randomId(), sequence: 1n, structureId,
      edits: [{ edit: { case: 'moveControlPoints', value: { indices: [0], offset: { z: 1 } } } }],
    }));
    edit = [0, 0, 0, message.length >> 8, message.length & 255, ...message];
    foreign = createServer((_, answer) => answer.setHeader('content-type', 'text/html').end('<!doctype html><body>'));
    await new Promise<void>((resolve) => foreign.listen(0, '127.0.0.1', resolve));
  },
});
after(() => foreign?.close());

for (const host of ['127.0.0.1', 'localhost']) {
  test(`a page of another port of ${host} changes nothing, and the log says that it was stopped`, async () => {
    const stranger = await browser.newPage();
    await stranger.goto(`http://${host}:${(foreign.address() as AddressInfo).port}/`);
    for (const [way, { attempt, refused }] of Object.entries(WAYS)) {
      const lines = stopped();
      assert.equal(await attempt(stranger), refused, way);
      await until(() => stopped() > lines, () => `nothing was logged of ${way}`);
    }
    assert.equal(await revision(), 0n);
    await stranger.close();
  });
}

test("the server's own page does the same, and it is done", async () => {
  assert.equal(await WAYS['a WebSocket'].attempt(page), 'open');
  assert.equal(await WAYS['fetch with CORS'].attempt(page), 'basicgrpc-status: 0');

  assert.equal(await revision(), 1n);
});
