// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { BufferAttribute, BufferGeometry, DynamicDrawUsage, GLBufferAttribute } from 'three';
import { NUMBERS_PER_POINT } from '../decode/chunk_form';
import type { PointBuffers } from '../patches/gpu/point_buffers';
import { drawCoarsely, setDetail } from './drawn_detail';
import { PatchPlaces, type ChunkPatterns } from './patches/patch_places';
import { UnsentRanges } from './patches/unsent_ranges';
import type { TopologyLayout } from './topology_layout';

const [FLOAT, UNSIGNED_INT] = [0x1406, 0x1405];

/** A part of the vertex buffer. */
export interface PointRange {
  readonly first: number;
  readonly count: number;
}

/** The vertices that the GPU evaluates by itself. The CPU reads them only when it is asked for their numbers. */
export class EvaluatedPoints {
  readonly float = true;
  readonly places: PatchPlaces;
  private geometry: BufferGeometry | undefined;
  private unsent: UnsentRanges | undefined;
  private detail = 0;
  private read: Float32Array | undefined;

  constructor(layout: TopologyLayout, private readonly buffers: PointBuffers) {
    this.places = new PatchPlaces(layout);
  }

  /** Triangles of each detail, the finest first. */
  get triangles(): readonly number[] {
    return this.places.triangleCounts;
  }

  /** What draws the points, once there are some. */
  get drawn(): BufferGeometry | undefined {
    return this.geometry;
  }

  /** Gives chunks new patterns, and returns the chunks whose points must be evaluated; undefined: all. */
  take(chunks: Iterable<ChunkPatterns>): readonly number[] | undefined {
    const { places } = this;
    const change = places.take(chunks);
    if (change.isWhole) {
      this.buffers.reserve(places.room);
      this.buffers.writePlaces(places.places, 0, places.room);
    } else {
      for (const range of this.rangesOf(change.chunks)) this.buffers.writePlaces(places.places, range.first, range.count);
    }
    if (change.isReplaced || !this.geometry) {
      this.release();
      this.geometry = this.geometryOf();
    } else if (change.isWhole) {
      this.unsent!.addAll();
    } else {
      for (const chunk of change.chunks) for (const { start, count } of places.slotsOf(chunk).indices) this.unsent!.add(start, count);
    }
    this.setDetail(this.detail);
    if (change.isWhole || change.chunks.length > 0) this.evaluated();
    return change.isWhole ? undefined : change.chunks;
  }

  /** The places of chunks, those that follow each other as one; room included. */
  rangesOf(chunks: readonly number[]): PointRange[] {
    const ranges: { first: number; count: number }[] = [];
    for (const chunk of [...chunks].sort((a, b) => a - b)) {
      const { start, count } = this.places.slotsOf(chunk).points;
      const last = ranges.at(-1);
      if (last && last.first + last.count === start) last.count += count;
      else ranges.push({ first: start, count });
    }
    return ranges;
  }

  /** Points have been evaluated anew: numbers that were read are old. */
  evaluated(): void {
    this.read = undefined;
  }

  setDetail(detail: number): void {
    this.detail = detail;
    if (this.geometry) setDetail(this.geometry, this.places, detail);
  }

  /** x y z nx ny nz of all points. Waits for the GPU if they have changed. */
  get numbers(): Float32Array {
    return (this.read ??= this.readAll());
  }

  pointAt(point: number): Float32Array {
    return this.numbers.subarray(NUMBERS_PER_POINT * point, NUMBERS_PER_POINT * (point + 1));
  }

  drawCoarse(triangles: number, draw: () => void): void {
    drawCoarsely(this.geometry!, this.places, triangles, draw);
  }

  dispose(): void {
    this.release();
  }

  private readAll(): Float32Array {
    const count = this.places.room;
    const { positions, normals } = this.buffers.read(count);
    const numbers = new Float32Array(NUMBERS_PER_POINT * count);
    for (let point = 0; point < count; ++point) {
      for (let axis = 0; axis < 3; ++axis) {
        numbers[NUMBERS_PER_POINT * point + axis] = positions[3 * point + axis]!;
        numbers[NUMBERS_PER_POINT * point + 3 + axis] = normals[3 * point + axis]!;
      }
    }
    return numbers;
  }

  private geometryOf(): BufferGeometry {
    const { buffers, places } = this;
    const geometry = new BufferGeometry();
    const shared = [['position', buffers.positions, FLOAT, 3], ['pointNormal', buffers.normals, FLOAT, 3],
      ['patchPlace', buffers.places, UNSIGNED_INT, 2]] as const;
    // Three's types know only attributes of its own there.
    for (const [name, buffer, type, size] of shared) geometry.setAttribute(name, new GLBufferAttribute(buffer, type, size, 4, places.room) as never);
    const indices = new BufferAttribute(places.indices, 1);
    indices.setUsage(DynamicDrawUsage);
    geometry.setIndex(indices);
    this.unsent = new UnsentRanges(indices);
    return geometry;
  }

  /** Frees the indices alone: dispose() would delete the buffers, which are not three's. */
  private release(): void {
    const { geometry } = this;
    if (!geometry) return;
    for (const name of Object.keys(geometry.attributes)) geometry.deleteAttribute(name);
    geometry.dispose();
    this.geometry = undefined;
  }
}
