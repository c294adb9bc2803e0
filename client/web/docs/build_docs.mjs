// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// usage: node build_docs.mjs ROOT DESCRIPTORS OUT README…
// Writes the documentation as plain pages: one per README of the tree ROOT, in the README's folder, and a reference of
// the API with one page per .proto file. DESCRIPTORS is protoc's descriptor set with source info. CMake runs this.
import { copyFileSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { fromBinary } from '@bufbuild/protobuf';
import { FileDescriptorSetSchema } from '@bufbuild/protobuf/wkt';
import { compressFiles } from '../compress.mjs';
import { readmePage } from './markdown.mjs';
import { pageOf } from './page.mjs';
import { referencePages } from './reference.mjs';

const [root, descriptors, out, ...readmes] = process.argv.slice(2);

function write(path, content) {
  mkdirSync(dirname(join(out, path)), { recursive: true });
  writeFileSync(join(out, path), content);
}

const guides = readmes.map((readme) => readmePage(root, readme, readmes));
const reference = referencePages(fromBinary(FileDescriptorSetSchema, readFileSync(descriptors)));
const sections = [
  { title: 'Guide', pages: guides.map(({ path }) => ({ path, label: dirname(path).replace(/^\.$/, 'latticed') })) },
  { title: 'API reference', pages: reference.map(({ path, title }) => ({ path, label: title })) },
];

rmSync(out, { recursive: true, force: true });
for (const page of [...guides, ...reference]) write(page.path, pageOf(page, sections));
for (const image of new Set(guides.flatMap((page) => page.images))) write(image, readFileSync(join(root, image)));
copyFileSync(join(dirname(fileURLToPath(import.meta.url)), 'docs.css'), join(out, 'docs.css'));
compressFiles(out, '.');
