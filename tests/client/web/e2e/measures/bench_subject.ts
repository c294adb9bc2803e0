// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The meshes of the benches, and their statistics. Environment: LATTICECTL, and LATTICED_SHARED, a folder with real meshes in models/.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

type Size = readonly [number, number, number]; // control points along u, v, w

interface Sample {
  readonly name: string;
  readonly resolution: number;
  readonly size: Size;
}

/** 1,060, 5,034 and 17,068 patches: two samples and a file. If it is missing, a sample of 16,448 patches. */
export const MESHES: readonly { readonly model?: string; readonly size?: Size; readonly sample: Sample }[] = [
  { sample: { name: 'knot', resolution: 1, size: [4, 4, 4] } },
  { sample: { name: 'vase', resolution: 2, size: [4, 4, 4] } },
  { model: 'fandisk.obj', size: [5, 6, 6], sample: { name: 'knot', resolution: 4, size: [6, 6, 6] } },
];

/** A mesh, and the size of the lattice that it gets. */
export interface Subject {
  readonly name: string;
  readonly content: Buffer;
  readonly size: Size;
}

export function subjectOf({ model, size, sample }: (typeof MESHES)[number]): Subject {
  const path = join(process.env.LATTICED_SHARED ?? '../shared', 'models', model ?? '');
  if (model !== undefined && size !== undefined && existsSync(path)) return { name: model, content: readFileSync(path), size };
  const folder = mkdtempSync(join(tmpdir(), 'latticed-bench-'));
  const file = join(folder, 'sample.obj');
  execFileSync(process.env.LATTICECTL!, ['sample', sample.name, '--resolution', `${sample.resolution}`, '-o', file]);
  const content = readFileSync(file);
  rmSync(folder, { recursive: true });
  return { name: `${sample.name}.obj`, content, size: sample.size };
}

export function percentile(values: readonly number[], fraction: number): number {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(fraction * sorted.length))];
}
