// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

interface Told {
  readonly fence: WebGLSync;
  readonly finished: () => void;
}

/**
 * Frames that the GPU has not finished. A browser accepts several, and each waits for those before it. If a frame takes
 * long, the picture on the screen is that many frames old.
 */
export class FrameQueue {
  private static readonly LONG_MS = 50; // shorter frames may overlap, since a GPU that waits for calls loses frames

  private readonly told: Told[] = [];
  private busySince = 0;
  /** The duration of the last frame that is done. */
  lastMs = 0;

  constructor(private readonly gl: WebGL2RenderingContext) {}

  get isEmpty(): boolean {
    return this.told.length === 0;
  }

  /** Whether another frame would have to wait. */
  get isFull(): boolean {
    return this.told.length >= (this.lastMs > FrameQueue.LONG_MS ? 1 : 2);
  }

  /** To be called after a frame's calls. Resolves once poll() finds that the GPU has done them. */
  add(): Promise<void> {
    const { gl } = this;
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    if (fence === null) return Promise.resolve(); // the context is lost
    gl.flush();
    if (this.isEmpty) this.busySince = performance.now();
    return new Promise((finished) => this.told.push({ fence, finished }));
  }

  /** Checks which frames are done. A browser reports this in the next task at the earliest. */
  poll(): void {
    const { gl, told } = this;
    const unfinished = told.findIndex(({ fence }) => gl.getSyncParameter(fence, gl.SYNC_STATUS) === gl.UNSIGNALED);
    const done = told.splice(0, unfinished < 0 ? told.length : unfinished);
    if (done.length === 0) return;
    const now = performance.now();
    this.lastMs = (now - this.busySince) / done.length;
    this.busySince = now;
    for (const { fence, finished } of done) {
      gl.deleteSync(fence);
      finished();
    }
  }
}
