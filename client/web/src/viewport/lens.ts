// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { ViewCamera } from './camera_rig';

/** How large a camera draws lengths. */
export interface Lens {
  /** Pixels of a length across the line of sight, in the middle: perspective at depth 1; orthographic everywhere. */
  readonly focal: number;
  /** 1 / cos^2 of the angle to the picture's corner: away from the middle a perspective picture is stretched. 1: orthographic. */
  readonly stretch: number;
  readonly isPerspective: boolean;
}

/** @param height Of the picture, in pixels. */
export function lensOf({ projectionMatrix: { elements } }: ViewCamera, height: number): Lens {
  const isPerspective = elements[11] !== 0;
  const stretch = isPerspective ? 1 + 1 / elements[0]! ** 2 + 1 / elements[5]! ** 2 : 1;
  return { focal: (elements[5]! * height) / 2, stretch, isPerspective };
}
