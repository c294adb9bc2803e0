// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The surface's vertex buffer as the GPU has it.
import type { Page } from 'playwright-core';
import type {} from '@src/main'; // window.latticed
import type { PointBuffer } from '@src/surface/point_buffer';

/** Which array the page has sent to which buffer, and how many bytes of it since they were counted. */
interface Sent {
  buffer: WebGLBuffer;
  bytes: number;
}

type WatchingWindow = Window & { sent: Map<ArrayBufferLike, Sent> };

/** Follows what the page sends to the GPU from now on. */
export function watchUploads(page: Page): Promise<void> {
  return page.evaluate(() => {
    const sent = new Map<ArrayBufferLike, Sent>();
    const gl = WebGL2RenderingContext.prototype;
    const note = (context: WebGL2RenderingContext, data: unknown, bytes: number): void => {
      if (!ArrayBuffer.isView(data)) return;
      const buffer = context.getParameter(context.ARRAY_BUFFER_BINDING) as WebGLBuffer;
      sent.set(data.buffer, { buffer, bytes: (sent.get(data.buffer)?.bytes ?? 0) + bytes });
    };
    const { bufferData, bufferSubData } = gl;
    gl.bufferData = function (this: WebGL2RenderingContext, ...call: unknown[]): void {
      Reflect.apply(bufferData, this, call);
      if (call[0] === this.ARRAY_BUFFER) note(this, call[1], (call[1] as ArrayBufferView).byteLength);
    } as typeof bufferData;
    gl.bufferSubData = function (this: WebGL2RenderingContext, ...call: unknown[]): void {
      Reflect.apply(bufferSubData, this, call);
      const data = call[2] as Uint16Array;
      const numbers = (call[4] as number | undefined) ?? data.length;
      if (call[0] === this.ARRAY_BUFFER) note(this, data, numbers * data.BYTES_PER_ELEMENT);
    } as typeof bufferSubData;
    Object.assign(window, { sent });
  });
}

/** In bytes of the layout that is drawn. */
export interface Uploaded {
  /** In the GPU's buffer, and not as they were received. */
  readonly wrong: number;
  readonly all: number;
  /** To the GPU, since this was asked before. */
  readonly sent: number;
}

export function uploaded(page: Page): Promise<Uploaded> {
  return page.evaluate(() => {
    const surface = window.latticed.scene!.session.surface as unknown as {
      points: PointBuffer; drawnLayout: { pointCount: number } };
    const first = surface.points.pointAt(0);
    const gl = window.latticed.viewport.renderer.getContext() as WebGL2RenderingContext;
    const received = new Uint8Array(first.buffer, 0, first.byteLength * surface.drawnLayout.pointCount);
    const read = new Uint8Array(received.length);
    const sent = (window as unknown as WatchingWindow).sent.get(first.buffer);
    if (sent === undefined) return { wrong: received.length, all: received.length, sent: 0 };
    const bound = gl.getParameter(gl.ARRAY_BUFFER_BINDING) as WebGLBuffer | null;
    gl.bindBuffer(gl.ARRAY_BUFFER, sent.buffer);
    gl.getBufferSubData(gl.ARRAY_BUFFER, 0, read);
    gl.bindBuffer(gl.ARRAY_BUFFER, bound);
    const { bytes } = sent;
    sent.bytes = 0;
    return { wrong: read.reduce((count, byte, i) => count + Number(byte !== received[i]), 0), all: read.length, sent: bytes };
  });
}
