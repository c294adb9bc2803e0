// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The shading of a surface by its normal in the view, as a picture of a lit ball ("matcap"). The studio lights any colour;
// the other three are materials with a colour of their own. All are computed from an environment.
import { Color, DataTexture, DataUtils, HalfFloatType, LinearFilter, RGBAFormat, Vector3 } from 'three';
import { irradianceOf, radianceFrom, type Environment } from './environment';

export const LIGHTS = ['studio', 'clay', 'jade', 'steel'] as const;
export type Light = (typeof LIGHTS)[number];

const EYE = new Vector3(0, 0, 1);

/** A large lamp from the upper left, a weak one from the right, a strip behind each side. */
const STUDIO: Environment = {
  sky: 0.5,
  floor: 0.24,
  lamps: [
    { from: [-0.62, 0.62, 0.48], edge: 0.82, radiance: 3.6 },
    { from: [0.9, 0.1, 0.35], edge: 0.9, radiance: 0.25 },
    { from: [0.75, 0.35, -0.55], edge: 0.93, radiance: 2 },
  ],
};

/** Strips above and below, for a surface that mirrors. */
const HALL: Environment = {
  sky: 0.42,
  floor: 0.16,
  lamps: [
    { from: [-0.5, 0.7, 0.5], edge: 0.9, radiance: 0.75 },
    { from: [0.1, 0.15, 1], edge: 0.86, radiance: 0.2 },
    { from: [0.85, -0.1, 0.3], edge: 0.93, radiance: 0.3 },
    { from: [-0.75, -0.6, -0.2], edge: 0.9, radiance: 0.3 },
  ],
};

interface Material {
  readonly environment: Environment;
  /** The colour of the matt part, and how much of it is seen. */
  readonly colour: number;
  readonly matt: number;
  /** The colour that the matt part has where little light falls: light that comes through a translucent body. */
  readonly shade?: number;
  /** The part that is mirrored of light from the front (Schlick's F0), and its colour. */
  readonly mirrored: number;
  readonly mirrorColour: number;
  readonly blur: number;
}

const MATERIALS: Record<Light, Material> = {
  studio: { environment: STUDIO, colour: 0xffffff, matt: 1, mirrored: 0.035, mirrorColour: 0xffffff, blur: 0.35 },
  clay: { environment: STUDIO, colour: 0xb8735a, matt: 0.85, shade: 0x7a3a3c, mirrored: 0.004, mirrorColour: 0xffe8d8, blur: 1 },
  jade: { environment: STUDIO, colour: 0x5f9f80, matt: 0.68, shade: 0x1f7a6c, mirrored: 0.03, mirrorColour: 0xf0fff4, blur: 0.12 },
  steel: { environment: HALL, colour: 0x6c7886, matt: 0.15, mirrored: 0.6, mirrorColour: 0xcfd8e4, blur: 0.3 },
};

const SIZE = 128;
const RADIUS = 0.96; // of the ball, of half the picture; the rest repeats its rim
const DARKEST = 0.02; // harmonics of a small lamp may go below zero

/** A lit ball, linear: the red, green and blue by which a colour is multiplied, and in alpha the gloss that is added. */
export function shadingTexture(light: Light): DataTexture {
  const shadeAt = shader(MATERIALS[light], light === 'studio');
  const data = new Uint16Array(4 * SIZE * SIZE);
  const normal = new Vector3();
  for (let i = 0; i < SIZE * SIZE; ++i) {
    const [x, y] = [i % SIZE, Math.floor(i / SIZE)].map((at) => ((2 * at + 1) / SIZE - 1) / RADIUS);
    const out = Math.max(Math.hypot(x, y), 1);
    normal.set(x / out, y / out, 0);
    normal.z = Math.sqrt(Math.max(1 - normal.lengthSq(), 0));
    shadeAt(normal).forEach((value, k) => (data[4 * i + k] = DataUtils.toHalfFloat(value)));
  }
  const texture = new DataTexture(data, SIZE, SIZE, RGBAFormat, HalfFloatType);
  texture.magFilter = texture.minFilter = LinearFilter;
  texture.needsUpdate = true;
  return texture;
}

/** Red, green, blue and gloss of a material by the normal; `isGlossApart`: red, green and blue are without the gloss. */
function shader(material: Material, isGlossApart: boolean): (normal: Vector3) => number[] {
  const { environment, matt, mirrored, blur } = material;
  const irradiance = irradianceOf(environment);
  const own = new Color(material.colour);
  const shade = new Color(material.shade ?? material.colour);
  const mirror = new Color(material.mirrorColour);
  const [reflected, fallen] = [new Vector3(), new Vector3()];
  return (normal) => {
    const reflectance = Math.max(irradiance.getIrradianceAt(normal, fallen).x / Math.PI, DARKEST);
    const body = shade.clone().lerp(own, Math.min(reflectance, 1)).multiplyScalar(matt * reflectance);
    reflected.copy(normal).multiplyScalar(2 * normal.z).sub(EYE);
    const fresnel = mirrored * (1 + 6 * (1 - mirrored) * (1 - normal.z) ** 5);
    const gloss = fresnel * radianceFrom(environment, reflected, blur);
    if (isGlossApart) return [...body.toArray(), gloss];
    return [...body.add(mirror.clone().multiplyScalar(gloss)).toArray(), 0];
  };
}
