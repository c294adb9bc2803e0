// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The JSON chunk of a GLB file: glTF 2.0, chapter 4.4.
import type { MeshFile } from './mesh_file';

const [LENGTH_AT, JSON_AT] = [12, 20];

/** The first chunk of a GLB. Its length stands before it. */
export async function glbJson(content: Blob): Promise<string> {
  const head = new DataView(await content.slice(0, JSON_AT).arrayBuffer());
  return content.slice(JSON_AT, JSON_AT + head.getUint32(LENGTH_AT, true)).text();
}

/** The server does not check these fields, so any of them may be null. */
interface Moving {
  readonly nodes?: readonly { readonly skin?: number | null }[] | null;
  readonly meshes?: readonly { readonly primitives?: readonly { readonly targets?: readonly object[] | null }[] | null }[] | null;
  readonly animations?: readonly object[] | null;
}

/** Says in words that a mesh is shown without bones, morph targets or animations; undefined if it has none. */
export async function shownAtRest({ name, format, content }: MeshFile): Promise<string | undefined> {
  if (format !== 'glb') return undefined;
  const { nodes, meshes, animations } = JSON.parse(await glbJson(content)) as Moving;
  const parts = [
    nodes?.some(({ skin }) => typeof skin === 'number') && 'bones',
    meshes?.some(({ primitives }) => primitives?.some(({ targets }) => hasAny(targets))) && 'morph targets',
    hasAny(animations) && 'animations',
  ].filter((part) => typeof part === 'string');
  return parts.length === 0 ? undefined : `${name} is shown at rest, without its ${words(parts)}.`;
}

function hasAny(list: readonly object[] | null | undefined): boolean {
  return (list?.length ?? 0) > 0;
}

function words(parts: readonly string[]): string {
  return parts.length < 2 ? parts.join() : `${parts.slice(0, -1).join(', ')} and ${parts.at(-1)}`;
}
