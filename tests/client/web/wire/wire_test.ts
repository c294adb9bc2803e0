// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';
import { create } from '@bufbuild/protobuf';
import { Code, ConnectError, createRouterTransport, type ServiceImpl } from '@connectrpc/connect';
import { ErrorInfoSchema } from 'google/rpc/error_info_pb';
import { EditResultSchema, type EditBatch } from 'latticed/v1/edit_pb';
import { SceneEventSchema, type SceneEvent } from 'latticed/v1/event_pb';
import { ControlWatchResponseSchema, SceneService, type ControlWatchRequest } from 'latticed/v1/scene_pb';
import { downloadExport } from '@src/wire/export_download';
import { randomUuid } from '@src/wire/ids';
import { LatticedServer } from '@src/wire/latticed_server';
import { ServerError } from '@src/wire/server_error';
import { WatchStream } from '@src/wire/watch_stream';
import { bytes, inWords } from '@src/wire/words';
import { until } from '../support/session_fixture';

/** A stream over gRPC-Web to the test's service. Its watch says hello after `isOpen`, and lasts until it is closed. */
class Watched {
  readonly events: SceneEvent['event'][] = [];
  readonly ends: (ServerError | undefined)[] = [];
  /** The scene that each watch named, in its header and in its request. */
  readonly scenes: (string | null)[] = [];
  readonly stream: WatchStream;

  constructor(t: TestContext, calls: Partial<ServiceImpl<typeof SceneService>>, isOpen: Promise<unknown> = Promise.resolve()) {
    const { scenes } = this;
    const transport = createRouterTransport(({ service }) => service(SceneService, {
      watch: async function* ({ scene }, context) {
        scenes.push(context.requestHeader.get('latticed-scene'), scene);
        await isOpen;
        yield create(SceneEventSchema, { event: { case: 'hello', value: { watchId: 'w-1' } } });
        await new Promise((resolve) => context.signal.addEventListener('abort', resolve));
      },
      ...calls,
    }));
    this.stream = new WatchStream(new LatticedServer('http://test', undefined, transport), { scene: 'scene-0001', editorId: 'e' },
      { event: ({ event }) => this.events.push(event), end: (error) => this.ends.push(error) });
    t.after(() => this.stream.close());
  }
}

test('what a socket closes with is the status of the stream', () => {
  const gone = ServerError.fromClose(4005, 'NOT_FOUND: no scene abc: it was deleted');
  assert.deepEqual([gone.code, gone.reason, gone.message, gone.isPassing],
    [Code.NotFound, 'NOT_FOUND', 'no scene abc: it was deleted', false]);

  const cut = ServerError.fromClose(1006, '');
  assert.deepEqual([cut.code, cut.reason, cut.isPassing], [Code.Unavailable, '', true]);
  assert.equal(inWords(cut), 'The server cannot be reached.');
  assert.equal(inWords(new ConnectError('aborted', Code.DeadlineExceeded)), 'The server did not answer in time.');
});

test('errors are sentences: too large says how much is free, a role which one it takes, a bad file why', () => {
  const needs = 'the upload needs 5000000000 bytes, 1234567 are free';
  const words = 'Too large for the server: 5.00 GB of memory are needed for the upload, and 1.23 MB are free.';
  const metadata = { asked_bytes: '5000000000', free_bytes: '1234567' };
  assert.equal(inWords(new ServerError(Code.ResourceExhausted, 'OUT_OF_MEMORY', needs, metadata)), words);
  assert.equal(inWords(ServerError.fromClose(4008, `OUT_OF_MEMORY: ${needs}`)), words);
  const ofShare = 'More than you may use: 5.00 GB of memory are needed for the upload, and 1.23 MB of your share are free.';
  const needsOfShare = `${needs} of what one caller may use`;
  assert.equal(inWords(new ServerError(Code.ResourceExhausted, 'OUT_OF_MEMORY', needsOfShare, { ...metadata, share: 'caller' })), ofShare);
  assert.equal(inWords(ServerError.fromClose(4008, `OUT_OF_MEMORY: ${needsOfShare}`)), ofShare);
  const unknown = new ServerError(Code.ResourceExhausted, 'OUT_OF_MEMORY', 'the plan needs more memory than there is');
  assert.equal(inWords(unknown), 'The plan needs more memory than there is.');
  const malformed = new ServerError(Code.InvalidArgument, 'MALFORMED_FILE', 'data: not a valid OBJ file, line 3: no number');
  assert.equal(inWords(malformed), 'Not a valid OBJ file, line 3: no number.');
  assert.equal(inWords(new Error('part.stl is empty.')), 'part.stl is empty.');
  assert.match(inWords(new ServerError(Code.PermissionDenied, 'PERMISSION_DENIED', 'x', { role: 'edit' })), /role "edit"/);
  assert.equal(inWords(new ServerError(Code.InvalidArgument, 'OUT_OF_RANGE', 'degree is 1 to 3')), 'Degree is 1 to 3.');
  assert.equal(bytes(999), '999 bytes');
});

test('an export is asked for as it is shown, and one that the server has no memory for is refused in words', async () => {
  const asked: string[] = [];
  const named = { 'content-disposition': "attachment; filename*=UTF-8''a%20b.ply" };
  const answers = [new Response('ply', { headers: named }), new Response('ply', { headers: { ...named, 'latticed-certified-error': '0.0125' } }),
    new Response('the export needs 8255887100 bytes, 731283 are free\n', { status: 429 })];
  const fetchOfNode = globalThis.fetch;
  globalThis.fetch = (address) => (asked.push(String(address)), Promise.resolve(answers.shift()!));
  try {
    const view = { segments: 20, normals: 'facet', geometry: 'original' } as const;
    const download = (tolerance = 0) => downloadExport(new LatticedServer('http://test'), 'scene-1', 'ply', { ...view, tolerance },
      () => undefined, new AbortController().signal);
    const [first, second] = [await download(), await download(0.02)];
    assert.deepEqual([first.name, first.certifiedError, second.certifiedError], ['a b.ply', 0, 0.0125]);
    const refusal = await download().then(() => 'none', inWords);

    assert.deepEqual(asked, ['', '&tolerance=0.02', ''].map((more) =>
      `http://test/export/scene-1.ply?segments=20${more}&normals=facet&geometry=original`));
    assert.equal(refusal, 'Too large for the server: 8.26 GB of memory are needed for the export, and 731 kB are free.');
  } finally {
    globalThis.fetch = fetchOfNode;
  }
});

test('editor ids are version 4 UUIDs', () => {
  const ids = new Set(Array.from({ length: 100 }, randomUuid));
  assert.equal(ids.size, 100);
  for (const id of ids) assert.match(id, /^[0-9a-f]{8}-[0-9a-f]{4}-4[0-9a-f]{3}-[89ab][0-9a-f]{3}-[0-9a-f]{12}$/);
});

test('over gRPC-Web edits, controls and heartbeats are calls, a refusal is an event, and a lost answer ends the stream', async (t) => {
  const batches: EditBatch[] = [];
  const controls: ControlWatchRequest[] = [];
  let refuse: ConnectError | undefined;
  const { stream, events, ends, scenes } = new Watched(t, {
    applyEdits: (batch) => {
      batches.push(batch);
      if (refuse) throw refuse;
      return create(EditResultSchema, { sequence: batch.sequence, revision: 7n });
    },
    controlWatch: (request) => (controls.push(request), create(ControlWatchResponseSchema)),
  });
  await until(() => events.length === 1);

  stream.send({ message: { case: 'edit', value: { sequence: 1n, structureId: 2n } } });
  stream.send({ message: { case: 'control', value: { ackedUpdateId: 3n } } });
  stream.send({ message: { case: 'heartbeat', value: {} } });
  await until(() => events.length === 2 && controls.length === 2);
  refuse = new ConnectError('not finite', Code.InvalidArgument, undefined,
    [{ desc: ErrorInfoSchema, value: { domain: 'latticed', reason: 'NOT_FINITE' } }]);
  stream.send({ message: { case: 'edit', value: { sequence: 2n } } });
  await until(() => events.length === 3);

  const [, accepted, refused] = events;
  assert.deepEqual(scenes, ['scene-0001', 'scene-0001']);
  assert.deepEqual([batches[0].scene, batches[0].editorId, batches[0].structureId], ['scene-0001', 'e', 2n]);
  assert.deepEqual(controls.map(({ watchId, ackedUpdateId }) => [watchId, ackedUpdateId]), [['w-1', 3n], ['w-1', undefined]]);
  assert.equal(accepted.case === 'editResult' && accepted.value.revision, 7n);
  const failure = refused.case === 'editResult' ? ServerError.fromStatus(refused.value.status!) : undefined;
  assert.deepEqual([failure?.code, failure?.reason, failure?.message], [Code.InvalidArgument, 'NOT_FINITE', 'not finite']);

  refuse = new ConnectError('connection reset', Code.Unavailable);
  stream.send({ message: { case: 'edit', value: { sequence: 3n } } });
  await until(() => ends.length === 1);
  assert.equal(ends[0]?.code, Code.Unavailable);
  assert.equal(events.length, 3);
});

test('over gRPC-Web an edit that comes after the end of the token ends the stream, and waits for the next one', async (t) => {
  const { stream, events, ends } = new Watched(t, {
    applyEdits: () => {
      throw new ConnectError("the token has expired ('exp')", Code.Unauthenticated);
    },
  });
  await until(() => events.length === 1);

  stream.send({ message: { case: 'edit', value: { sequence: 1n } } });
  await until(() => ends.length === 1);

  assert.equal(ends[0]?.code, Code.Unauthenticated);
  assert.equal(events.length, 1);
});

test('over gRPC-Web what is sent before the watch is open goes then, and one call after the other, the newest of each', async (t) => {
  const controls: string[] = [];
  const answers: (() => void)[] = [];
  let open!: () => void;
  const { stream } = new Watched(t, {
    controlWatch: async ({ view, ackedUpdateId, presence }) => {
      controls.push([view?.segments, ackedUpdateId, presence?.selectedIndices].join());
      await new Promise<void>((resolve) => answers.push(resolve));
      return create(ControlWatchResponseSchema);
    },
  }, new Promise<void>((resolve) => (open = resolve)));
  const setSegments = (segments: number): void => stream.send({ message: { case: 'control', value: { view: { segments } } } });

  setSegments(3);
  stream.send({ message: { case: 'presence', value: { selectedIndices: [7] } } });
  setSegments(4);
  open();
  await until(() => controls.length === 1);
  for (const segments of [5, 6]) setSegments(segments);
  stream.send({ message: { case: 'control', value: { ackedUpdateId: 9n } } });
  answers[0]();
  await until(() => controls.length === 2);

  assert.deepEqual(controls, ['4,,7', '6,9,']);
});

test('over gRPC-Web a call is not waited for longer than 15 seconds: then the stream ends, with what may stand in the way', async (t) => {
  const timeouts: (number | undefined)[] = [];
  const { stream, events, ends } = new Watched(t, {
    applyEdits: (_, context) => {
      timeouts.push(context.timeoutMs());
      throw new ConnectError('the operation timed out', Code.DeadlineExceeded);
    },
  });
  await until(() => events.length === 1);

  stream.send({ message: { case: 'edit', value: { sequence: 1n } } });
  await until(() => ends.length === 1);

  assert.ok(timeouts[0]! > 0 && timeouts[0]! <= 15_000, `${timeouts}`);
  assert.ok(ends[0]!.isPassing);
  assert.equal(inWords(ends[0]), 'The server did not answer in time; without WebSockets a browser shows 5 of its windows at once: ' +
    'if more are open, close some.');
});
