// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { create, toBinary } from '@bufbuild/protobuf';
import { MeshHeaderSchema } from 'latticed/v1/mesh_pb';
import type { MeshHeaderInit } from '../../wire/upload';

/** An uploaded file, from which restoring uploads it again. */
export interface StoredMesh {
  /** SHA-256 of the content: the mesh's id on every server. */
  readonly id: string;
  /** MeshHeader of mesh.proto, encoded. */
  readonly header: Uint8Array;
  readonly content: Blob;
}

/** A scene as this browser saw it last. */
export interface StoredScene {
  readonly id: string;
  readonly mesh: string;
  /** The run of the server that had the scene. */
  readonly bootId: string;
  /** CreateSceneRequest of scene.proto with the newest lattice, encoded. */
  readonly request: Uint8Array;
  /** Date.now() of the last change. */
  readonly savedAt: number;
}

export function storedMesh(id: string, header: MeshHeaderInit, content: Blob): StoredMesh {
  return { id, header: toBinary(MeshHeaderSchema, create(MeshHeaderSchema, header)), content };
}
