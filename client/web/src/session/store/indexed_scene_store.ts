// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { committed, done, openSceneDatabase, type MeshFacts, type SceneTable } from './scene_database';
import type { StoredMesh, StoredScene } from './scene_store';

/** The key of a companion. The companions of a mesh are in the order in which they came. */
type CompanionKey = [mesh: string, place: number, name: string, bytes: number];

/**
 * Scenes and meshes in the browser's IndexedDB, with the files that were dropped beside a mesh. They outlive the
 * server. Saving rejects, with an Error in words, if something would not outlive the page. The page itself holds the
 * newest mesh and scene while they are being written, or if writing was refused.
 */
export class IndexedSceneStore {
  private static readonly SCENES_KEPT = 16;
  private static readonly UNUSED_MESH_KEPT_MS = 60 * 60 * 1000;  // a window may be about to make a scene of it
  private static page: IndexedSceneStore | undefined;

  private connection: Promise<IDBDatabase> | undefined;
  private unwrittenMesh: StoredMesh | undefined;
  private unwrittenScene: StoredScene | undefined;

  /** The store that all sessions of the page share. */
  static ofPage(): IndexedSceneStore {
    return (IndexedSceneStore.page ??= new IndexedSceneStore());
  }

  /** Whether a mesh is stored so that it outlives the page. */
  async keepsMesh(id: string): Promise<boolean> {
    const meshes = (await this.reading('meshes'))?.objectStore('meshes');
    return meshes !== undefined && (await done(meshes.getKey(id))) !== undefined;
  }

  async mesh(id: string): Promise<StoredMesh | undefined> {
    if (this.unwrittenMesh?.id === id) return this.unwrittenMesh;
    const transaction = await this.reading('meshes', 'contents');
    const facts = transaction && (await done<MeshFacts | undefined>(transaction.objectStore('meshes').get(id)));
    return facts && { id, header: facts.header, content: await done<Blob>(transaction.objectStore('contents').get(id)) };
  }

  async scene(id: string): Promise<StoredScene | undefined> {
    if (this.unwrittenScene?.id === id) return this.unwrittenScene;
    const transaction = await this.reading('scenes');
    return transaction && done<StoredScene | undefined>(transaction.objectStore('scenes').get(id));
  }

  /** Does nothing if the mesh is stored already. */
  async saveMesh(mesh: StoredMesh): Promise<void> {
    const { id, header, content } = mesh;
    this.unwrittenMesh = mesh;
    await this.save(id, content.size, ['meshes', 'contents'], async (transaction) => {
      const meshes = transaction.objectStore('meshes');
      if ((await done(meshes.getKey(id))) !== undefined) return;
      meshes.put({ id, header, bytes: content.size, savedAt: Date.now() } satisfies MeshFacts);
      transaction.objectStore('contents').put(content, id);
    });
    if (this.unwrittenMesh === mesh) this.unwrittenMesh = undefined;
  }

  async saveScene(scene: StoredScene): Promise<void> {
    this.unwrittenScene = scene;
    await this.save(scene.mesh, scene.request.length, ['scenes'], (transaction) => {
      transaction.objectStore('scenes').put(scene);
    });
    if (this.unwrittenScene === scene) this.unwrittenScene = undefined;
  }

  /** Pictures and materials that were dropped beside a mesh. */
  async companions(mesh: string): Promise<readonly File[]> {
    const transaction = await this.reading('companions');
    return transaction === undefined ? [] : done<File[]>(transaction.objectStore('companions').getAll(companionsOf(mesh)));
  }

  /** Replaces all companions, or with `beside` only those of the same names. */
  saveCompanions(mesh: string, files: readonly File[], beside = false): Promise<void> {
    const size = files.reduce((sum, file) => sum + file.size, 0);
    return this.save(mesh, size, ['companions'], async (transaction) => {
      const table = transaction.objectStore('companions');
      const before = (await done(table.getAllKeys(companionsOf(mesh)))) as CompanionKey[];
      const names = new Set(files.map(({ name }) => name));
      for (const key of before) if (!beside || names.has(key[2])) table.delete(key);
      const first = (before.at(-1)?.[1] ?? 0) + 1;
      files.forEach((file, i) => table.put(file, [mesh, first + i, file.name, file.size] satisfies CompanionKey));
    });
  }

  /** Deletes all scenes but the 16 newest ones, and meshes of no scene that were saved more than an hour ago. */
  forgetOld(): Promise<void> {
    return this.forget(IndexedSceneStore.SCENES_KEPT, '', Date.now() - IndexedSceneStore.UNUSED_MESH_KEPT_MS);
  }

  /** Opened on first use, and again after the connection has gone. */
  private get database(): Promise<IDBDatabase> {
    return (this.connection ??= openSceneDatabase(() => (this.connection = undefined)).catch((error: unknown) => {
      throw new Error(`the browser keeps nothing for this page, as in some private windows${detail(error)}`);
    }));
  }

  /** Undefined if there is no database: only the page's own memory is left then. */
  private async reading(...tables: SceneTable[]): Promise<IDBTransaction | undefined> {
    return (await this.database.catch(() => undefined))?.transaction(tables);
  }

  /** Writes `bytes` for one mesh; rejects with an Error in words. */
  private async save(
    mesh: string, bytes: number, tables: SceneTable[], write: (transaction: IDBTransaction) => Promise<void> | void,
  ): Promise<void> {
    const attempt = async (): Promise<void> => {
      const transaction = (await this.database).transaction(tables, 'readwrite');
      await write(transaction);
      await committed(transaction);
    };
    try {
      await attempt().catch((refusal: unknown) => this.makeRoom(refusal, mesh, bytes, attempt));
    } catch (error) {
      throw inWords(error);
    }
  }

  /**
   * Writes what did not fit. Deletes the scenes that were saved longest ago, with their meshes, until it fits. Deletes
   * nothing if all other meshes and their companions take fewer than `bytes` bytes.
   */
  private async makeRoom(refusal: unknown, mesh: string, bytes: number, attempt: () => Promise<void>): Promise<void> {
    if (!isFull(refusal)) throw refusal;
    const transaction = (await this.database).transaction(['scenes', 'meshes', 'companions']);
    const meshes = await done<MeshFacts[]>(transaction.objectStore('meshes').getAll());
    const companions = (await done(transaction.objectStore('companions').getAllKeys())) as CompanionKey[];
    const scenes = await done(transaction.objectStore('scenes').count());
    const taken = [...meshes.map(({ id, bytes }) => [id, bytes] as const), ...companions.map(([id, , , bytes]) => [id, bytes] as const)];
    if (taken.reduce((sum, [id, bytes]) => sum + (id === mesh ? 0 : bytes), 0) < bytes) throw refusal;
    for (let kept = scenes; kept >= 0; --kept) {
      await this.forget(kept, mesh);
      try {
        return await attempt();
      } catch (error) {
        if (!isFull(error)) throw error;
      }
    }
    throw refusal;
  }

  /** Deletes all scenes but the `kept` newest and those of the mesh in use, and unused meshes saved until `since`. */
  private async forget(kept: number, inUse: string, since = Infinity): Promise<void> {
    const tables: SceneTable[] = ['scenes', 'meshes', 'contents', 'companions'];
    const transaction = (await this.database).transaction(tables, 'readwrite');
    const [scenes, meshes, contents, companions] = tables.map((name) => transaction.objectStore(name));
    const used = new Set([inUse]);
    const newestFirst = (await done<StoredScene[]>(scenes.getAll())).sort((a, b) => b.savedAt - a.savedAt);
    newestFirst.forEach(({ id, mesh }, place) => {
      if (place < kept || mesh === inUse) used.add(mesh);
      else scenes.delete(id);
    });
    for (const { id, savedAt } of await done<MeshFacts[]>(meshes.getAll())) {
      if (savedAt > since) used.add(id);
      if (used.has(id)) continue;
      meshes.delete(id);
      contents.delete(id);
    }
    for (const key of (await done(companions.getAllKeys())) as CompanionKey[]) if (!used.has(key[0])) companions.delete(key);
    await committed(transaction);
  }
}

/** The part that a session uses. */
export type SceneStore = Pick<IndexedSceneStore, 'keepsMesh' | 'mesh' | 'scene' | 'saveMesh' | 'saveScene' | 'forgetOld'>;

function companionsOf(mesh: string): IDBKeyRange {
  return IDBKeyRange.bound([mesh], [mesh, []]); // an array sorts after every number
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
