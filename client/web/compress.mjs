// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compressed copies of the files that browsers load, for the server to send instead.
import { readdirSync, readFileSync, statSync, writeFileSync } from 'node:fs';
import { extname, join } from 'node:path';
import { brotliCompressSync, constants, gzipSync } from 'node:zlib';

const COMPRESSIBLE = new Set(['.css', '.html', '.js', '.json', '.obj', '.svg', '.wasm']);

/** Writes FILE.br and FILE.gz beside each file of the folders or files `paths` below `root`, where they are smaller. */
export function compressFiles(root, ...paths) {
  for (const path of paths.map((each) => join(root, each))) {
    if (statSync(path).isDirectory()) compressFiles(path, ...readdirSync(path));
    else if (COMPRESSIBLE.has(extname(path))) compressFile(path);
  }
}

function compressFile(path) {
  const content = readFileSync(path);
  const params = { [constants.BROTLI_PARAM_QUALITY]: constants.BROTLI_MAX_QUALITY, [constants.BROTLI_PARAM_SIZE_HINT]: content.length };
  for (const [suffix, copy] of [['.br', brotliCompressSync(content, { params })], ['.gz', gzipSync(content, { level: 9 })]]) {
    if (copy.length < content.length) writeFileSync(path + suffix, copy);
  }
}
