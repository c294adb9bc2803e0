// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { CompanionTable } from './companion_table';
import { committed, done, OutdatedPage, openSceneDatabase, type MeshFacts, type SceneTable } from './scene_database';
import type { SceneStore, StoredMesh, StoredScene } from './scene_store';

/**
 * Scenes and meshes in the browser's IndexedDB, a mesh once however many scenes use it, with what was dropped beside it.
 * The page itself holds the newest mesh and scene while they are being written, or if writing was refused.
 */
export class IndexedSceneStore implements SceneStore {
  private static readonly SCENES_KEPT = 16;
  private static readonly UNUSED_MESH_KEPT_MS = 60 * 60 * 1000;  // some window may be about to make a scene of it
  private static page: IndexedSceneStore | undefined;

  private connection: Promise<IDBDatabase> | undefined;
  private unwrittenMesh: StoredMesh | undefined;
  private unwrittenScene: StoredScene | undefined;

  /** The one that all sessions of the page share. */
  static ofPage(): IndexedSceneStore {
    return (IndexedSceneStore.page ??= new IndexedSceneStore());
  }

  async keepsMesh(id: string): Promise<boolean> {
    const meshes = (await this.reading(['meshes']))?.objectStore('meshes');
    return meshes !== undefined && (await done(meshes.getKey(id))) !== undefined;
  }

  async mesh(id: string): Promise<StoredMesh | undefined> {
    if (this.unwrittenMesh?.id === id) return this.unwrittenMesh;
    const transaction = await this.reading(['meshes', 'contents']);
    const facts = transaction && (await done<MeshFacts | undefined>(transaction.objectStore('meshes').get(id)));
    return facts && { id, header: facts.header, content: await done<Blob>(transaction.objectStore('contents').get(id)) };
  }

  async scene(id: string): Promise<StoredScene | undefined> {
    if (this.unwrittenScene?.id === id) return this.unwrittenScene;
    const transaction = await this.reading(['scenes']);
    return transaction && done<StoredScene | undefined>(transaction.objectStore('scenes').get(id));
  }

  async saveMesh(mesh: StoredMesh): Promise<void> {
    this.unwrittenMesh = mesh;
    await this.save(() => this.writeMesh(mesh), mesh.id, mesh.content.size);
    if (this.unwrittenMesh === mesh) this.unwrittenMesh = undefined;
  }

  async saveScene(scene: StoredScene): Promise<void> {
    this.unwrittenScene = scene;
    await this.save(() => this.writeScene(scene), scene.mesh, scene.request.length);
    if (this.unwrittenScene === scene) this.unwrittenScene = undefined;
  }

  /** Pictures and materials that were dropped beside a mesh. */
  async companions(mesh: string): Promise<readonly File[]> {
    const transaction = await this.reading(['companions']);
    return transaction === undefined ? [] : new CompanionTable(transaction).files(mesh);
  }

  /** In place of those before: of all, or beside others only of those that have their names. */
  saveCompanions(mesh: string, files: readonly File[], beside = false): Promise<void> {
    return this.save(() => this.writeCompanions(mesh, files, beside), mesh, sum(files.map(({ size }) => size)));
  }

  async forgetOld(): Promise<void> {
    const since = Date.now() - IndexedSceneStore.UNUSED_MESH_KEPT_MS;
    await this.forget(IndexedSceneStore.SCENES_KEPT, '', ({ savedAt }) => savedAt > since);
  }

  /** Opened when it is first asked for, and again after it has gone. */
  private get database(): Promise<IDBDatabase> {
    return (this.connection ??= openSceneDatabase(() => (this.connection = undefined)).catch((error: unknown) => {
      if (error instanceof OutdatedPage) throw error;
      throw new Error(`the browser keeps nothing for this page, as in some private windows${detail(error)}`);
    }));
  }

  /** Undefined where there is no database: all there is, the page has. */
  private async reading(tables: SceneTable[]): Promise<IDBTransaction | undefined> {
    const database = await this.database.catch((error: unknown) => {
      if (error instanceof OutdatedPage) throw error;
    });
    return database?.transaction(tables);
  }

  private async writeMesh({ id, header, content }: StoredMesh): Promise<void> {
    const transaction = (await this.database).transaction(['meshes', 'contents', 'companions'], 'readwrite');
    const meshes = transaction.objectStore('meshes');
    if ((await done(meshes.getKey(id))) === undefined) {
      const companionBytes = await new CompanionTable(transaction).bytes(id); // they may come before a mesh that is read back
      meshes.put({ id, header, bytes: content.size + companionBytes, companionBytes, savedAt: Date.now() } satisfies MeshFacts);
      transaction.objectStore('contents').put(content, id);
    }
    await committed(transaction);
  }

  private async writeCompanions(mesh: string, files: readonly File[], beside: boolean): Promise<void> {
    const transaction = (await this.database).transaction(['meshes', 'companions'], 'readwrite');
    const companionBytes = await new CompanionTable(transaction).put(mesh, files, beside);
    const meshes = transaction.objectStore('meshes');
    const facts = await done<MeshFacts | undefined>(meshes.get(mesh));
    if (facts) {
      const bytes = facts.bytes - (facts.companionBytes ?? 0) + companionBytes;
      meshes.put({ ...facts, bytes, companionBytes } satisfies MeshFacts);
    }
    await committed(transaction);
  }

  private async writeScene(scene: StoredScene): Promise<void> {
    const transaction = (await this.database).transaction('scenes', 'readwrite');
    transaction.objectStore('scenes').put(scene);
    await committed(transaction);
  }

  /** Writes `bytes` for the scenes of one mesh; rejects with an Error in words. */
  private async save(write: () => Promise<void>, mesh: string, bytes: number): Promise<void> {
    try {
      await write().catch((refusal: unknown) => this.makeRoom(refusal, write, mesh, bytes));
    } catch (error) {
      throw inWords(error);
    }
  }

  /**
   * Writes what there was no room for, without the scenes that were saved longest ago and their meshes: as many as it
   * takes, but none where even all of them do not take as much.
   */
  private async makeRoom(refusal: unknown, write: () => Promise<void>, mesh: string, bytes: number): Promise<void> {
    if (!isFull(refusal)) throw refusal;
    const transaction = (await this.database).transaction(['meshes', 'scenes']);
    const meshes = await done<MeshFacts[]>(transaction.objectStore('meshes').getAll());
    const scenes = await done(transaction.objectStore('scenes').count());
    const others = meshes.filter(({ id }) => id !== mesh);
    if (sum(others.map((other) => other.bytes)) < bytes) throw refusal;
    let freed = 0;
    for (let kept = scenes; kept >= 0 && freed < bytes; --kept) {
      freed += await this.forget(kept, mesh, () => false);
      try {
        return await write();
      } catch (error) {
        if (!isFull(error)) throw error;
      }
    }
    throw refusal;
  }

  /** Keeps so many scenes, the newest, and those of one mesh, and of meshes theirs and the spared; returns bytes freed. */
  private async forget(kept: number, inUse: string, isSpared: (mesh: MeshFacts) => boolean): Promise<number> {
    const transaction = (await this.database).transaction(['scenes', 'meshes', 'contents', 'companions'], 'readwrite');
    const scenes = transaction.objectStore('scenes');
    const used = new Set([inUse]);
    const newestFirst = (await done<StoredScene[]>(scenes.getAll())).sort((a, b) => b.savedAt - a.savedAt);
    newestFirst.forEach(({ id, mesh }, place) => {
      if (place < kept || mesh === inUse) used.add(mesh);
      else scenes.delete(id);
    });
    const meshes = await done<MeshFacts[]>(transaction.objectStore('meshes').getAll());
    for (const mesh of meshes) if (isSpared(mesh)) used.add(mesh.id);
    const useless = meshes.filter(({ id }) => !used.has(id));
    for (const { id } of useless) for (const table of ['meshes', 'contents']) transaction.objectStore(table).delete(id);
    await new CompanionTable(transaction).forgetAllBut(used);
    await committed(transaction);
    return sum(useless.map(({ bytes }) => bytes));
  }
}

function sum(numbers: readonly number[]): number {
  return numbers.reduce((total, one) => total + one, 0);
}

function isFull(error: unknown): boolean {
  return error instanceof DOMException && error.name === 'QuotaExceededError';
}

function inWords(error: unknown): Error {
  if (isFull(error)) return new Error('the browser has no room left for it');
  if (error instanceof Error && !(error instanceof DOMException)) return error;
  return new Error(`the browser could not keep it${detail(error)}`);
}

function detail(error: unknown): string {
  return error instanceof Error && error.message ? ` (${error.message})` : '';
}
