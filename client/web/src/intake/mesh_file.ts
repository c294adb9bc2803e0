// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Files that are dropped or chosen: which of them are meshes, lattices, pictures.

export type MeshFormatName = 'obj' | 'ply' | 'stl' | 'glb' | 'drc';

export interface MeshFile {
  readonly name: string;
  readonly format: MeshFormatName;
  readonly bytes: Uint8Array<ArrayBuffer>;
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

/** Reads a dropped mesh; throws an Error in words for another file. */
export async function readMeshFile(file: File): Promise<MeshFile> {
  const kind = fileKind(file.name);
  if (kind === undefined || kind === 'lattice' || kind === 'materials' || kind === 'picture') {
    throw new Error(`${file.name} is no mesh that the server reads: OBJ, PLY, STL, GLB or DRC.`);
  }
  if (file.size === 0) throw new Error(`${file.name} is empty.`);
  return { name: file.name, format: kind, bytes: new Uint8Array(await file.arrayBuffer()) };
}
