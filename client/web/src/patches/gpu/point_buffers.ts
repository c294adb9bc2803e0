// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/**
 * The buffers of an evaluation on the GPU. Handles stay the same when they get more room.
 *
 *   places      uint32 patch, uint32 i_1 | i_2 << 16 per point
 *   positions   float32 x y z, relative to the plan's origin
 *   normals     float32 x y z
 */
export class PointBuffers {
  readonly places: WebGLBuffer;
  readonly positions: WebGLBuffer;
  readonly normals: WebGLBuffer;
  private room = 0;

  constructor(private readonly gl: WebGL2RenderingContext) {
    [this.places, this.positions, this.normals] = [gl.createBuffer(), gl.createBuffer(), gl.createBuffer()];
  }

  /** Makes room for this many points. What the buffers held is lost if they had less. Returns whether they had. */
  reserve(points: number): boolean {
    if (points <= this.room) return false;
    const { gl } = this;
    this.room = points;
    for (const [buffer, bytes] of [[this.places, 8], [this.positions, 12], [this.normals, 12]] as const) {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, bytes * points, gl.DYNAMIC_COPY);
    }
    gl.bindBuffer(gl.ARRAY_BUFFER, null);
    return true;
  }

  /** Sends places of `count` points from `first`; `places` are those of all points. */
  writePlaces(places: Uint32Array, first: number, count: number): void {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.places);
    gl.bufferSubData(gl.ARRAY_BUFFER, 8 * first, places, 2 * first, 2 * count);
    gl.bindBuffer(gl.ARRAY_BUFFER, null);
  }

  /** Waits for the GPU, and reads positions and normals of the first `count` points: x y z each. */
  read(count: number): { positions: Float32Array; normals: Float32Array } {
    const { gl } = this;
    const read = (buffer: WebGLBuffer): Float32Array => {
      const numbers = new Float32Array(3 * count);
      gl.bindBuffer(gl.COPY_READ_BUFFER, buffer);
      gl.getBufferSubData(gl.COPY_READ_BUFFER, 0, numbers);
      gl.bindBuffer(gl.COPY_READ_BUFFER, null);
      return numbers;
    };
    return { positions: read(this.positions), normals: read(this.normals) };
  }

  dispose(): void {
    for (const buffer of [this.places, this.positions, this.normals]) this.gl.deleteBuffer(buffer);
  }
}
