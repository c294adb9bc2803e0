// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The file of a backup, as latticectl and the Python package write and read it too:
//
//   "latticed backup 1\n" | size of a part, 32 bits, little-endian | the part, a BackupPart | size | part | …
//
// The last part is the end, with the number of parts before it and the SHA-256 of all bytes before its size.
import { createHash } from 'node:crypto';
import { closeSync, fsyncSync, openSync, readSync, renameSync, rmSync, writeFileSync } from 'node:fs';
import type { BackupPart__Output } from './generated/latticed/v1/BackupPart.js';

/** BackupParts to bytes and back. */
export interface PartCodec {
  encode(part: BackupPart__Output): Buffer;
  decode(bytes: Buffer): BackupPart__Output;
}

const MAGIC = Buffer.from('latticed backup 1\n');
const MOST_PART_BYTES = 1 << 20;
const SIZE_BYTES = 4;
const CHANGED = 'was changed since it was written';

/** Writes PATH.part, and gives it its name when it is whole. Returns the number of bytes. */
export async function writeBackup(path: string, parts: AsyncIterable<BackupPart__Output>, codec: PartCodec): Promise<number> {
  const partPath = `${path}.part`;
  const file = openSync(partPath, 'w');
  try {
    const sum = createHash('sha256').update(MAGIC);
    let [bytes, hasEnd] = [MAGIC.length, false];
    writeFileSync(file, MAGIC);  // all of it, where writeSync may write less
    for await (const part of parts) {
      hasEnd = part.end != null;
      if (part.end) part.end.sha256 = sum.copy().digest('hex');
      const message = codec.encode(part);
      const framed = Buffer.concat([sizeOf(message), message]);
      sum.update(framed);
      writeFileSync(file, framed);
      bytes += framed.length;
    }
    if (!hasEnd) throw new Error('the server sent less than all');
    fsyncSync(file);
    renameSync(partPath, path);
    return bytes;
  } finally {
    closeSync(file);
    rmSync(partPath, { force: true });
  }
}

/** The parts of a file. Throws if it is no backup, or not whole: read it to its end before you send anything. */
export function* readBackup(path: string, codec: PartCodec): Generator<BackupPart__Output> {
  const damaged = (what: string): Error => new Error(`${path} ${what}; nothing was sent`);
  const file = openSync(path, 'r');
  const read = (size: number): Buffer => {
    const bytes = Buffer.alloc(size);
    let done = 0;
    for (let got = 1; got > 0 && done < size; done += got) got = readSync(file, bytes, done, size - done, null);
    return bytes.subarray(0, done);
  };
  try {
    const magic = read(MAGIC.length);
    if (!magic.equals(MAGIC)) throw damaged('is no backup that this program can read');
    const sum = createHash('sha256').update(magic);
    for (let count = 0; ; ++count) {
      const size = read(SIZE_BYTES);
      if (size.length < SIZE_BYTES) throw damaged('is cut off');
      const length = size.readUInt32LE();
      if (length > MOST_PART_BYTES) throw damaged(CHANGED);
      const message = read(length);
      if (message.length < length) throw damaged('is cut off');
      const part = decoded(message, codec) ?? raise(damaged(CHANGED));
      if (!part.end) sum.update(size).update(message);
      else if (part.end.sha256 !== sum.digest('hex') || part.end.parts !== count) throw damaged(CHANGED);
      else if (read(1).length > 0) throw damaged('has bytes after its end');
      yield part;
      if (part.end) return;
    }
  } finally {
    closeSync(file);
  }
}

function sizeOf(message: Buffer): Buffer {
  const size = Buffer.alloc(SIZE_BYTES);
  size.writeUInt32LE(message.length);
  return size;
}

function decoded(message: Buffer, codec: PartCodec): BackupPart__Output | undefined {
  try {
    return codec.decode(message);
  } catch {
    return undefined;
  }
}

function raise(error: Error): never {
  throw error;
}
