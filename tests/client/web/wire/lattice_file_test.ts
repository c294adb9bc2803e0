// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Lattice files that the viewer writes and latticectl reads, and the reverse, compared with the server's lattice.
// Environment: LATTICED and LATTICECTL, the programs.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { Lattice } from '@src/lattice/lattice';
import { latticeFromJson, latticeToJson } from '@src/wire/lattice_json';
import { toLattice } from '@src/wire/lattice_message';
import { LatticedServer } from '@src/wire/latticed_server';
import { ServerProcess } from '../e2e/support/server_process';

const MESH = 'v 0.1 0 0\nv 3 0.3 0\nv 0 1.7 0.2\nv 0.7 0 1.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n';

let folder: string;
let server: ServerProcess;

const path = (name: string): string => join(folder, name);

function latticectl(...words: readonly string[]): void {
  execFileSync(process.env.LATTICECTL!, words, { cwd: folder, stdio: ['ignore', 'ignore', 'inherit'] });
}

/** Creates a scene by latticectl with these arguments. Returns the lattice that the server gives it. */
async function latticeOfServer(scene: string, ...words: readonly string[]): Promise<Lattice> {
  latticectl('scene', 'create', 'mesh.obj', '--id', scene, '--server', server.grpcAddress, ...words);
  const state = await new LatticedServer(server.origin).scenes.getLattice({ scene });
  return toLattice(state.lattice!);
}

/** Degrees 3, 1, 2, uneven knots, an oblique frame, and control points of 53 bits at sizes from 1e-9 to 1e9. */
function awkwardLattice(): Lattice {
  const points = Float64Array.from({ length: 3 * 5 * 3 * 4 }, (_, i) => Math.sin(i + 1) * 10 ** ((i % 19) - 9));
  return new Lattice(
    { origin: [-1 / 3, -0.1, -1e-7], u: [4.1, 0.2, 0], v: [0.1 + 0.2, Math.PI, 0], w: [0, 1e-17, Math.SQRT2] },
    [3, 1, 2], [5, 3, 4],
    [Float64Array.of(0, 0, 0, 0, 0.7, 2, 2, 2, 2), Float64Array.of(-1, -1, 1 / 7, 2, 2), Float64Array.of(0, 0, 0, 1 / 3, 1, 1, 1)],
    points);
}

before(async () => {
  folder = mkdtempSync(join(tmpdir(), 'latticed-lattice-'));
  writeFileSync(path('mesh.obj'), MESH);
  writeFileSync(path('index.html'), '');
  server = await ServerProcess.start(folder);
});

after(async () => {
  await server?.kill();
  rmSync(folder, { recursive: true });
});

test('latticectl reads what the viewer saves to the same bits', async () => {
  const lattice = awkwardLattice();
  writeFileSync(path('saved.json'), latticeToJson(lattice));

  assert.deepEqual(await latticeOfServer('of-the-viewer', '--lattice', 'saved.json'), lattice);
  latticectl('apply', 'mesh.obj', '--lattice', 'saved.json', '--server', server.grpcAddress, '-o', 'deformed.ply');
  assert.equal(readFileSync(path('deformed.ply')).subarray(0, 3).toString(), 'ply');
});

test('the viewer opens what latticectl writes to the bits of the server\'s own fit', async () => {
  const fit = ['--size', '5,4,6', '--degree', '3,1,2', '--padding', '0.07'];
  latticectl('lattice', 'mesh.obj', ...fit, '-o', 'written.json');

  const opened = latticeFromJson(readFileSync(path('written.json'), 'utf8'));

  assert.deepEqual(opened, await latticeOfServer('of-latticectl', ...fit));
  assert.equal(opened.count, 120);
});
