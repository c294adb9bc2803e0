// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// usage: node build.mjs web OUT | node build.mjs tests OUT
// Bundles the viewer with esbuild; or its tests for Node, and the page that they steer in a browser. Run in the build
// folder, where src and test are links into the source tree, beside node_modules and gen (CMakeLists.txt).
import { copyFileSync, mkdirSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { build } from 'esbuild';

const [what, out] = process.argv.slice(2);
const common = { bundle: true, preserveSymlinks: true, sourcemap: true, target: 'es2022', logLevel: 'warning' };

// Builds what a browser loads: bundles, the files beside them, the decoder.
async function buildPage(folder, entryPoints, to) {
  mkdirSync(to, { recursive: true });
  await build({
    ...common,
    entryPoints: { ...entryPoints, decode_worker: 'src/decode/decode_worker.ts' },
    outdir: to,
    format: 'esm',
    minify: true,
    external: ['fs', 'path', 'node:fs', 'node:path'],  // draco3d uses them only in Node
    legalComments: 'linked',
  });
  for (const name of readdirSync(folder).filter((file) => /\.(html|css)$/.test(file))) {
    copyFileSync(join(folder, name), join(to, name));
  }
  copyFileSync('node_modules/draco3d/draco_decoder.wasm', join(to, 'draco_decoder.wasm'));
}

const buildWeb = () => buildPage('.', { main: 'src/main.ts' }, out);

async function buildTests() {
  const testsIn = (folder, to) => readdirSync(folder).filter((name) => name.endsWith('_test.ts'))
    .map((name) => ({ in: join(folder, name), out: join(to, name.slice(0, -'.ts'.length)) }));
  await build({
    ...common,
    entryPoints: [...testsIn('test', 'unit'), ...testsIn('test/e2e', 'e2e'), { in: 'test/e2e/viewer_bench.ts', out: 'viewer_bench' }],
    outdir: out,
    outExtension: { '.js': '.mjs' },
    format: 'esm',
    platform: 'node',
    packages: 'external',
    // Node 18 has no global crypto, which browsers have.
    banner: { js: "import { webcrypto } from 'node:crypto'; globalThis.crypto ??= webcrypto;" },
  });
  await buildPage('test/e2e/page', { harness: 'test/e2e/page/harness.ts' }, join(out, 'page'));
}

await { web: buildWeb, tests: buildTests }[what]();
