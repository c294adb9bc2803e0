// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Data of a mesh's corners: texture coordinates, and the number of the layer that they belong to.
//
// Layout  u v layer per corner, in the server's order of corners: all faces in the file's order; u to the right, v
//         down, 0 to 1 once over the picture

/** One material: a picture, a colour, or a picture times a colour. */
export interface Layer {
  readonly picture?: ImageBitmapSource;
  /** A CSS colour; white if absent. */
  readonly colour?: string;
}

export interface MeshLayers {
  readonly corners: Float32Array;
  readonly layers: readonly Layer[];
  /** Hints for people, for example about a picture that is named but was not dropped. */
  readonly notes: readonly string[];
}

/** The file of that name, ignoring folders and letter case. */
export function findByName(files: readonly File[], name: string): File | undefined {
  const wanted = baseName(name);
  return files.find((file) => baseName(file.name) === wanted);
}

function baseName(path: string): string {
  return path.slice(Math.max(path.lastIndexOf('/'), path.lastIndexOf('\\')) + 1).toLowerCase();
}

export function missing(mesh: string, picture: string): string {
  return `${mesh} names the picture ${picture}, which was not dropped with it.`;
}
