// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The kinds of files that can be dropped or chosen: meshes, lattices, pictures, materials.

import { bytes } from '../wire/words';

const MESHES = ['obj', 'ply', 'stl', 'glb', 'drc'] as const;
export type MeshFormatName = (typeof MESHES)[number];

export interface MeshFile {
  readonly name: string;
  readonly format: MeshFormatName;
  /** Read when needed, so that the page does not hold meshes in memory. */
  readonly content: Blob;
}

const PICTURES = ['png', 'jpg', 'jpeg', 'webp'];

/** The endings that the file dialog accepts: meshes and the files that may come with them. */
export const MESH_ENDINGS = [...MESHES, 'mtl', ...PICTURES].map((ending) => `.${ending}`).join();

/** The kind of a file, by the ending of its name; undefined if the page has no use for it. */
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
 * Checks a dropped mesh. Throws an Error in words if the file is no mesh, is empty or is larger than the server takes,
 * or if the browser cannot read it, for example a folder.
 *
 * @param mostBytes The server's limit in bytes, requested for a mesh only; 0: no limit.
 */
export async function readMeshFile(file: File, mostBytes: () => Promise<number>): Promise<MeshFile> {
  const format = meshFormat(file.name);
  if (format === undefined) throw new Error(`${file.name} is no mesh that the server reads: OBJ, PLY, STL, GLB or DRC.`);
  if (file.size === 0) throw new Error(`${file.name} is empty.`);
  const most = await mostBytes();
  if (most > 0 && file.size > most) {
    throw new Error(`${file.name} is too large for the server: it has ${bytes(file.size)}, and the limit is ${bytes(most)}.`);
  }
  const first = file.slice(0, 1);
  await first.arrayBuffer().catch(() => {
    throw new Error(`The browser cannot read ${file.name}, ${bytes(file.size)}.`);
  });
  return { name: file.name, format, content: file };
}
