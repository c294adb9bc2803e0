// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Decodes any Draco point cloud to the integers that were encoded, by draco3d.
import draco3d from 'draco3d';
import type { Decoder, DecoderModule, PointCloud } from 'draco3d';
import type { EncodedChunk } from './draco_points.js';

export class StockDecoder {
  private constructor(private readonly draco: DecoderModule) {}

  static async create(): Promise<StockDecoder> {
    return new StockDecoder(await draco3d.createDecoderModule({}));
  }

  /** x y z 0 s t of each point. Throws if the bytes are no Draco point cloud of so many points. */
  decode({ data, points }: EncodedChunk, hasNormals: boolean): Uint16Array {
    const { draco } = this;
    const buffer = new draco.DecoderBuffer();
    const decoder = new draco.Decoder() as Decoder & { SkipAttributeTransform(type: number): void };
    const cloud = new draco.PointCloud();
    try {
      for (const type of [draco.POSITION, draco.NORMAL]) decoder.SkipAttributeTransform(type);
      buffer.Init(new Int8Array(data.buffer, data.byteOffset, data.byteLength), data.byteLength);
      const status = decoder.DecodeBufferToPointCloud(buffer, cloud);
      if (!status.ok()) throw new Error(`a chunk is no Draco point cloud: ${status.error_msg()}`);
      if (cloud.num_points() !== points) throw new Error(`a chunk holds ${cloud.num_points()} points instead of ${points}`);
      const numbers = new Uint16Array(6 * points);
      this.read(decoder, cloud, draco.POSITION, 3, numbers, 0);
      if (hasNormals) this.read(decoder, cloud, draco.NORMAL, 2, numbers, 4);
      return numbers;
    } finally {
      for (const object of [cloud, decoder, buffer]) draco.destroy(object);
    }
  }

  private read(decoder: Decoder, cloud: PointCloud, type: number, components: number, out: Uint16Array, first: number): void {
    const { draco } = this;
    const id = decoder.GetAttributeId(cloud, type);
    if (id < 0) throw new Error('a chunk lacks positions or normals');
    const values = new draco.DracoInt32Array();
    try {
      decoder.GetAttributeInt32ForAllPoints(cloud, decoder.GetAttribute(cloud, id), values);
      for (let i = 0; i < components * cloud.num_points(); ++i) out[6 * Math.floor(i / components) + first + i % components] = values.GetValue(i);
    } finally {
      draco.destroy(values);
    }
  }
}
