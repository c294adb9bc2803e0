// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// usage: node build.mjs web OUT | node build.mjs tests OUT
// Bundles the viewer, or its tests for Node, with esbuild. Run in the build folder, where src and test are
// links into the source tree and node_modules and gen stand beside them (CMakeLists.txt).
import { copyFileSync, mkdirSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { build } from 'esbuild';

const [what, out] = process.argv.slice(2);
const common = { bundle: true, preserveSymlinks: true, sourcemap: true, target: 'es2022', logLevel: 'warning' };

async function buildWeb() {
  mkdirSync(out, { recursive: true });
  await build({
    ...common,
    entryPoints: { main: 'src/main.ts', decode_worker: 'src/decode/decode_worker.ts' },
    outdir: out,
    format: 'esm',
    minify: true,
    external: ['fs', 'path', 'node:fs', 'node:path'],  // draco3d asks for them in Node alone
    legalComments: 'linked',
  });
  for (const name of ['index.html', 'style.css']) copyFileSync(name, join(out, name));
  copyFileSync('node_modules/draco3d/draco_decoder.wasm', join(out, 'draco_decoder.wasm'));
}

async function buildTests() {
  const names = readdirSync('test').filter((name) => name.endsWith('.ts') || name.endsWith('.mts'));
  await build({
    ...common,
    entryPoints: names.map((name) => join('test', name)),
    outdir: out,
    outExtension: { '.js': '.mjs' },
    format: 'esm',
    platform: 'node',
    packages: 'external',
  });
}

await { web: buildWeb, tests: buildTests }[what]();
