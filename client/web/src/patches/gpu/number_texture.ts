// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** Texels in a row; the shader has it too. Every WebGL2 has textures of this size. */
const WIDTH = 2048;

/** A texture of four numbers a texel, which a shader reads by texelFetch alone. */
export class NumberTexture {
  private readonly texture: WebGLTexture;
  private readonly height: number;

  /** @param data Four numbers per texel. Throws, in words, if they are too many for this GPU. */
  constructor(private readonly gl: WebGL2RenderingContext, private readonly unit: number, data: Int32Array | Float32Array) {
    this.height = Math.max(1, Math.ceil(data.length / (4 * WIDTH)));
    if (this.height > (gl.getParameter(gl.MAX_TEXTURE_SIZE) as number)) throw new Error('The scene has too many patches for this GPU.');
    this.texture = gl.createTexture();
    this.bind();
    gl.texStorage2D(gl.TEXTURE_2D, 1, data instanceof Int32Array ? gl.RGBA32I : gl.RGBA32F, WIDTH, this.height);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    this.write(data);
  }

  bind(): void {
    this.gl.activeTexture(this.gl.TEXTURE0 + this.unit);
    this.gl.bindTexture(this.gl.TEXTURE_2D, this.texture);
  }

  /** Sends the rows that hold texels `first` to `end` - 1; `data` are all numbers. Absent: all. */
  write(data: Int32Array | Float32Array, first = 0, end = Math.ceil(data.length / 4)): void {
    const { gl } = this;
    this.bind();
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 4);
    for (const name of [gl.UNPACK_ROW_LENGTH, gl.UNPACK_SKIP_ROWS, gl.UNPACK_SKIP_PIXELS, gl.UNPACK_FLIP_Y_WEBGL,
      gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL]) gl.pixelStorei(name, 0);
    const isInteger = data instanceof Int32Array;
    const send = (row: number, width: number, rows: number): void => {
      const at = 4 * WIDTH * row;
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, row, width, rows, isInteger ? gl.RGBA_INTEGER : gl.RGBA, isInteger ? gl.INT : gl.FLOAT,
        data.subarray(at, at + 4 * width * rows));
    };
    const firstRow = Math.floor(first / WIDTH);
    const endRow = Math.ceil(end / WIDTH);
    const whole = Math.min(endRow, Math.floor(data.length / (4 * WIDTH))); // the last row may be shorter
    if (whole > firstRow) send(firstRow, WIDTH, whole - firstRow);
    const rest = (data.length / 4) % WIDTH;
    if (endRow > whole && rest > 0) send(endRow - 1, rest, 1);
  }

  dispose(): void {
    this.gl.deleteTexture(this.texture);
  }
}
