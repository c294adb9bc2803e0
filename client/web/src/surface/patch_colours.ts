// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { Color, type DataTexture } from 'three';
import type { FlatPatches } from './largest_distance';
import type { PatchFacts, PatchOrigins, PatchSource, RestCorners } from './patch_source';
import { PaintedVertices } from './painted_vertices';
import { patchTexture } from './patch_texture';
import type { TopologyLayout } from './topology_layout';
import { VerticesOnly } from './vertices_only';

/**
 * Facts of every patch besides its points: corners at rest and if only vertices moved, knot box, texture coordinates. They are
 * fetched when a look first needs them. Until then, and after a failure, the surface is drawn without them. A failed fetch
 * is repeated when the look is chosen again, and when the server is back.
 */
export class PatchColours {
  restCorners: DataTexture | undefined;
  flatCorners: DataTexture | undefined;
  boxColours: DataTexture | undefined;
  uvs: DataTexture | undefined;
  painted: PaintedVertices | undefined;
  rest: RestCorners | undefined;
  /** The shape if only vertices moved. */
  flat: FlatPatches | undefined;
  private verticesOnly: VerticesOnly | undefined;
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
    for (const texture of [this.restCorners, this.flatCorners, this.boxColours, this.uvs]) texture?.dispose();
    this.restCorners = this.flatCorners = this.boxColours = this.uvs = undefined;
    this.dropWeights();
    this.rest = this.flat = this.verticesOnly = undefined;
    this.asks.clear();
  }

  /** Weights are fetched again when they are wanted. */
  dropWeights(): void {
    this.painted?.texture.dispose();
    this.painted = undefined;
    this.asks.delete('weights');
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
    if (!this.flat) this.asks.delete('flat');
    if (!this.painted) this.asks.delete('weights');
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

  wantWeights(): void {
    if (this.asks.has('weights') || !this.layout) return;
    const { id } = this.layout;
    void this.ask('weights', () => this.source.origins(id), (origins) => {
      this.checkCount({ corners: origins.barycentrics });
      this.painted = new PaintedVertices(origins);
    });
  }

  wantFlat(): void {
    if (this.asks.has('flat') || !this.layout) return;
    const { id } = this.layout;
    const rest = this.rest ?? this.source.restCorners();
    void this.ask('flat', () => Promise.all([this.source.origins(id), rest]), ([origins, atRest]) => {
      this.checkCount(atRest);
      this.checkCount({ corners: origins.barycentrics });
      this.verticesOnly = new VerticesOnly(origins, atRest);
      this.moveFlat(atRest.origin);
    });
  }

  /** The lattice has changed: the vertices of the flat faces move. */
  latticeMoved(): void {
    if (this.flat) this.moveFlat(this.flat.origin);
  }

  private moveFlat(origin: FlatPatches['origin']): void {
    const corners = this.verticesOnly!.corners(this.source.lattice());
    this.flat = { origin, corners };
    if (this.flatCorners === undefined) this.flatCorners = cornerTexture(corners);
    else writeCorners(corners, this.flatCorners);
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

  private checkCount({ corners }: { readonly corners: ArrayLike<number> }): void {
    const patches = corners.length / 9;
    if (patches !== this.layout?.patchCount) throw new Error(`${patches} patches at rest, ${this.layout?.patchCount} deformed`);
  }

  private takeRest(rest: RestCorners): void {
    this.checkCount(rest);
    const { origin, corners } = rest;
    const patches = corners.length / 9;
    this.rest = rest;
    this.restCorners = cornerTexture(corners);
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

/** Three texels per patch: x y z of its corners. */
function cornerTexture(corners: Float32Array): DataTexture {
  const texture = patchTexture(corners.length / 9, 3, () => undefined);
  writeCorners(corners, texture);
  return texture;
}

function writeCorners(corners: Float32Array, texture: DataTexture): void {
  const data = texture.image.data as Float32Array;
  for (let from = 0, to = 0; from < corners.length; from += 3, to += 4) {
    data[to] = corners[from]!;
    data[to + 1] = corners[from + 1]!;
    data[to + 2] = corners[from + 2]!;
  }
  texture.needsUpdate = true;
}

/** Hues a golden angle apart, so that neighbouring numbers differ; grey outside the frame. */
function colourOfBox(box: number, colour: Color): Color {
  return box < 0 ? colour.setRGB(0.45, 0.45, 0.45) : colour.setHSL((box * 0.618034) % 1, 0.45, 0.6);
}
