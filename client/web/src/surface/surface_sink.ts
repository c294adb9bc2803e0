// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Surface } from './surface';
import type { SurfaceUpdate } from './surface_update';

/** What draws the surface and takes its data. */
export interface SurfaceSink extends Surface {
  apply(update: SurfaceUpdate): void;
  /** The knots have changed: patches are others. */
  structureChanged(): void;
  /** The server is there again: what a look asked for and has not come is asked for again. */
  reconnected(): void;
}
