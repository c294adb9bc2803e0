// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Copies the protos to protos/ and the decoder to decoder.wasm, where the programs load them, and generates the protos' TypeScript
// types. Environment: LATTICED_DECODER_WASM, the decoder, if it is not in the build folder.
import { execFileSync } from 'node:child_process';
import { cpSync, existsSync, mkdirSync, rmSync } from 'node:fs';

const here = new URL('.', import.meta.url).pathname;
const googleapis = process.env.LATTICED_GOOGLEAPIS_DIR ??
  '/usr/share/gocode/src/github.com/grpc-ecosystem/grpc-gateway/third_party/googleapis';
const status = 'google/rpc/status.proto';
if (!existsSync(`${googleapis}/${status}`)) {
  console.error(`${status} is missing: install Debian's golang-github-grpc-ecosystem-grpc-gateway-dev, ` +
    'or set LATTICED_GOOGLEAPIS_DIR to a copy of googleapis');
  process.exit(1);
}

for (const made of ['protos', 'decoder.wasm', 'src/generated', 'dist']) rmSync(here + made, { recursive: true, force: true });
mkdirSync(`${here}protos/google/rpc`, { recursive: true });
cpSync(`${here}../../proto/latticed`, `${here}protos/latticed`, { recursive: true });
cpSync(`${googleapis}/${status}`, `${here}protos/${status}`);

const decoder = process.env.LATTICED_DECODER_WASM ?? `${here}../../build/client/decoder/wasm/decoder.wasm`;
if (existsSync(decoder)) cpSync(decoder, `${here}decoder.wasm`);
else console.warn(`${decoder} is missing: draco3d decodes, at a fraction of the speed. ./dev build latticed_decoder_wasm makes it.`);

// The same options as for loadSync in src/services.ts.
execFileSync(`${here}node_modules/.bin/proto-loader-gen-types`, [
  '--longs=Number', '--enums=String', '--defaults', '--oneofs',
  '--grpcLib=@grpc/grpc-js', '--importFileExtension=.js', '-I', `${here}protos`, '-O', `${here}src/generated`,
  'latticed/v1/backup.proto', 'latticed/v1/mesh.proto', 'latticed/v1/scene.proto',
], { stdio: 'inherit' });
