// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { SceneStore } from '@src/session/store/indexed_scene_store';
import type { StoredMesh, StoredScene } from '@src/session/store/scene_store';

/** A browser's store of scenes, in memory. */
export class MemorySceneStore implements SceneStore {
  private readonly meshes = new Map<string, StoredMesh>();
  private readonly scenes = new Map<string, StoredScene>();

  async keepsMesh(id: string): Promise<boolean> {
    return this.meshes.has(id);
  }

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

  async forgetOld(): Promise<void> {}
}
