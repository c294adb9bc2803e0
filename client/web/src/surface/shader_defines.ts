// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { ShaderMaterial } from 'three';
import type { Light } from '../light/shading';
import type { SurfaceLook } from './surface_look';

export type Defines = Record<string, string>;

/** What is drawn, as far as the shaders of surface_shader.ts are compiled for it. */
export interface Drawn {
  readonly look: SurfaceLook;
  readonly light: Light;
  /** As in the look, once the shape of moved vertices is known. */
  readonly compare: SurfaceLook['compare'];
  readonly hasFloats: boolean;
  readonly hasNormals: boolean;
  /** The colourings whose data is known. */
  readonly known: Record<Exclude<NonNullable<SurfaceLook['colouring']>, 'plain'>, boolean>;
}

const COLOURINGS: Record<keyof Drawn['known'], string> = {
  boxes: 'BOXES', displacement: 'DISPLACEMENT', difference: 'DIFFERENCE', texture: 'TEXTURED', weights: 'WEIGHTS',
};

/** The defines of the surface, of its normals alone, of the sides of triangles, of the ghost, and of the shape of moved vertices. */
export function definesOf(
  { look, light, compare, hasFloats, hasNormals, known }: Drawn,
): Record<'surface' | 'normals' | 'sides' | 'ghost' | 'flat', Defines> {
  const { colouring = 'plain' } = look;
  const points: Defines = hasFloats ? { FLOAT_POINTS: '' } : {};
  const form: Defines = { ...points, ...(compare === 'split' && { SPLIT: '' }) };
  const ownColour = light !== 'studio' && { OWN_COLOUR: '' };
  const normals = hasNormals && { HAS_NORMALS: '' };
  const colours: Defines = {
    ...form,
    ...ownColour,
    ...(colouring !== 'plain' && known[colouring] && { [COLOURINGS[colouring]]: '' }),
    ...((look.wireframe || look.patchEdges) && { LINES: '' }),
  };
  return {
    surface: { ...colours, ...normals },
    // Not split: it is drawn with other pixels than the divider's, and hollows beside the divider need both sides.
    normals: { ...points, ...normals, NORMALS: '' },
    sides: { ...form, SIDES: '' },
    ghost: { ...points, ...ownColour, GHOST: '' },
    flat: compare === 'split' ? { ...colours, FLAT: '' } : { ...form, FLAT: '' },
  };
}

/** Compiles the shaders again only if the defines differ. */
export function redefine(material: ShaderMaterial, defines: Defines): void {
  const { keys } = Object;
  if (keys(defines).sort().join() === keys(material.defines ?? {}).sort().join()) return;
  material.defines = defines;
  material.needsUpdate = true;
}
