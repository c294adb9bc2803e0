// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { committed, COMPANIONS, done, openCompanionDatabase } from './companion_database';

/** The key of a companion. `time` is Date.now() of its save, or more: later ones of a mesh have larger times. */
type CompanionKey = [mesh: string, time: number, name: string, bytes: number];

/**
 * The pictures and materials that were dropped beside meshes, in the browser's IndexedDB: the server takes only meshes.
 * Those of the 16 meshes that got companions last are kept. Saving rejects, with an Error in words, if something would
 * not outlive the page.
 */
export class CompanionStore {
  private static readonly MESHES_KEPT = 16;
  private static page: CompanionStore | undefined;

  private connection: Promise<IDBDatabase> | undefined;

  /** The store that all parts of the page share. */
  static ofPage(): CompanionStore {
    return (CompanionStore.page ??= new CompanionStore());
  }

  /** The companions of a mesh, in the order in which they came. */
  async of(mesh: string): Promise<readonly File[]> {
    const database = await this.database.catch(() => undefined);
    if (database === undefined) return [];
    return done<File[]>(database.transaction(COMPANIONS).objectStore(COMPANIONS).getAll(companionsOf(mesh)));
  }

  /**
   * Replaces all companions of a mesh, or with `beside` only those of the same names. Where the browser has no room, the
   * companions of the meshes that got theirs first are deleted; none, if all of them together take too little.
   */
  async save(mesh: string, files: readonly File[], beside = false): Promise<void> {
    try {
      await this.write(mesh, files, beside).catch((refusal: unknown) => this.makeRoom(refusal, mesh, files, beside));
    } catch (error) {
      throw inWords(error);
    }
  }

  /** Opened on first use, and again after the connection has gone. */
  private get database(): Promise<IDBDatabase> {
    return (this.connection ??= openCompanionDatabase(() => (this.connection = undefined)).catch((error: unknown) => {
      throw new Error(`the browser keeps nothing for this page, as in some private windows${detail(error)}`);
    }));
  }

  private async write(mesh: string, files: readonly File[], beside: boolean): Promise<void> {
    const transaction = (await this.database).transaction(COMPANIONS, 'readwrite');
    const table = transaction.objectStore(COMPANIONS);
    const before = (await done(table.getAllKeys(companionsOf(mesh)))) as CompanionKey[];
    const names = new Set(files.map(({ name }) => name));
    for (const key of before) if (!beside || names.has(key[2])) table.delete(key);
    const first = Math.max(Date.now(), (before.at(-1)?.[1] ?? 0) + 1);
    files.forEach((file, i) => table.put(file, [mesh, first + i, file.name, file.size] satisfies CompanionKey));
    await forget(table, mesh, CompanionStore.MESHES_KEPT - 1);
    await committed(transaction);
  }

  /** Deletes the companions of other meshes, the oldest first, until the files fit. */
  private async makeRoom(refusal: unknown, mesh: string, files: readonly File[], beside: boolean): Promise<void> {
    if (!isFull(refusal)) throw refusal;
    const needed = files.reduce((sum, { size }) => sum + size, 0);
    const reading = (await this.database).transaction(COMPANIONS);
    const others = ((await done(reading.objectStore(COMPANIONS).getAllKeys())) as CompanionKey[]).filter(([id]) => id !== mesh);
    if (others.reduce((sum, [, , , bytes]) => sum + bytes, 0) < needed) throw refusal;
    for (let kept = new Set(others.map(([id]) => id)).size - 1; kept >= 0; --kept) {
      const transaction = (await this.database).transaction(COMPANIONS, 'readwrite');
      await forget(transaction.objectStore(COMPANIONS), mesh, kept);
      await committed(transaction);
      try {
        return await this.write(mesh, files, beside);
      } catch (error) {
        if (!isFull(error)) throw error;
      }
    }
    throw refusal;
  }
}

/** Deletes the companions of all meshes but this one and the `kept` others that got theirs last. */
async function forget(table: IDBObjectStore, mesh: string, kept: number): Promise<void> {
  const keys = (await done(table.getAllKeys())) as CompanionKey[];
  const newest = new Map<string, number>();
  for (const [id, time] of keys) if (id !== mesh) newest.set(id, Math.max(time, newest.get(id) ?? 0));
  const newestFirst = [...newest].sort(([, a], [, b]) => b - a).map(([id]) => id);
  const forgotten = new Set(newestFirst.slice(kept));
  for (const key of keys) if (forgotten.has(key[0])) table.delete(key);
}

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
