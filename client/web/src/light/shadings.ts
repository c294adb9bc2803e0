// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { DataTexture } from 'three';
import { shadingTexture, type Light } from './shading';

/** The shading of each light, computed when it is first used. */
export class Shadings {
  private readonly made = new Map<Light, DataTexture>();

  of(light: Light): DataTexture {
    let texture = this.made.get(light);
    if (texture === undefined) this.made.set(light, (texture = shadingTexture(light)));
    return texture;
  }

  dispose(): void {
    for (const texture of this.made.values()) texture.dispose();
    this.made.clear();
  }
}
