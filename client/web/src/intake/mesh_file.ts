// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Files that are dropped or chosen: which of them are meshes, lattices, pictures.

import { bytes } from '../wire/words';

const MESHES = ['obj', 'ply', 'stl', 'glb', 'drc'] as const;
export type MeshFormatName = (typeof MESHES)[number];

export interface MeshFile {
  readonly name: string;
  readonly format: MeshFormatName;
  /** Read where it is wanted: a page holds no mesh in memory. */
  readonly content: Blob;
}

const PICTURES = ['png', 'jpg', 'jpeg', 'webp'];

/** For the file dialog: meshes, and what may come with them. */
export const MESH_ENDINGS = [...MESHES, 'mtl', ...PICTURES].map((ending) => `.${ending}`).join();

/** What a file is by its name's ending; undefined where the page has no use for it. */
export function fileKind(name: string): 'mesh' | 'lattice' | 'materials' | 'picture' | undefined {
  const ending = endingOf(name);
  if (meshFormat(name) !== undefined) return 'mesh';
  if (PICTURES.includes(ending)) return 'picture';
  if (ending === 'mtl') return 'materials';
  return ending === 'json' ? 'lattice' : undefined;
}

function meshFormat(name: string): MeshFormatName | undefined {
  return MESHES.find((format) => format === endingOf(name));
}

function endingOf(name: string): string {
  return name.slice(name.lastIndexOf('.') + 1).toLowerCase();
}

/**
 * Takes a dropped mesh. Throws an Error in words for another file, and for one that the browser cannot read, a folder
 * for instance, or that is larger than the server takes.
 *
 * @param mostBytes Asked only of a mesh; 0: any number.
 */
export async function readMeshFile(file: File, mostBytes: () => Promise<number>): Promise<MeshFile> {
  const format = meshFormat(file.name);
  if (format === undefined) throw new Error(`${file.name} is no mesh that the server reads: OBJ, PLY, STL, GLB or DRC.`);
  if (file.size === 0) throw new Error(`${file.name} is empty.`);
  const most = await mostBytes();
  if (most > 0 && file.size > most) {
    throw new Error(`${file.name} is too large for the server: it has ${bytes(file.size)}, and ${bytes(most)} are the most.`);
  }
  const first = file.slice(0, 1);
  await first.arrayBuffer().catch(() => {
    throw new Error(`The browser cannot read ${file.name}, ${bytes(file.size)}.`);
  });
  return { name: file.name, format, content: file };
}
