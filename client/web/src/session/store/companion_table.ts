// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { done } from './scene_database';

/** In the order in which they came. */
type Key = [mesh: string, place: number, name: string, bytes: number];

/**
 * Pictures and materials that were dropped beside meshes, in a transaction. Keys say what is there: a File that the page
 * has read takes its room even after it was deleted.
 */
export class CompanionTable {
  private readonly table: IDBObjectStore;

  constructor(transaction: IDBTransaction) {
    this.table = transaction.objectStore('companions');
  }

  files(mesh: string): Promise<File[]> {
    return done<File[]>(this.table.getAll(keysOf(mesh)));
  }

  async bytes(mesh: string): Promise<number> {
    return bytesOf(await this.keys(mesh));
  }

  /** In place of all, or only of those that have their names; returns the bytes of what is there then. */
  async put(mesh: string, files: readonly File[], beside: boolean): Promise<number> {
    const before = await this.keys(mesh);
    const names = new Set(files.map(({ name }) => name));
    const kept = before.filter(([, , name]) => beside && !names.has(name));
    const first = (before.at(-1)?.[1] ?? 0) + 1;
    const added = files.map(({ name, size }, i): Key => [mesh, first + i, name, size]);
    for (const key of before) if (!kept.includes(key)) this.table.delete(key);
    files.forEach((file, i) => this.table.put(file, added[i]));
    return bytesOf([...kept, ...added]);
  }

  async forgetAllBut(meshes: ReadonlySet<string>): Promise<void> {
    for (const key of await this.keys()) if (!meshes.has(key[0])) this.table.delete(key);
  }

  private async keys(mesh?: string): Promise<Key[]> {
    return (await done(this.table.getAllKeys(mesh === undefined ? null : keysOf(mesh)))) as Key[];
  }
}

function keysOf(mesh: string): IDBKeyRange {
  return IDBKeyRange.bound([mesh], [mesh, []]); // a list is more than any number
}

function bytesOf(keys: readonly Key[]): number {
  return keys.reduce((total, [, , , bytes]) => total + bytes, 0);
}
