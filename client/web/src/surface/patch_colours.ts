// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { Color, type DataTexture } from 'three';
import type { PatchOrigins, PatchSource, RestCorners } from './patch_source';
import { patchTexture } from './patch_texture';
import type { TopologyLayout } from './topology_layout';

/**
 * What is known of every patch besides its points: corners at rest, the colour of its knot box, texture coordinates.
 * Fetched when first wanted; until then, and where fetching fails, it is absent and the surface is drawn without it.
 */
export class PatchColours {
  restCorners: DataTexture | undefined;
  boxColours: DataTexture | undefined;
  uvs: DataTexture | undefined;
  restOrigin: readonly [number, number, number] | undefined;
  private layout: TopologyLayout | undefined;
  private corners: Float32Array | undefined;
  private asked = { rest: false, uvs: false };
  private generation = 0;  // answers of an earlier one are of no use

  /** @param changed Told when something has come. */
  constructor(private readonly source: PatchSource, private readonly changed: () => void) {}

  /** The layout of what is drawn; says whether its patches are others, which they are where their number is. */
  setLayout(layout: TopologyLayout): boolean {
    const areOthers = this.layout?.patchCount !== layout.patchCount;
    if (this.layout && areOthers) this.forget();
    this.layout = layout;
    return areOthers;
  }

  /** u v layer per corner of the mesh. */
  setUvs(corners: Float32Array | undefined): void {
    this.corners = corners;
    this.uvs?.dispose();
    this.uvs = undefined;
    this.asked.uvs = false;
  }

  /** The lattice has other knots: nothing is asked for until a layout of theirs comes. */
  structureChanged(): void {
    this.forget();
    this.layout = undefined;
  }

  forget(): void {
    ++this.generation;
    for (const texture of [this.restCorners, this.boxColours, this.uvs]) texture?.dispose();
    this.restCorners = this.boxColours = this.uvs = this.restOrigin = undefined;
    this.asked = { rest: false, uvs: false };
  }

  wantRest(): void {
    if (this.asked.rest || !this.layout) return;
    this.asked.rest = true;
    void this.fetch(() => this.source.restCorners(), (rest) => this.takeRest(rest));
  }

  wantUvs(): void {
    if (this.asked.uvs || !this.corners || !this.layout) return;
    this.asked.uvs = true;
    const { id } = this.layout;
    void this.fetch(() => this.source.origins(id), (origins) => this.takeOrigins(origins));
  }

  private async fetch<T>(ask: () => Promise<T>, take: (answer: T) => void): Promise<void> {
    const { generation } = this;
    try {
      const answer = await ask();
      if (generation !== this.generation) return;
      take(answer);
      this.changed();
    } catch (error) {
      console.warn('latticed: the surface is drawn without what is known of its patches:', error);
    }
  }

  private takeRest({ origin, corners }: RestCorners): void {
    const patches = corners.length / 9;
    if (patches !== this.layout?.patchCount) throw new Error(`${patches} patches at rest, ${this.layout?.patchCount} deformed`);
    this.restOrigin = origin;
    this.restCorners = patchTexture(patches, 3, (patch, out, at) => {
      for (let corner = 0; corner < 3; ++corner) {
        out.set(corners.subarray(9 * patch + 3 * corner, 9 * patch + 3 * corner + 3), at + 4 * corner);
      }
    });
    const colour = new Color();
    this.boxColours = patchTexture(patches, 1, (patch, out, at) => {
      const middle = [0, 1, 2].map((axis) => origin[axis]! +
        (corners[9 * patch + axis]! + corners[9 * patch + 3 + axis]! + corners[9 * patch + 6 + axis]!) / 3);
      colourOfBox(this.source.boxOf(middle[0]!, middle[1]!, middle[2]!), colour).toArray(out, at);
    });
  }

  /** Two texels per patch: u v of two corners; u v of the third, the layer. */
  private takeOrigins({ corners, barycentrics }: PatchOrigins): void {
    const uvs = this.corners!;
    this.uvs = patchTexture(corners.length / 3, 2, (patch, out, at) => {
      for (let corner = 0; corner < 3; ++corner) {
        for (let axis = 0; axis < 2; ++axis) {
          let value = 0;
          for (let k = 0; k < 3; ++k) {
            value += barycentrics[9 * patch + 3 * corner + k]! * (uvs[3 * corners[3 * patch + k]! + axis] ?? 0);
          }
          out[at + 2 * corner + axis] = value;
        }
      }
      out[at + 6] = uvs[3 * corners[3 * patch]! + 2] ?? 0;
    });
  }
}

/** Hues a golden angle apart, so that neighbouring numbers differ; grey outside the frame. */
function colourOfBox(box: number, colour: Color): Color {
  return box < 0 ? colour.setRGB(0.45, 0.45, 0.45) : colour.setHSL((box * 0.618034) % 1, 0.45, 0.6);
}
