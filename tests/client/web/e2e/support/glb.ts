// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// GLB files for tests, as in glTF 2.0, chapter 4.4.

const COMPONENT_TYPES = { Float32Array: 5126, Uint16Array: 5123 } as const;
const SIZES = { SCALAR: 1, VEC2: 2, VEC3: 3 } as const;

/** A square over -1 to 1, of two triangles. */
export const SQUARE = {
  positions: Float32Array.of(-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0),
  /** Show the whole picture upright. v counts downwards. */
  uvs: Float32Array.of(0, 1, 1, 1, 1, 0, 0, 0),
  indices: Uint16Array.of(0, 1, 2, 0, 2, 3),
};

/** Builds a GLB file: add numbers and pictures first, then call file() with the rest of the document. */
export class GlbMaker {
  private readonly parts: Buffer[] = [];
  private readonly views: object[] = [];
  private readonly accessors: object[] = [];
  private readonly images: object[] = [];
  private length = 0;

  /** Adds an accessor. Returns its index. */
  accessor(values: Float32Array | Uint16Array, type: keyof typeof SIZES): number {
    const size = SIZES[type];
    const axis = (a: number): number[] => Array.from(values).filter((_, i) => i % size === a);
    const limits = (most: (...numbers: number[]) => number): number[] => Array.from({ length: size }, (_, a) => most(...axis(a)));
    const componentType = COMPONENT_TYPES[values.constructor.name as keyof typeof COMPONENT_TYPES];
    const bufferView = this.view(Buffer.from(values.buffer, values.byteOffset, values.byteLength));
    const count = values.length / size;
    return this.accessors.push({ bufferView, componentType, count, type, min: limits(Math.min), max: limits(Math.max) }) - 1;
  }

  /** Adds an image, a PNG inside the file or one outside. Returns its index. */
  image(content: Buffer | { uri: string }): number {
    return this.images.push(content instanceof Buffer ? { bufferView: this.view(content), mimeType: 'image/png' } : content) - 1;
  }

  /** Adds a square. Returns the attributes and indices of its primitive. */
  square({ positions = SQUARE.positions, uvs = SQUARE.uvs, indices = SQUARE.indices } = {}): { attributes: Record<string, number>; indices: number } {
    return {
      attributes: { POSITION: this.accessor(positions, 'VEC3'), TEXCOORD_0: this.accessor(uvs, 'VEC2') },
      indices: this.accessor(indices, 'SCALAR'),
    };
  }

  file(document: object): Buffer {
    const { accessors, images, views: bufferViews, length: byteLength } = this;
    const json = JSON.stringify({ asset: { version: '2.0' }, ...document, accessors, bufferViews, buffers: [{ byteLength }], images });
    const body = Buffer.concat([chunk('JSON', Buffer.from(json), ' '), chunk('BIN\0', Buffer.concat(this.parts), '\0')]);
    return Buffer.concat([Buffer.from('glTF'), words(2, 12 + body.length), body]);
  }

  private view(bytes: Buffer): number {
    const byteOffset = this.length;
    const part = padded(bytes, '\0');
    this.parts.push(part);
    this.length += part.length;
    return this.views.push({ buffer: 0, byteOffset, byteLength: bytes.length }) - 1;
  }
}

function chunk(type: string, bytes: Buffer, fill: string): Buffer {
  const content = padded(bytes, fill);
  return Buffer.concat([words(content.length), Buffer.from(type), content]);
}

function padded(bytes: Buffer, fill: string): Buffer {
  return Buffer.concat([bytes, Buffer.alloc((4 - (bytes.length % 4)) % 4, fill)]);
}

function words(...values: number[]): Buffer {
  return Buffer.from(Uint32Array.from(values).buffer);
}
