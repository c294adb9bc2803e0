// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** The part of draco3d's decoder that the viewer uses. The published types lack SkipAttributeTransform. */
declare module 'draco3d/draco_decoder_nodejs.js' {
  export interface Status {
    ok(): boolean;
    error_msg(): string;
  }
  export interface PointCloud {
    num_points(): number;
  }
  export type Attribute = object;
  export interface DecoderBuffer {
    Init(bytes: Uint8Array, length: number): void;
  }
  export interface Decoder {
    SkipAttributeTransform(type: number): void;
    GetEncodedGeometryType(buffer: DecoderBuffer): number;
    DecodeBufferToPointCloud(buffer: DecoderBuffer, cloud: PointCloud): Status;
    DecodeBufferToMesh(buffer: DecoderBuffer, mesh: PointCloud): Status;
    GetAttributeId(cloud: PointCloud, type: number): number;
    GetAttribute(cloud: PointCloud, id: number): Attribute;
    GetAttributeDataArrayForAllPoints(
      cloud: PointCloud, attribute: Attribute, type: number, bytes: number, address: number): boolean;
  }
  export interface DecoderModule {
    readonly POSITION: number;
    readonly NORMAL: number;
    readonly TRIANGULAR_MESH: number;
    readonly DT_INT32: number;
    readonly HEAP32: Int32Array;
    readonly Decoder: new () => Decoder;
    readonly DecoderBuffer: new () => DecoderBuffer;
    readonly PointCloud: new () => PointCloud;
    readonly Mesh: new () => PointCloud;
    _malloc(bytes: number): number;
    _free(address: number): void;
    destroy(object: object): void;
  }
  export default function createDecoderModule(options: { wasmBinary?: ArrayBuffer }): Promise<DecoderModule>;
}
