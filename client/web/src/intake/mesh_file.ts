// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Files that are dropped or chosen: which of them are meshes, lattices, pictures.

import { bytes } from '../wire/words';

export type MeshFormatName = 'obj' | 'ply' | 'stl' | 'glb' | 'drc';

export interface MeshFile {
  readonly name: string;
  readonly format: MeshFormatName;
  /** Read where it is wanted: a page holds no mesh in memory. */
  readonly content: Blob;
}

export type FileKind = MeshFormatName | 'lattice' | 'materials' | 'picture';

const KINDS: Record<string, FileKind> = {
  obj: 'obj',
  ply: 'ply',
  stl: 'stl',
  glb: 'glb',
  drc: 'drc',
  json: 'lattice',
  mtl: 'materials',
  png: 'picture',
  jpg: 'picture',
  jpeg: 'picture',
  webp: 'picture',
};

/** What a file is by its name's ending; undefined where the page has no use for it. */
export function fileKind(name: string): FileKind | undefined {
  return KINDS[name.slice(name.lastIndexOf('.') + 1).toLowerCase()];
}

/** For the file dialog: meshes, and what may come with them. */
export const MESH_ENDINGS = '.obj,.ply,.stl,.glb,.drc,.mtl,.png,.jpg,.jpeg,.webp';

/**
 * Takes a dropped mesh. Throws an Error in words for another file, and for one that the browser cannot read, a folder
 * for instance, or that is larger than the server takes.
 *
 * @param mostBytes Asked only of a mesh; 0: any number.
 */
export async function readMeshFile(file: File, mostBytes: () => Promise<number>): Promise<MeshFile> {
  const kind = fileKind(file.name);
  if (kind === undefined || kind === 'lattice' || kind === 'materials' || kind === 'picture') {
    throw new Error(`${file.name} is no mesh that the server reads: OBJ, PLY, STL, GLB or DRC.`);
  }
  if (file.size === 0) throw new Error(`${file.name} is empty.`);
  const most = await mostBytes();
  if (most > 0 && file.size > most) {
    throw new Error(`${file.name} is too large for the server: it has ${bytes(file.size)}, and ${bytes(most)} are the most.`);
  }
  const first = file.slice(0, 1);
  await first.arrayBuffer().catch(() => {
    throw new Error(`The browser cannot read ${file.name}, ${bytes(file.size)}.`);
  });
  return { name: file.name, format: kind, content: file };
}
