// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// usage: node build.mjs web OUT | node build.mjs tests OUT. Environment: LATTICED_DECODER_WASM, the module of client/decoder.
// Bundles the viewer with esbuild; or its tests for Node, and the page that they steer in a browser. Run in the build
// folder, where src and test are links into the source tree, beside node_modules and gen (CMakeLists.txt).
//
// All that index.html loads lies in assets/ and has a hash of its content in its name. The server therefore lets
// browsers keep it for ever, and a new release is loaded at once.
import { mkdirSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { basename, join, parse } from 'node:path';
import { build } from 'esbuild';
import { compressFiles } from './compress.mjs';

const [what, out] = process.argv.slice(2);
const common = { bundle: true, preserveSymlinks: true, sourcemap: true, target: 'es2022', logLevel: 'warning', loader: { '.vert': 'text' } };

// Bundles files for a browser. Returns the name with its hash of each entry point: { main: 'main-2Q7DJWPX.js' }.
async function bundleAssets(entryPoints, to, define = {}) {
  const { metafile } = await build({
    ...common,
    entryPoints,
    entryNames: '[name]-[hash]',
    outdir: join(to, 'assets'),
    format: 'esm',
    minify: true,
    metafile: true,
    define,
    loader: { ...common.loader, '.wasm': 'copy', '.obj': 'copy', '.json': 'copy' },
    external: ['fs', 'path', 'node:fs', 'node:path'],  // draco3d uses them only in Node
    legalComments: 'linked',
  });
  return Object.fromEntries(Object.entries(metafile.outputs).filter(([, { entryPoint }]) => entryPoint)
    .map(([path]) => basename(path)).map((name) => [name.slice(0, name.lastIndexOf('-')), name]));
}

// Builds a page: folder/index.html, which names its entry points as main.js and style.css, and the files that it fetches.
async function buildPage(folder, entryPoints, samples, to) {
  // Where no compiler for WebAssembly was found, draco3d decodes.
  const own = process.env.LATTICED_DECODER_WASM ? { decoder: process.env.LATTICED_DECODER_WASM } : {};
  const decoder = await bundleAssets({
    ...own,
    decode_worker: 'src/decode/decode_worker.ts',
    draco_chunk: 'src/decode/draco_chunk.ts',
    draco_decoder: 'node_modules/draco3d/draco_decoder.wasm',
  }, to);
  const define = {
    DECODER_FILES: JSON.stringify({
      worker: decoder.decode_worker, wasm: decoder.decoder, draco3d: { script: decoder.draco_chunk, wasm: decoder.draco_decoder },
    }),
    SAMPLE_FILES: JSON.stringify(await bundleAssets(samples, to)),
  };
  let page = readFileSync(join(folder, 'index.html'), 'utf8');
  for (const hashed of Object.values(await bundleAssets(entryPoints, to, define))) {
    const name = hashed.replace(/-[^-]*\./, '.');
    if (!page.includes(`"${name}"`)) throw new Error(`index.html does not load ${name}`);
    page = page.replace(`"${name}"`, `"assets/${hashed}"`);
  }
  writeFileSync(join(to, 'index.html'), page);
}

// docs/ is the work of docs/build_docs.mjs.
async function buildWeb() {
  mkdirSync(out, { recursive: true });
  const made = readdirSync(out).filter((name) => name !== 'docs');
  for (const name of made) rmSync(join(out, name), { recursive: true });
  const samples = readdirSync('samples').map((file) => [parse(file).name, join('samples', file)]);
  await buildPage('.', { main: 'src/main.ts', style: 'style.css' }, Object.fromEntries(samples), out);
  compressFiles(out, 'index.html', 'assets');
}

// Tests lie in folders, and their bundles side by side: each file has a name of its own. Tests in the browser share their
// modules, so those that one process runs have one browser.
async function buildTests() {
  const testsIn = (folder, without) => readdirSync(folder, { withFileTypes: true }).flatMap((entry) => {
    const path = join(folder, entry.name);
    if (entry.isDirectory()) return path === without ? [] : testsIn(path, without);
    return path.endsWith('_test.ts') ? [{ in: path, out: parse(path).name }] : [];
  });
  const forNode = {
    ...common,
    outExtension: { '.js': '.mjs' },
    format: 'esm',
    platform: 'node',
    packages: 'external',
    // Node 18 has no global crypto, which browsers have.
    banner: { js: "import { webcrypto } from 'node:crypto'; globalThis.crypto ??= webcrypto;" },
  };
  await build({ ...forNode, entryPoints: testsIn('test', 'test/e2e'), outdir: join(out, 'unit') });
  await build({ ...forNode, entryPoints: ['viewer_bench', 'decode_bench'].map((name) => `test/e2e/measures/${name}.ts`), outdir: out });
  await build({
    ...forNode, entryPoints: [...testsIn('test/e2e'), { in: 'test/e2e/run_files.ts', out: 'run_files' }], outdir: join(out, 'e2e'),
    splitting: true, chunkNames: 'shared/[hash]',
  });
  await buildPage('test/e2e/page', { harness: 'test/e2e/page/harness.ts' }, {}, join(out, 'page'));
}

await { web: buildWeb, tests: buildTests }[what]();
