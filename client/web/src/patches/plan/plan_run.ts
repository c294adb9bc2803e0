// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** Undoes a zlib stream (RFC 1950). Rejects if it is none, or if it does not hold this number of bytes. */
export async function inflated(data: Uint8Array<ArrayBuffer>, bytes: number): Promise<Uint8Array> {
  const stream = new Blob([data]).stream().pipeThrough(new DecompressionStream('deflate'));
  const result = new Uint8Array(bytes);
  let length = 0;
  const reader = stream.getReader();
  try {
    for (let next = await reader.read(); !next.done; next = await reader.read()) {
      if (length + next.value.length > bytes) throw new Error(`it is longer than ${bytes} bytes`);
      result.set(next.value, length);
      length += next.value.length;
    }
  } catch (error) {
    throw new Error(`A run of the patch plan cannot be read: ${(error as Error).message}.`);
  }
  if (length < bytes) throw new Error(`A run of the patch plan has ${length} bytes in place of ${bytes}.`);
  return result;
}

/** Arrays of integers in byte planes: the lowest bytes of all numbers, then the next bytes. */
export class BytePlanes {
  private at = 0;

  constructor(private readonly bytes: Uint8Array) {}

  /** The next `count` numbers of `width` bytes. */
  next(count: number, width: 2 | 4): Uint32Array {
    const numbers = new Uint32Array(count);
    for (let shift = 0; shift < 8 * width; shift += 8) {
      for (let i = 0; i < count; ++i) numbers[i]! |= this.bytes[this.at + i]! << shift;
      this.at += count;
    }
    return numbers;
  }
}

/**
 * Numbers of things in the order of first use, of which `known` have come: 0 is a new one, c > 0 is that of c before it.
 *
 * @param news How many are new; throws, with the name of the things, if it is another number or one of none.
 */
export function decodeUses(codes: Uint32Array, known: number, news: number, what: string): Uint32Array {
  let next = known;
  const uses = codes.map((code) => {
    if (code > next) throw new Error(`A patch of the plan uses a ${what} that has not come.`);
    return code === 0 ? next++ : next - code;
  });
  if (next - known !== news) throw new Error(`A run of the plan has ${next - known} new ${what}s in place of ${news}.`);
  return uses;
}

/** Running sums of differences, written as 2 d, or -2 d - 1 if d is below 0. */
export function decodeDifferences(codes: Uint32Array): Int32Array {
  let sum = 0;
  return Int32Array.from(codes, (code) => (sum += code % 2 === 0 ? code / 2 : -(code + 1) / 2));
}
