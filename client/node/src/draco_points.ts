// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Decodes chunks of ENCODING_DRACO_POINTS to arrays, by draco3d.
import draco3d from 'draco3d';
import type { Decoder, DecoderModule, PointCloud } from 'draco3d';

export interface Points {
  positions: Float32Array;  // x y z of each point, relative to Quantisation.origin
  normals: Float32Array;    // x y z of each, unit vectors; empty if the view has none
}

export class DracoPoints {
  private constructor(private readonly draco: DecoderModule) {}

  static async create(): Promise<DracoPoints> {
    return new DracoPoints(await draco3d.createDecoderModule({}));
  }

  /** Throws if the bytes are no Draco point cloud. */
  decode(data: Uint8Array): Points {
    const { draco } = this;
    const buffer = new draco.DecoderBuffer();
    const decoder = new draco.Decoder();
    const cloud = new draco.PointCloud();
    try {
      buffer.Init(new Int8Array(data.buffer, data.byteOffset, data.byteLength), data.byteLength);
      const status = decoder.DecodeBufferToPointCloud(buffer, cloud);
      if (!status.ok()) throw new Error(`a chunk is no Draco point cloud: ${status.error_msg()}`);
      return {
        positions: this.attribute(decoder, cloud, draco.POSITION),
        normals: this.attribute(decoder, cloud, draco.NORMAL),
      };
    } finally {
      for (const object of [cloud, decoder, buffer]) draco.destroy(object);
    }
  }

  private attribute(decoder: Decoder, cloud: PointCloud, type: number): Float32Array {
    const { draco } = this;
    const id = decoder.GetAttributeId(cloud, type);
    if (id < 0) return new Float32Array();
    const count = 3 * cloud.num_points();
    const bytes = count * Float32Array.BYTES_PER_ELEMENT;
    const place = draco._malloc(bytes);
    try {
      decoder.GetAttributeDataArrayForAllPoints(
        cloud, decoder.GetAttribute(cloud, id), draco.DT_FLOAT32, bytes, place);
      return new Float32Array(draco.HEAPF32.buffer, place, count).slice();
    } finally {
      draco._free(place);
    }
  }
}
