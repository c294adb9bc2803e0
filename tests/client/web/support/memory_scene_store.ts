// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { SceneStore } from '@src/session/store/indexed_scene_store';
import type { StoredMesh, StoredScene } from '@src/session/store/scene_store';

/** A browser's store, as long as the test runs. */
export class MemorySceneStore implements SceneStore {
  /** What saving rejects with; the page has what was saved still. */
  refusal: Error | undefined;
  saves = 0;
  private readonly meshes = new Map<string, StoredMesh>();
  private readonly scenes = new Map<string, StoredScene>();

  async keepsMesh(id: string): Promise<boolean> {
    return !this.refusal && this.meshes.has(id);
  }

  async mesh(id: string): Promise<StoredMesh | undefined> {
    return this.meshes.get(id);
  }

  async scene(id: string): Promise<StoredScene | undefined> {
    return this.scenes.get(id);
  }

  async saveMesh(mesh: StoredMesh): Promise<void> {
    this.meshes.set(mesh.id, mesh);
    this.saved();
  }

  async saveScene(scene: StoredScene): Promise<void> {
    this.scenes.set(scene.id, scene);
    this.saved();
  }

  async forgetOld(): Promise<void> {}

  private saved(): void {
    ++this.saves;
    if (this.refusal) throw this.refusal;
  }
}
