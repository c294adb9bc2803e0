// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Colours and sizes of control points and of the lines between them, by state, on light and on dark.
import { Color } from 'three';

export type PointState = 'plain' | 'held' | 'selected' | 'active' | 'hover';

export interface CageStyle {
  /** The colour of discs, and of the ends of lines, per state. */
  readonly colours: Record<PointState, Color>;
  /** The rim of discs, which contrasts with the surface. */
  readonly rim: Color;
  readonly knotBoxes: Color;
}

/** Diameters in CSS pixels. */
export const DIAMETERS: Record<PointState, number> = { plain: 8, held: 8, selected: 11, active: 13, hover: 12 };

export const DARK_CAGE: CageStyle = {
  colours: {
    plain: new Color(0xffffff),
    held: new Color(0x6f7b8c),
    selected: new Color(0xff9f2e),
    active: new Color(0xffe2b0),
    hover: new Color(0x7fd0ff),
  },
  rim: new Color(0x10141b),
  knotBoxes: new Color(0x3fb8a8),
};

export const LIGHT_CAGE: CageStyle = {
  colours: {
    plain: new Color(0x0a0e14),
    held: new Color(0x97a1ad),
    selected: new Color(0xe06c00),
    active: new Color(0x8a3b00),
    hover: new Color(0x0077c8),
  },
  rim: new Color(0xffffff),
  knotBoxes: new Color(0x0b8474),
};
