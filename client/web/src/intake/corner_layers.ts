// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What lies on the corners of a mesh: texture coordinates, and which of a few layers they are of.
//
// Layout  u v layer per corner, in the order in which the server numbers corners: of all faces in the file's order; u to
//         the right, v down, 0 to 1 once over the picture

/** One material: a picture, a colour, or a picture times a colour. */
export interface Layer {
  readonly picture?: ImageBitmapSource;
  /** Of CSS; white where absent. */
  readonly colour?: string;
}

export interface MeshLayers {
  readonly corners: Float32Array;
  readonly layers: readonly Layer[];
  /** What a person should know: a picture that is named and was not dropped. */
  readonly notes: readonly string[];
}

/** The file of that name, whatever folder or letter case a text names it in. */
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
