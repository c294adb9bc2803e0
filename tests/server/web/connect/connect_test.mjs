// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// usage: node connect_test.mjs LATTICED PROTOSET
// Starts the daemon and calls it through connect-web: unary, server streaming, metadata, error
// details, deadline, abort. Services and messages come from the descriptor set.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { createFileRegistry, fromBinary } from '@bufbuild/protobuf';
import { FileDescriptorSetSchema } from '@bufbuild/protobuf/wkt';
import { Code, ConnectError, createClient } from '@connectrpc/connect';
import { createGrpcWebTransport } from '@connectrpc/connect-web';

const [latticed, protoset] = process.argv.slice(2);
const registry = createFileRegistry(fromBinary(FileDescriptorSetSchema, readFileSync(protoset)));

async function start() {
  const flags = ['--listen', '127.0.0.1:0', '--http', '127.0.0.1:0', '--node', 'test-node', '--max-watchers', '1'];
  const server = spawn(latticed, [...flags, '--backend', 'cpu', '--threads', '1', '--drain-delay', '0s'], {
    stdio: ['ignore', 'ignore', 'pipe'],
  });
  const url = await new Promise((resolve, reject) => {
    let log = '';
    server.stderr.setEncoding('utf8').on('data', (text) => {
      log += text;
      const found = log.match(/ http=(\S+)/);
      if (found) resolve(`http://${found[1]}`);
    });
    server.on('exit', () => reject(new Error(`latticed ended:\n${log}`)));
  });
  return { server, url };
}

// Until `ends` has a result that is not undefined; what has ended may have its place on the server for a moment.
async function becomes(ends, deadline = Date.now() + 60_000) {
  for (;;) {
    const result = await ends();
    if (result !== undefined) return result;
    assert.ok(Date.now() < deadline, 'not in time');
  }
}

const failure = (promise) => promise.then(() => assert.fail('was not refused'), ConnectError.from);

async function collect(stream) {
  const events = [];
  for await (const { event } of stream) events.push(event);
  return events;
}

async function upload(meshes) {
  const data = new TextEncoder().encode('v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n');
  const header = { name: 'quad', format: 1, totalBytes: BigInt(data.length) };
  const { uploadId } = await meshes.beginUpload({ header });
  await meshes.appendUpload({ uploadId, offset: 0n, data });
  return meshes.finishUpload({ uploadId });
}

async function test(url) {
  const transport = createGrpcWebTransport({ baseUrl: url });
  const client = (name) => createClient(registry.getService(`latticed.v1.${name}`), transport);
  const scenes = client('SceneService');

  let head, trailer;
  const info = await client('ServerService').getServerInfo({}, {
    headers: { 'latticed-request-id': 'from-connect' },
    onHeader: (headers) => (head = headers),
    onTrailer: (trailers) => (trailer = trailers),
  });
  assert.equal(info.node, 'test-node');
  assert.equal(head.get('latticed-request-id'), 'from-connect');
  assert.equal(trailer.get('latticed-node'), 'test-node');

  const mesh = await upload(client('MeshService'));
  assert.equal(mesh.faces, 1n);
  const scene = 'connect-scene';
  await scenes.createScene({ sceneId: scene, mesh: mesh.id });
  const update = await collect(scenes.getUpdate({ scene }));
  assert.equal(update.at(-1).case, 'updateEnd');
  assert.ok(update.some((event) => event.case === 'chunks' && event.value.chunks[0].data.length > 0));

  const refused = await failure(scenes.getScene({ scene: 'no-such-scene' }));
  assert.equal(refused.code, Code.NotFound);
  const why = refused.details.find((detail) => detail.type === 'google.rpc.ErrorInfo');
  assert.match(Buffer.from(why.value).toString('latin1'), /NOT_FOUND.*latticed/s);

  const late = await failure(collect(scenes.watch({ scene, editorId: 'late' }, { timeoutMs: 200 })));
  assert.equal(late.code, Code.DeadlineExceeded);

  const abort = new AbortController();
  const { watching, first } = await becomes(async () => {
    const watching = scenes.watch({ scene, editorId: 'first' }, { signal: abort.signal })[Symbol.asyncIterator]();
    const first = await watching.next().catch(ConnectError.from);
    return first.code === Code.ResourceExhausted ? undefined : { watching, first };
  });
  assert.equal(first.value?.event.case, 'hello', String(first));
  const second = (timeoutMs) => failure(collect(scenes.watch({ scene, editorId: 'second' }, { timeoutMs })));
  assert.equal((await second(60_000)).code, Code.ResourceExhausted, 'the one watcher is there');
  abort.abort();
  const rest = async () => { while (!(await watching.next()).done); };  // what has come is still read
  assert.equal((await failure(rest())).code, Code.Canceled);
  const code = await becomes(async () => {
    const { code } = await second(200);
    return code === Code.ResourceExhausted ? undefined : code;
  });
  assert.equal(code, Code.DeadlineExceeded, 'its place was given back');
}

const { server, url } = await start();
try {
  await test(url);
  console.log(`connect-web in Node ${process.version}: all well`);
} finally {
  server.kill();
}
