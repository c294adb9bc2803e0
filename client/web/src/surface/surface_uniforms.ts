// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The uniforms of surface_shader.ts, at first.
import { Color, Vector2, Vector3, type DataArrayTexture, type Texture } from 'three';

const noTexture = (): { value: Texture | null } => ({ value: null });

/** Those of the surface, which all its materials share unless they have others of their own. */
export function surfaceUniforms() {
  return {
    whole: { value: 1 }, octahedralMax: { value: 1 }, step: { value: 1 }, size: { value: 1 }, viewSize: { value: new Vector2() },
    toRest: { value: new Vector3() }, restCorners: noTexture(), flatCorners: noTexture(), displacementRange: { value: 1 },
    boxColours: noTexture(), patchUvs: noTexture(), patchWeights: noTexture(), map: { value: null as DataArrayTexture | null },
    baseColour: { value: new Color(0xb9bec6) }, opacity: { value: 1 }, tones: { value: new Vector2(0.11, 0.24) },
    shading: noTexture(), hollows: noTexture(),
    lineColour: { value: new Color(0x11151c) }, wireframe: { value: 0 }, patchEdges: { value: 0 }, divider: { value: 0 },
  };
}

/** Those of the shape of moved vertices, where it is drawn over the surface. */
export function overUniforms(shading: Texture) {
  return {
    baseColour: { value: new Color(0xff7a1a) }, opacity: { value: 0.5 }, shading: { value: shading },
    tones: { value: new Vector2(0, 10) }, // all: it must be told from the surface
  };
}
