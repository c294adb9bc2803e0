// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { PatternCodes, TopologyLayout } from '../topology_layout';
import { pointsIn, type PatchPattern } from './patch_pattern';
import { Slots } from './slots';

/** The indices of a detail: of triangles over all points, or over fewer of them. */
export interface Detail {
  readonly start: number;
  readonly count: number;
}

/** New patterns of a chunk. */
export interface ChunkPatterns {
  readonly index: number;
  readonly codes: PatternCodes;
}

/** What PatchPlaces.take has changed. */
export interface PlacesChange {
  /** Whether `places` or `indices` are new arrays. */
  readonly isReplaced: boolean;
  /** Whether all of both is written anew; else only the parts of `chunks` are. */
  readonly isWhole: boolean;
  /** The chunks with other patterns than before. */
  readonly chunks: readonly number[];
  /** Points that keep their patterns but lie elsewhere now: `count` from `from` are at `to`. */
  readonly moves: readonly { readonly from: number; readonly to: number; readonly count: number }[];
}

/** evaluate_patch.vert has it too. */
const NO_POINT = 0xffff_ffff;

/**
 * Where the points of each patch are in the vertex buffer, and which triangles they make, whoever computes the points.
 *
 *   vertex buffer   a slot for each chunk, in turn; in it the points of its patches, patch after patch, then room
 *   places          uint32 patch, uint32 i_1 | i_2 << 16, for each point of the vertex buffer: its barycentrics in the
 *                   patch's corners 1 and 2, times layout.whole. In room both are NO_POINT
 *   indices         a part for each detail; in it a slot for each chunk, whose room repeats one index
 *
 * Patterns change with updates, and most often as few points as before are needed. Where a chunk outgrows its slot, all slots
 * are made anew, with room for a quarter more. Without a tolerance nothing changes, and there is no room.
 */
export class PatchPlaces {
  /** Rises with every change. */
  version = 0;
  places = new Uint32Array();
  indices = new Uint32Array();
  private readonly codes: PatternCodes;
  private readonly hasCome: Uint8Array; // whether a chunk's patterns are known
  private points: Slots;
  private parts: readonly Slots[]; // of each detail

  constructor(readonly layout: TopologyLayout) {
    const { chunkCount, patchCount, isAdaptive } = layout;
    this.codes = new Uint16Array(patchCount);
    this.hasCome = new Uint8Array(chunkCount).fill(isAdaptive ? 0 : 1);
    this.points = new Slots(0, new Uint32Array(chunkCount), 0);
    this.parts = layout.patternOf(0).details.map(() => this.points);
    if (!isAdaptive) this.layOut();
  }

  /** Points that the vertex buffer must hold. */
  get room(): number {
    return this.points.end;
  }

  /** Points of all patches. */
  get pointCount(): number {
    return this.points.used;
  }

  /** Triangles of each detail, the finest first. */
  get triangleCounts(): readonly number[] {
    return this.parts.map(({ used }) => used / 3);
  }

  /** The finest first. */
  get details(): readonly Detail[] {
    return this.parts.map(({ begin, end }) => ({ start: begin, count: end - begin }));
  }

  /** The first place of a chunk's points. */
  firstPointOf(chunk: number): number {
    return this.points.firstOf(chunk);
  }

  /** The parts of the arrays that hold a chunk: its points, and its indices at each detail, room included. */
  slotsOf(chunk: number): { readonly points: Detail; readonly indices: readonly Detail[] } {
    const slot = (slots: Slots): Detail => ({ start: slots.firstOf(chunk), count: slots.roomOf(chunk) });
    return { points: slot(this.points), indices: this.parts.map(slot) };
  }

  /** Calls `visit` for every `stride`-th patch with its pattern and the place of its first point. */
  eachPatch(stride: number, visit: (patch: number, pattern: PatchPattern, firstPoint: number) => void): void {
    const { layout, codes } = this;
    for (let chunk = 0; chunk < layout.chunkCount; ++chunk) {
      if (!this.hasCome[chunk]) continue;
      let at = this.points.firstOf(chunk);
      for (let patch = layout.firstPatch[chunk]!; patch < layout.firstPatch[chunk + 1]!; ++patch) {
        const pattern = layout.patternOf(codes[patch]!);
        if (patch % stride === 0) visit(patch, pattern, at);
        at += pointsIn(pattern);
      }
    }
  }

  /** Gives chunks new patterns; each may come once. Without a tolerance nothing changes. */
  take(news: Iterable<ChunkPatterns>): PlacesChange {
    const chunks: number[] = [];
    if (this.layout.isAdaptive) {
      for (const { index, codes } of news) if (this.takeCodes(index, codes)) chunks.push(index);
    }
    if (chunks.length > 0) ++this.version;
    const fits = chunks.every((chunk) => this.resize(chunk));
    if (!fits) return this.layOutAgain(chunks);
    for (const chunk of chunks) this.writeChunk(chunk);
    return { isReplaced: false, isWhole: false, chunks, moves: [] };
  }

  /** Returns whether they differ from those before. */
  private takeCodes(chunk: number, codes: PatternCodes): boolean {
    const own = this.codes.subarray(this.layout.firstPatch[chunk], this.layout.firstPatch[chunk + 1]);
    if (this.hasCome[chunk] && own.every((code, i) => code === codes[i])) return false;
    own.set(codes);
    this.hasCome[chunk] = 1;
    return true;
  }

  /** Gives a chunk as much of its slots as its patterns need. Returns whether they suffice. */
  private resize(chunk: number): boolean {
    const { points, indices } = this.needs(chunk);
    const fits = points <= this.points.roomOf(chunk) && this.parts.every((part, i) => indices[i]! <= part.roomOf(chunk));
    if (!fits) return false;
    this.points.use(chunk, points);
    this.parts.forEach((part, i) => part.use(chunk, indices[i]!));
    return true;
  }

  private needs(chunk: number): { points: number; indices: number[] } {
    const indices = this.parts.map(() => 0);
    let points = 0;
    if (!this.hasCome[chunk]) return { points, indices };
    for (let patch = this.layout.firstPatch[chunk]!; patch < this.layout.firstPatch[chunk + 1]!; ++patch) {
      const pattern = this.layout.patternOf(this.codes[patch]!);
      points += pointsIn(pattern);
      for (let i = 0; i < indices.length; ++i) indices[i]! += pattern.details[i]!.length;
    }
    return { points, indices };
  }

  private layOutAgain(changed: readonly number[]): PlacesChange {
    const { points: before, places, indices } = this;
    const had = this.hasCome.slice();
    for (const chunk of changed) had[chunk] = 0; // their points come anew
    this.layOut();
    const moves = Array.from(had.keys()).filter((chunk) => had[chunk]).map((chunk) => ({
      from: before.firstOf(chunk), to: this.points.firstOf(chunk), count: this.points.usedOf(chunk) }));
    const isReplaced = places !== this.places || indices !== this.indices;
    return { isReplaced, isWhole: true, chunks: changed, moves };
  }

  /** Makes all slots anew for the patterns as they are. The arrays stay if they are large enough. */
  private layOut(): void {
    const { chunkCount, isAdaptive } = this.layout;
    const share = isAdaptive ? 1 / 4 : 0;
    const needs = Array.from({ length: chunkCount }, (_, chunk) => this.needs(chunk));
    this.points = new Slots(0, Uint32Array.from(needs, ({ points }) => points), share);
    let begin = 0;
    this.parts = this.parts.map((_, i) => {
      const part = new Slots(begin, Uint32Array.from(needs, ({ indices }) => indices[i]!), share, 3);
      begin = part.end;
      return part;
    });
    if (this.places.length < 2 * this.points.end) this.places = new Uint32Array(2 * this.points.end);
    if (this.indices.length < begin) this.indices = new Uint32Array(begin);
    for (let chunk = 0; chunk < chunkCount; ++chunk) this.writeChunk(chunk);
  }

  private writeChunk(chunk: number): void {
    const { layout, codes, places, indices, parts } = this;
    const firstPoint = this.points.firstOf(chunk);
    const ends = parts.map((part) => part.firstOf(chunk));
    let point = firstPoint;
    for (let patch = layout.firstPatch[chunk]!; this.hasCome[chunk] && patch < layout.firstPatch[chunk + 1]!; ++patch) {
      const pattern = layout.patternOf(codes[patch]!);
      for (let i = 0; i < parts.length; ++i) {
        const triangles = pattern.details[i]!;
        let at = ends[i]!;
        for (let k = 0; k < triangles.length; ++k) indices[at++] = point + triangles[k]!;
        ends[i] = at;
      }
      for (let k = 0; k < pattern.points.length; ++k, ++point) {
        places[2 * point] = patch;
        places[2 * point + 1] = pattern.points[k]!;
      }
    }
    places.fill(NO_POINT, 2 * point, 2 * (firstPoint + this.points.roomOf(chunk)));
    parts.forEach((part, i) => indices.fill(firstPoint, ends[i], part.firstOf(chunk) + part.roomOf(chunk)));
  }
}
