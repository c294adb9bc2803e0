// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { DecodedChunk } from '../decode/chunk_form';
import type { TopologyLayout } from './topology_layout';

/** What the integers of chunks mean (event.proto, Quantisation): position = origin + integer * step. */
export interface Grid {
  /** World units, in double. */
  readonly origin: readonly [number, number, number];
  /** World units per integer; 1 for floats, which are relative to `origin` too. */
  readonly step: number;
  /** Bits per coordinate of the octahedral map. */
  readonly normalBits: number;
}

/** All new chunks of one update, decoded. */
export interface SurfaceUpdate {
  readonly layout: TopologyLayout;
  readonly grid: Grid;
  /** Whether chunks hold normals. */
  readonly normals: boolean;
  readonly chunks: readonly { readonly index: number; readonly decoded: DecodedChunk }[];
}
