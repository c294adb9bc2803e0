// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { ShaderMaterial } from 'three';

/** Compiles the shaders again only if the defines differ. */
export function redefine(material: ShaderMaterial, defines: Record<string, string>): void {
  const { keys } = Object;
  if (keys(defines).sort().join() === keys(material.defines ?? {}).sort().join()) return;
  material.defines = defines;
  material.needsUpdate = true;
}
