// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import {
  BufferAttribute, BufferGeometry, DynamicDrawUsage, IntType, InterleavedBuffer, InterleavedBufferAttribute,
} from 'three';
import { NUMBERS_PER_POINT, type PointNumbers } from '../decode/chunk_form';
import { drawCoarsely, setDetail } from './drawn_detail';
import { PatchPlaces, type ChunkPatterns, type PlacesChange } from './patches/patch_places';
import { UnsentRanges } from './patches/unsent_ranges';
import type { TopologyLayout } from './topology_layout';

interface Drawn {
  readonly places: PatchPlaces;
  readonly geometry: BufferGeometry;
  readonly unsentPlaces: UnsentRanges;
  readonly unsentIndices: UnsentRanges;
}

/** The vertices on the CPU, and what of them the GPU lacks. */
interface Vertices {
  readonly buffer: InterleavedBuffer;
  readonly unsent: UnsentRanges;
}

/**
 * One vertex buffer for all chunks. It is written in place, and only written ranges go to the GPU. PatchPlaces says where the
 * points of each patch are.
 *
 *   integers   uint16 x y z 0 s t      12 bytes a point
 *   floats     float32 x y z nx ny nz  24 bytes a point, for RAW
 *
 * The buffer is allocated again only for more points or for the other type. The triangles of a topology without a tolerance
 * are made once. Those of the last 3 layouts are kept, since the level of detail often switches between them.
 */
export class PointBuffer {
  private static readonly LAYOUTS_KEPT = 3;

  private vertices: Vertices | undefined;
  private isFloat = false;
  private detail = 0;
  private readonly drawn: Drawn[] = [];  // the newest first

  /** Buffers and geometries made so far; tests count them. */
  made = 0;

  get float(): boolean {
    return this.isFloat;
  }

  /** Where the points are. */
  get places(): PatchPlaces {
    return this.drawn[0]!.places;
  }

  /** Makes room for the points of these chunks, and returns the geometry that draws this layout. */
  prepare(layout: TopologyLayout, float: boolean, chunks: Iterable<ChunkPatterns> = []): BufferGeometry {
    const at = this.drawn.findIndex(({ places }) => places.layout.id === layout.id);
    const known = at >= 0 ? this.drawn[at]! : undefined;
    const places = known?.places ?? new PatchPlaces(layout);
    const change = places.take(chunks);
    const before = this.vertices;
    const hasRoom = before !== undefined && float === this.isFloat && before.buffer.count >= places.room;
    if (!hasRoom) this.allocate(places.room, float);
    if (before) this.move(change, before.buffer.array as PointNumbers);
    if (hasRoom && known) this.drawn.splice(at, 1);
    const isKept = hasRoom && known !== undefined && !change.isReplaced;
    if (isKept) tell(known, change);
    else if (hasRoom && known) release(known.geometry);
    this.drawn.unshift(isKept ? known : this.drawnOf(places));
    if (this.drawn.length > PointBuffer.LAYOUTS_KEPT) release(this.drawn.pop()!.geometry);
    this.setDetail(this.detail);
    return this.drawn[0]!.geometry;
  }

  /** Triangles of each detail of the layout that is drawn, the finest first. */
  get triangles(): readonly number[] {
    return this.places.triangleCounts;
  }

  /** Draws a detail by its number, or the coarsest if there are fewer. */
  setDetail(detail: number): void {
    this.detail = detail;
    const newest = this.drawn[0];
    if (newest) setDetail(newest.geometry, newest.places, detail);
  }

  /** Writes the points of a chunk; they reach the GPU with the next frame. */
  write(chunk: number, points: PointNumbers): void {
    const { vertices } = this;
    if (!vertices) throw new Error('write before prepare');
    const start = NUMBERS_PER_POINT * this.places.firstPointOf(chunk);
    (vertices.buffer.array as PointNumbers).set(points, start);
    vertices.unsent.add(start, points.length);
  }

  /** The numbers of all points. */
  get numbers(): ArrayLike<number> {
    return this.vertices?.buffer.array ?? [];
  }

  /** The numbers of one point. */
  pointAt(point: number): PointNumbers {
    return (this.vertices!.buffer.array as PointNumbers).subarray(NUMBERS_PER_POINT * point, NUMBERS_PER_POINT * (point + 1));
  }

  /**
   * Draws with at most this number of triangles, and then as before. Where only a much coarser detail has so few, as with
   * adaptive patterns of few patches, the next finer one is drawn.
   */
  drawCoarse(triangles: number, draw: () => void): void {
    const { geometry, places } = this.drawn[0]!;
    drawCoarsely(geometry, places, triangles, draw);
  }

  dispose(): void {
    for (const { geometry } of this.drawn.splice(0)) geometry.dispose();
    this.vertices = undefined;
  }

  private allocate(points: number, float: boolean): void {
    this.dispose();
    const numbers = NUMBERS_PER_POINT * points;
    const buffer = new InterleavedBuffer(float ? new Float32Array(numbers) : new Uint16Array(numbers), NUMBERS_PER_POINT);
    buffer.setUsage(DynamicDrawUsage);
    this.vertices = { buffer, unsent: new UnsentRanges(buffer) };
    this.isFloat = float;
    ++this.made;
  }

  /** Moves the points that lie elsewhere now. They were in `from`, which may be the buffer's own array. */
  private move({ moves }: PlacesChange, from: PointNumbers): void {
    const { buffer, unsent } = this.vertices!;
    const to = buffer.array as PointNumbers;
    if (moves.length === 0 || to.BYTES_PER_ELEMENT !== from.BYTES_PER_ELEMENT) return;
    const old = from === to ? from.slice() : from;
    for (const move of moves) {
      to.set(old.subarray(NUMBERS_PER_POINT * move.from, NUMBERS_PER_POINT * (move.from + move.count)), NUMBERS_PER_POINT * move.to);
    }
    unsent.addAll();
  }

  private drawnOf(places: PatchPlaces): Drawn {
    const geometry = new BufferGeometry();
    const { buffer } = this.vertices!;
    geometry.setAttribute('position', new InterleavedBufferAttribute(buffer, 3, 0));
    geometry.setAttribute(this.isFloat ? 'pointNormal' : 'octahedral',
      new InterleavedBufferAttribute(buffer, this.isFloat ? 3 : 2, this.isFloat ? 3 : 4));
    const patchPlaces = new BufferAttribute(places.places, 2);
    patchPlaces.gpuType = IntType;
    geometry.setAttribute('patchPlace', patchPlaces);
    const indices = new BufferAttribute(places.indices, 1);
    geometry.setIndex(indices);
    if (places.layout.isAdaptive) for (const written of [patchPlaces, indices]) written.setUsage(DynamicDrawUsage);
    ++this.made;
    return { places, geometry, unsentPlaces: new UnsentRanges(patchPlaces), unsentIndices: new UnsentRanges(indices) };
  }
}

/** Sends the parts of the arrays that have changed. */
function tell({ places, unsentPlaces, unsentIndices }: Drawn, { isWhole, chunks }: PlacesChange): void {
  if (isWhole) {
    unsentPlaces.addAll();
    unsentIndices.addAll();
    return;
  }
  for (const chunk of chunks) {
    const { points, indices } = places.slotsOf(chunk);
    unsentPlaces.add(2 * points.start, 2 * points.count);
    for (const { start, count } of indices) unsentIndices.add(start, count);
  }
}

/** Frees on the GPU what a geometry has of its own: all but the vertex buffer, which dispose() would delete. */
function release(geometry: BufferGeometry): void {
  for (const name of Object.keys(geometry.attributes)) if (name !== 'patchPlace') geometry.deleteAttribute(name);
  geometry.dispose();
}
