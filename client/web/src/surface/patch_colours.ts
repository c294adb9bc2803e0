// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { Color, type DataTexture } from 'three';
import { patchTexture } from './patch_texture';
import type { TopologyLayout } from './topology_layout';

/** Facts about patches besides their points: the shape at rest, and texture coordinates. */
export type PatchFacts = 'rest' | 'uvs';

/** The places of patches in the source mesh (surface.proto, TopologyPart). */
export interface PatchOrigins {
  /** Three per patch: corners of the source triangle. */
  readonly corners: Uint32Array;
  /** Nine per patch: for its corners 0, 1, 2 the barycentrics in that triangle. */
  readonly barycentrics: Float64Array;
}

/** Corners of all patches before any deformation, as x y z each, relative to `origin` (world units). */
export interface RestCorners {
  readonly origin: readonly [number, number, number];
  /** Nine per patch. */
  readonly corners: Float32Array;
}

/** Data that the surface fetches only when a look needs it. */
export interface PatchSource {
  origins(topologyId: string): Promise<PatchOrigins>;
  restCorners(): Promise<RestCorners>;
  /** Number of the knot box of a world point at rest, or -1 outside the frame. */
  boxOf(x: number, y: number, z: number): number;
}

/**
 * Facts of every patch besides its points: corners at rest, the colour of its knot box, texture coordinates. They are
 * fetched when a look first needs them. Until then, and after a failure, the surface is drawn without them. A failed fetch
 * is repeated when the look is chosen again, and when the server is back.
 */
export class PatchColours {
  restCorners: DataTexture | undefined;
  boxColours: DataTexture | undefined;
  uvs: DataTexture | undefined;
  restOrigin: readonly [number, number, number] | undefined;
  private layout: TopologyLayout | undefined;
  private corners: Float32Array | undefined;
  private readonly asks = new Map<PatchFacts, symbol>();  // the newest of each kind; earlier answers are dropped
  private readonly told = new Map<PatchFacts, string>();  // why each failed last, until it arrives

  /**
   * @param changed Called when facts have arrived.
   * @param failed Called when facts cannot be fetched, once for each cause until the look is chosen again.
   */
  constructor(
    private readonly source: PatchSource,
    private readonly changed: () => void,
    private readonly failed: (what: PatchFacts, error: unknown) => void,
  ) {}

  /** Sets the layout that is drawn. Returns whether the patches have changed, which is so if their number has. */
  setLayout(layout: TopologyLayout): boolean {
    const areOthers = this.layout?.patchCount !== layout.patchCount;
    if (this.layout && areOthers) this.forget();
    this.layout = layout;
    return areOthers;
  }

  /** u v layer per corner of the mesh. */
  setUvs(corners: Float32Array | undefined): void {
    const isSame = corners?.length === this.corners?.length && corners?.every((value, i) => value === this.corners![i]);
    this.corners = corners;
    if (isSame) return;  // other pictures in the same places: the coordinates stay, so no frame is drawn without them
    this.uvs?.dispose();
    this.uvs = undefined;
    this.asks.delete('uvs');
  }

  /** The lattice has other knots. Nothing is fetched until the layout for them arrives. */
  structureChanged(): void {
    this.forget();
    this.layout = undefined;
  }

  forget(): void {
    for (const texture of [this.restCorners, this.boxColours, this.uvs]) texture?.dispose();
    this.restCorners = this.boxColours = this.uvs = this.restOrigin = undefined;
    this.asks.clear();
  }

  /** The look has changed: failed fetches may be repeated, and reported again. */
  chosenAnew(): void {
    for (const what of this.told.keys()) this.asks.delete(what);
    this.told.clear();
  }

  /** The server is back: missing facts may be fetched again, since answers may be lost. */
  reconnected(): void {
    if (!this.restCorners) this.asks.delete('rest');
    if (!this.uvs) this.asks.delete('uvs');
  }

  wantRest(): void {
    if (this.asks.has('rest') || !this.layout) return;
    void this.ask('rest', () => this.source.restCorners(), (rest) => this.takeRest(rest));
  }

  wantUvs(): void {
    if (this.asks.has('uvs') || !this.corners || !this.layout) return;
    const { id } = this.layout;
    void this.ask('uvs', () => this.source.origins(id), (origins) => this.takeOrigins(origins));
  }

  private async ask<T>(what: PatchFacts, fetch: () => Promise<T>, take: (answer: T) => void): Promise<void> {
    const mine = Symbol(what);
    this.asks.set(what, mine);
    try {
      const answer = await fetch();
      if (this.asks.get(what) !== mine) return;
      take(answer);
      this.told.delete(what);
      this.changed();
    } catch (error) {
      if (this.asks.get(what) === mine) this.tell(what, error);
    }
  }

  private tell(what: PatchFacts, error: unknown): void {
    const cause = String(error);
    if (this.told.get(what) === cause) return;
    this.told.set(what, cause);
    this.failed(what, error);
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

  /** Two texels per patch: u v of two corners, then u v of the third corner and the layer. */
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
