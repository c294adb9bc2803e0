// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { create, toBinary } from '@bufbuild/protobuf';
import { MeshHeaderSchema } from 'latticed/v1/mesh_pb';
import type { MeshHeaderInit } from '../../wire/upload';

/** An uploaded file, as restoring uploads it again. */
export interface StoredMesh {
  /** SHA-256 of the content: the mesh's id on every server. */
  readonly id: string;
  /** MeshHeader of mesh.proto, encoded. */
  readonly header: Uint8Array;
  readonly content: Blob;
}

/** A scene as this browser last saw it. */
export interface StoredScene {
  readonly id: string;
  readonly mesh: string;
  /** The run of the server that had it. */
  readonly bootId: string;
  /** CreateSceneRequest of scene.proto with the newest lattice, encoded. */
  readonly request: Uint8Array;
  /** Date.now() of the last change. */
  readonly savedAt: number;
}

/**
 * What outlives the server: the meshes and lattices of scenes that were opened here. Saving rejects, with an Error in
 * words, where something would not outlive the page as well; the page can then have it still.
 */
export interface SceneStore {
  /** Whether a mesh is where it outlives the page. */
  keepsMesh(id: string): Promise<boolean>;
  mesh(id: string): Promise<StoredMesh | undefined>;
  scene(id: string): Promise<StoredScene | undefined>;
  /** Does nothing where the mesh is there. */
  saveMesh(mesh: StoredMesh): Promise<void>;
  saveScene(scene: StoredScene): Promise<void>;
  /** Keeps the newest scenes and their meshes. */
  forgetOld(): Promise<void>;
}

export function storedMesh(id: string, header: MeshHeaderInit, content: Blob): StoredMesh {
  return { id, header: toBinary(MeshHeaderSchema, create(MeshHeaderSchema, header)), content };
}
