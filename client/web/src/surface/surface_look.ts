// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Light } from '../light/shading';

/** How the surface is drawn. */
export interface SurfaceLook {
  /** boxes: a colour per knot box; displacement, difference: heat maps of the distance from the rest shape, and from the shape
   * if only vertices moved; weights: of the vertices, from blue, 0, to red, 1. */
  readonly colouring?: 'plain' | 'boxes' | 'displacement' | 'difference' | 'texture' | 'weights';
  /** The shape if only vertices moved: left of the divider in place of the surface, or over it. */
  readonly compare?: 'off' | 'split' | 'over';
  readonly wireframe?: boolean;
  readonly patchEdges?: boolean;
  /** The rest shape as a ghost. */
  readonly ghost?: boolean;
  readonly colour?: number;
  /** The luminance, 0 to 1, below which shade is hardly darker, and above which light is compressed. */
  readonly tones?: readonly [number, number];
  /** The light on the plain colouring, or a material of its own colour; other colourings are lit by the studio. */
  readonly light?: Light;
}
