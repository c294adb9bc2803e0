// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a GLB says of itself: glTF 2.0, chapter 4.4.
import type { MeshFile } from './mesh_file';

const [LENGTH_AT, JSON_AT] = [12, 20];

/** The first chunk of a GLB, whose length stands before it. */
export async function glbJson(content: Blob): Promise<string> {
  const head = new DataView(await content.slice(0, JSON_AT).arrayBuffer());
  return content.slice(JSON_AT, JSON_AT + head.getUint32(LENGTH_AT, true)).text();
}

interface Moving {
  readonly nodes?: readonly { readonly skin?: number }[];
  readonly meshes?: readonly { readonly primitives: readonly { readonly targets?: readonly object[] }[] }[];
  readonly animations?: readonly object[];
}

/** What would move or bend a mesh that the server took, in words, since it takes the shape at rest; undefined where nothing would. */
export async function shownAtRest({ name, format, content }: MeshFile): Promise<string | undefined> {
  if (format !== 'glb') return undefined;
  const { nodes = [], meshes = [], animations = [] } = JSON.parse(await glbJson(content)) as Moving;
  const parts = [
    nodes.some(({ skin }) => skin !== undefined) && 'bones',
    meshes.some(({ primitives }) => primitives.some(({ targets = [] }) => targets.length > 0)) && 'morph targets',
    animations.length > 0 && 'animations',
  ].filter((part) => part !== false);
  return parts.length === 0 ? undefined : `${name} is shown at rest, without its ${words(parts)}.`;
}

function words(parts: readonly string[]): string {
  return parts.length < 2 ? parts.join() : `${parts.slice(0, -1).join(', ')} and ${parts.at(-1)}`;
}
