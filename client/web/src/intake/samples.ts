// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Meshes for a first look without a file: those of `latticectl sample`, which writes them when the page is built.
import type { Lattice } from '../lattice/lattice';
import { fetchAsset } from '../wire/asset';
import { latticeFromJson } from '../wire/lattice_json';
import type { MeshFile } from './mesh_file';

/** Names of files in assets/, by their names in samples/. Defined by build.mjs. */
declare const SAMPLE_FILES: Readonly<Record<string, string>>;

interface Sample {
  readonly label: string;
  readonly note: string;
  /** A sample with a lattice opens already deformed, beside its vertices-only shape. Others ask for a lattice. */
  readonly hasLattice?: true;
}

export const SAMPLES = {
  beam: { label: 'Bent beam', note: '18 quads, compared with an ordinary lattice', hasLattice: true },
  knot: { label: 'Knot', note: '5,760 quads' },
  vase: { label: 'Vase', note: '9,314 faces' },
  gear: { label: 'Gear', note: '18,444 faces' },
  shell: { label: 'Shell', note: '8,664 triangles' },
  slab: { label: 'Slab', note: '1,600 quads' },
} satisfies Record<string, Sample>;

export type SampleName = keyof typeof SAMPLES;

/** A sample as the OBJ file that a person could have dropped. */
export async function sampleFile(name: SampleName): Promise<MeshFile> {
  const file = await fetchAsset(SAMPLE_FILES[name]);
  return { name: `${name}.obj`, format: 'obj', content: await file.blob() };
}

/** The deformed lattice in which a sample opens; undefined if it opens at rest. */
export async function sampleLattice(name: SampleName): Promise<Lattice | undefined> {
  const sample: Sample = SAMPLES[name];
  if (!sample.hasLattice) return undefined;
  return latticeFromJson(await (await fetchAsset(SAMPLE_FILES[`${name}_lattice`])).text());
}
