// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** An uploaded file, as restoring uploads it again. */
export interface StoredMesh {
  /** SHA-256 of the bytes: the mesh's id on every server. */
  readonly id: string;
  /** MeshHeader of mesh.proto, encoded. */
  readonly header: Uint8Array;
  readonly bytes: Uint8Array;
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

/** What outlives the server: the meshes and lattices of scenes that were opened here. */
export interface SceneStore {
  mesh(id: string): Promise<StoredMesh | undefined>;
  scene(id: string): Promise<StoredScene | undefined>;
  saveMesh(mesh: StoredMesh): Promise<void>;
  /** Keeps the newest scenes and their meshes; older ones are forgotten. */
  saveScene(scene: StoredScene): Promise<void>;
}

/** A store that forgets with the page: where the browser gives none, in private windows for instance. */
export class MemorySceneStore implements SceneStore {
  private readonly meshes = new Map<string, StoredMesh>();
  private readonly scenes = new Map<string, StoredScene>();

  async mesh(id: string): Promise<StoredMesh | undefined> {
    return this.meshes.get(id);
  }

  async scene(id: string): Promise<StoredScene | undefined> {
    return this.scenes.get(id);
  }

  async saveMesh(mesh: StoredMesh): Promise<void> {
    this.meshes.set(mesh.id, mesh);
  }

  async saveScene(scene: StoredScene): Promise<void> {
    this.scenes.set(scene.id, scene);
  }
}
