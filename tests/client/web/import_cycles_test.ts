// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// No file of client/web/src imports itself through others; imports of types count too. Reads ./src.
import assert from 'node:assert/strict';
import { existsSync, readFileSync, readdirSync, statSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

const IMPORT = /\b(?:from|import)\s*\(?\s*'(\.[^']*)'/g;

function sourcesIn(folder: string): string[] {
  return readdirSync(folder).flatMap((name) => {
    const path = join(folder, name);
    return statSync(path).isDirectory() ? sourcesIn(path) : path.endsWith('.ts') ? [path] : [];
  });
}

function importsOf(file: string): string[] {
  const paths = [...readFileSync(file, 'utf8').matchAll(IMPORT)].map(([, path]) => join(file, '..', `${path}.ts`));
  return paths.filter((path) => existsSync(path));
}

/** The first cycle that a depth-first walk meets, as "a.ts > b.ts > a.ts". */
function findCycle(imports: ReadonlyMap<string, readonly string[]>): string | undefined {
  const done = new Set<string>();
  const visit = (file: string, path: readonly string[]): string | undefined => {
    if (path.includes(file)) return [...path.slice(path.indexOf(file)), file].join(' > ');
    if (done.has(file)) return undefined;
    for (const next of imports.get(file) ?? []) {
      const cycle = visit(next, [...path, file]);
      if (cycle !== undefined) return cycle;
    }
    done.add(file);
    return undefined;
  };
  for (const file of imports.keys()) {
    const cycle = visit(file, []);
    if (cycle !== undefined) return cycle;
  }
  return undefined;
}

test('the sources have no cycle of imports', () => {
  const files = sourcesIn('src');
  assert.ok(files.length > 100, 'the sources are read');

  assert.equal(findCycle(new Map(files.map((file) => [file, importsOf(file)]))), undefined);
});
