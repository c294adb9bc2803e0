// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { DecodedChunk } from '../decode/chunk_form';
import type { EvaluatedPoints } from './evaluated_points';
import type { ChunkPatterns } from './patches/patch_places';
import type { TopologyLayout } from './topology_layout';

/** The meaning of a chunk's integers (event.proto, Quantisation): position = origin + integer * step. */
export interface Grid {
  /** World units, in double. */
  readonly origin: readonly [number, number, number];
  /** World units per integer; 1 for floats, which are relative to `origin` too. */
  readonly step: number;
  /** The largest integer times the step, in world units; 0 for floats. */
  readonly range: number;
  /** Bits per coordinate of positions; 0 for floats. */
  readonly positionBits: number;
  /** Bits per coordinate of the octahedral normals. */
  readonly normalBits: number;
}

/** All new chunks of one update, decoded. */
export interface SurfaceUpdate {
  readonly layout: TopologyLayout;
  readonly grid: Grid;
  /** Whether chunks hold normals. */
  readonly normals: boolean;
  readonly chunks: readonly (ChunkPatterns & { readonly decoded: DecodedChunk })[];
}

/** Points that are evaluated here have changed. */
export interface Evaluation {
  readonly points: EvaluatedPoints;
  readonly grid: Grid;
  readonly normals: boolean;
  /** min x y z, max x y z of chunks that have changed, relative to the grid's origin. */
  readonly extents: ReadonlyMap<number, Float32Array>;
}
