// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { BufferAttribute, BufferGeometry, DynamicDrawUsage, InterleavedBuffer, InterleavedBufferAttribute } from 'three';
import { NUMBERS_PER_POINT, type PointNumbers } from '../decode/chunk_form';
import type { TopologyLayout } from './topology_layout';
import { trianglesOf, type Detail } from './triangles';

interface Drawn {
  readonly layout: TopologyLayout;
  readonly details: readonly Detail[];
  readonly geometry: BufferGeometry;
}

/**
 * One vertex buffer for all chunks. It is written in place, and only written ranges go to the GPU.
 *
 *   integers   uint16 x y z 0 s t      12 bytes a point
 *   floats     float32 x y z nx ny nz  24 bytes a point, for RAW
 *
 * The buffer is allocated again only for more points or for the other type. The triangles of a topology are made once.
 * Those of the last 3 layouts are kept, since the level of detail often switches between them.
 */
export class PointBuffer {
  private static readonly LAYOUTS_KEPT = 3;

  private buffer: InterleavedBuffer | undefined;
  private isFloat = false;
  private detail = 0;
  private readonly drawn: Drawn[] = [];  // the newest first
  private readonly dirty = new Map<number, { count: number }>();  // ranges not uploaded yet, by first point

  /** Buffers and geometries made so far; tests count them. */
  made = 0;

  get float(): boolean {
    return this.isFloat;
  }

  /** Allocates if needed, and returns the geometry that draws this layout. */
  prepare(layout: TopologyLayout, float: boolean): BufferGeometry {
    const room = this.buffer ? this.buffer.count : 0;
    if (!this.buffer || float !== this.isFloat || room < layout.pointCount) this.allocate(layout.pointCount, float);
    const at = this.drawn.findIndex((one) => one.layout.id === layout.id);
    const found = at >= 0 ? this.drawn.splice(at, 1)[0]! : this.drawnOf(layout);
    this.drawn.unshift(found);
    // Frees its triangles, but not the shared vertex buffer, which dispose() would delete.
    if (this.drawn.length > PointBuffer.LAYOUTS_KEPT) release(this.drawn.pop()!.geometry);
    this.setDetail(this.detail);
    return found.geometry;
  }

  /** The details of the layout that is drawn, the finest first. */
  get details(): readonly Detail[] {
    return this.drawn[0]!.details;
  }

  /** Draws a detail by its number, or the coarsest if there are fewer. */
  setDetail(detail: number): void {
    this.detail = detail;
    const newest = this.drawn[0];
    if (newest === undefined) return;
    const { start, count } = newest.details[Math.min(detail, newest.details.length - 1)]!;
    newest.geometry.setDrawRange(start, count);
  }

  /** Writes points from `firstPoint` on; they reach the GPU with the next frame. */
  write(firstPoint: number, points: PointNumbers): void {
    const { buffer } = this;
    if (!buffer) throw new Error('write before prepare');
    const start = NUMBERS_PER_POINT * firstPoint;
    (buffer.array as PointNumbers).set(points, start);
    const range = this.dirty.get(firstPoint);  // a hidden page draws nothing: ranges must not pile up
    if (range) {
      range.count = Math.max(range.count, points.length);  // a chunk of another layout may begin at the same point
    } else {
      buffer.addUpdateRange(start, points.length);
      this.dirty.set(firstPoint, buffer.updateRanges.at(-1)!);
    }
    buffer.needsUpdate = true;
  }

  /** The numbers of all points. */
  get numbers(): ArrayLike<number> {
    return this.buffer?.array ?? [];
  }

  /** The numbers of one point. */
  pointAt(point: number): PointNumbers {
    return (this.buffer!.array as PointNumbers).subarray(NUMBERS_PER_POINT * point, NUMBERS_PER_POINT * (point + 1));
  }

  /** Draws with at most this number of triangles, if there is so coarse a detail, and then as before. */
  drawCoarse(triangles: number, draw: () => void): void {
    const { geometry, details } = this.drawn[0]!;
    const { start, count } = geometry.drawRange;
    const coarse = details.find((detail) => detail.count <= 3 * triangles) ?? details.at(-1)!;
    if (coarse.count < count) geometry.setDrawRange(coarse.start, coarse.count);
    draw();
    geometry.setDrawRange(start, count);
  }

  dispose(): void {
    for (const { geometry } of this.drawn.splice(0)) geometry.dispose();
    this.buffer = undefined;
  }

  private allocate(points: number, float: boolean): void {
    this.dispose();
    const numbers = NUMBERS_PER_POINT * points;
    const buffer = new InterleavedBuffer(float ? new Float32Array(numbers) : new Uint16Array(numbers), NUMBERS_PER_POINT);
    buffer.setUsage(DynamicDrawUsage);
    buffer.onUpload(() => {
      this.dirty.clear();
      buffer.clearUpdateRanges();  // three keeps them after the first upload, which sends everything
    });
    this.buffer = buffer;
    this.dirty.clear();
    this.isFloat = float;
    ++this.made;
  }

  private drawnOf(layout: TopologyLayout): Drawn {
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new InterleavedBufferAttribute(this.buffer!, 3, 0));
    geometry.setAttribute(this.isFloat ? 'pointNormal' : 'octahedral',
      new InterleavedBufferAttribute(this.buffer!, this.isFloat ? 3 : 2, this.isFloat ? 3 : 4));
    const { indices, details } = trianglesOf(layout);
    geometry.setIndex(new BufferAttribute(indices, 1));
    ++this.made;
    return { layout, geometry, details };
  }
}

/** Frees a geometry's triangles on the GPU and nothing else. */
function release(geometry: BufferGeometry): void {
  for (const name of Object.keys(geometry.attributes)) geometry.deleteAttribute(name);
  geometry.dispose();
}
