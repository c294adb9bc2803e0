// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The values of a PLY file, record by record: ascii, binary little and big endian. The server has read the file before,
// so that what is malformed does not come here.

const TYPES = {
  int8: 1, uint8: 1, int16: 2, uint16: 2, int32: 4, uint32: 4, float32: 4, float64: 8,
} as const;
type PlyType = keyof typeof TYPES;

const OLD_NAMES: Record<string, PlyType> = {
  char: 'int8', uchar: 'uint8', short: 'int16', ushort: 'uint16', int: 'int32', uint: 'uint32', float: 'float32', double: 'float64',
};

interface PlyProperty {
  readonly name: string;
  readonly type: PlyType;
  /** Of a list's length; absent for a single value. */
  readonly countType?: PlyType;
}

export interface PlyElement {
  readonly name: string;
  readonly count: number;
  readonly properties: PlyProperty[];
}

export interface PlyForm {
  readonly encoding: 'ascii' | 'binary_little_endian' | 'binary_big_endian';
  readonly bodyOffset: number;
}

export interface PlyHeader extends PlyForm {
  readonly elements: readonly PlyElement[];
  readonly comments: readonly string[];
}

export function readPlyHeader(bytes: Uint8Array): PlyHeader {
  const latin = new TextDecoder('latin1');
  const elements: PlyElement[] = [];
  const comments: string[] = [];
  let encoding: PlyForm['encoding'] = 'ascii';
  for (let at = 0; at < bytes.length;) {
    let end = at;
    while (end < bytes.length && bytes[end] !== 10 && bytes[end] !== 13) ++end;
    const line = latin.decode(bytes.subarray(at, end)).trim();
    at = end + (bytes[end] === 13 && bytes[end + 1] === 10 ? 2 : 1);
    const [word, ...rest] = line.split(/\s+/);
    if (word === 'format') encoding = rest[0] as PlyForm['encoding'];
    else if (word === 'comment') comments.push(line.slice('comment'.length));
    else if (word === 'element') elements.push({ name: rest[0], count: Number(rest[1]), properties: [] });
    else if (word === 'property') elements[elements.length - 1].properties.push(property(rest));
    else if (word === 'end_header') return { encoding, elements, comments, bodyOffset: at };
  }
  throw new Error('The file ends before end_header.');
}

function property(words: readonly string[]): PlyProperty {
  const type = (word: string): PlyType => OLD_NAMES[word] ?? (word as PlyType);
  return words[0] === 'list'
    ? { name: words[3], type: type(words[2]), countType: type(words[1]) }
    : { name: words[1], type: type(words[0]) };
}

export class PlyBody {
  private readonly next: (type: PlyType) => number;

  constructor(bytes: Uint8Array, { encoding, bodyOffset }: PlyForm) {
    const body = bytes.subarray(bodyOffset);
    this.next = encoding === 'ascii' ? asciiNumbers(body) : binaryNumbers(body, encoding === 'binary_little_endian');
  }

  /** The values of the next record: one array per property. */
  record(element: PlyElement): number[][] {
    return element.properties.map(({ type, countType }) => {
      const length = countType === undefined ? 1 : this.next(countType);
      return Array.from({ length }, () => this.next(type));
    });
  }
}

function asciiNumbers(body: Uint8Array): () => number {
  const words = new TextDecoder().decode(body).matchAll(/\S+/g);
  return () => Number(words.next().value?.[0]);
}

function binaryNumbers(body: Uint8Array, little: boolean): (type: PlyType) => number {
  const view = new DataView(body.buffer, body.byteOffset, body.byteLength);
  let at = 0;
  return (type) => {
    const place = at;
    at += TYPES[type];
    switch (type) {
      case 'int8': return view.getInt8(place);
      case 'uint8': return view.getUint8(place);
      case 'int16': return view.getInt16(place, little);
      case 'uint16': return view.getUint16(place, little);
      case 'int32': return view.getInt32(place, little);
      case 'uint32': return view.getUint32(place, little);
      case 'float32': return view.getFloat32(place, little);
      case 'float64': return view.getFloat64(place, little);
    }
  };
}
