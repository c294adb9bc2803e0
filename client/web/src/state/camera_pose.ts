// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Vec3 } from '../lattice/vec';

/** A camera as others may follow it, in world units: event.proto, Camera. */
export interface CameraPose {
  readonly position: Vec3;
  /** The point in the middle of the picture, about which the view turns. */
  readonly target: Vec3;
  /** The direction that points up in the picture. */
  readonly up: Vec3;
  /** Perspective with a vertical angle in degrees, or orthographic with the picture's height. */
  readonly projection: { readonly fovY: number } | { readonly height: number };
}
