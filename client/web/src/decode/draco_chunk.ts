// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import createDecoderModule, { type Decoder, type DecoderModule, type PointCloud } from 'draco3d/draco_decoder_nodejs.js';
import { NUMBERS_PER_POINT, type ChunkForm } from './chunk_form';

/**
 * Decodes Draco chunks by draco3d to the integers that were encoded: streams of a newer server, and in browsers without SIMD. Attribute transforms are skipped, since the vertex shader
 * undoes the quantisation: this saves 40 % of the time. One decoder and one piece of wasm memory serve all chunks.
 */
export class DracoChunkDecoder {
  private readonly decoder: Decoder;
  private address = 0;
  private capacity = 0;  // bytes at address

  private constructor(private readonly draco: DecoderModule) {
    this.decoder = new draco.Decoder();
    this.decoder.SkipAttributeTransform(draco.POSITION);
    this.decoder.SkipAttributeTransform(draco.NORMAL);
  }

  /** @param wasm draco_decoder.wasm of draco3d. */
  static async create(wasm: ArrayBuffer): Promise<DracoChunkDecoder> {
    return new DracoChunkDecoder(await createDecoderModule({ wasmBinary: wasm }));
  }

  /** Writes x y z 0 s t of each point. Throws if the stream is not a chunk of this form. */
  decode(data: Uint8Array, form: ChunkForm, out: Uint16Array): void {
    const { draco } = this;
    const buffer = new draco.DecoderBuffer();
    buffer.Init(data, data.length);
    const isMesh = this.decoder.GetEncodedGeometryType(buffer) === draco.TRIANGULAR_MESH;
    const cloud = isMesh ? new draco.Mesh() : new draco.PointCloud();
    try {
      const status = isMesh ? this.decoder.DecodeBufferToMesh(buffer, cloud)
                            : this.decoder.DecodeBufferToPointCloud(buffer, cloud);
      if (!status.ok()) throw new Error(`a chunk is no Draco stream: ${status.error_msg()}`);
      if (cloud.num_points() !== form.points) {
        throw new Error(`a Draco chunk of ${cloud.num_points()} points, not ${form.points}`);
      }
      this.read(cloud, draco.POSITION, 3, form.points, out, 0);
      if (form.normals) this.read(cloud, draco.NORMAL, 2, form.points, out, 4);
    } finally {
      draco.destroy(cloud);
      draco.destroy(buffer);
    }
  }

  private read(cloud: PointCloud, type: number, components: number, points: number, out: Uint16Array, place: number): void {
    const { draco, decoder } = this;
    const id = decoder.GetAttributeId(cloud, type);
    if (id < 0) throw new Error('a Draco chunk lacks positions or normals');
    const bytes = 4 * components * points;
    this.reserve(bytes);
    if (!decoder.GetAttributeDataArrayForAllPoints(
      cloud, decoder.GetAttribute(cloud, id), draco.DT_INT32, bytes, this.address)) {
      throw new Error('a Draco chunk holds no integers');
    }
    const values = draco.HEAP32;  // read again each time, since it is replaced when memory grows
    const begin = this.address / 4;
    for (let component = 0; component < components; ++component) {
      let at = place + component;
      for (let i = begin + component, end = begin + components * points; i < end; i += components) {
        out[at] = values[i]!;
        at += NUMBERS_PER_POINT;
      }
    }
  }

  private reserve(bytes: number): void {
    if (bytes <= this.capacity) return;
    if (this.address) this.draco._free(this.address);
    this.address = this.draco._malloc(bytes);
    this.capacity = bytes;
  }
}
