// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import {
  Box3, type BufferGeometry, DoubleSide, Group, Mesh, Scene, ShaderMaterial, Sphere, Vector3, type Camera, type DataArrayTexture,
  type Material, type WebGLRenderer,
} from 'three';
import { EdgeBounds } from '../patches/levels/edge_bounds';
import { Cavity } from '../light/cavity';
import { Shadings } from '../light/shadings';
import type { Shades } from '../viewport/motion';
import { ChunkBounds } from './chunk_bounds';
import type { EvaluatedPoints } from './evaluated_points';
import { largestAtCorners, largestAtPoints, type DrawnPoints } from './largest_distance';
import { PatchColours } from './patch_colours';
import type { PaintedVertices } from './painted_vertices';
import type { PatchFacts, PatchSource } from './patch_source';
import type { PatchPlaces } from './patches/patch_places';
import { PointBuffer } from './point_buffer';
import type { SurfaceLook } from './surface_look';
import type { Evaluation, Grid, SurfaceUpdate } from './surface_update';
import { definesOf, redefine } from './shader_defines';
import { FRAGMENT_SHADER, VERTEX_SHADER } from './surface_shader';
import { overUniforms, surfaceUniforms } from './surface_uniforms';
import type { TopologyLayout } from './topology_layout';
import { TriangleSides } from './triangle_sides';

/** Draws a shape over the surface where both are the same but for half a step of the grid. */
const NEARER = { polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -256 };

/** The streamed surface as three draws it: one geometry for all chunks, written in place. */
export class SurfaceMesh {
  private static readonly TRIANGLES_ALONE = 30_000;  // at most, if the pattern has so coarse a detail
  private static readonly LEAST_HEAT = 5e-3;  // of the surface's size; smaller ranges would show the steps of the grid

  /** In world coordinates: the mesh and the ghost inside have positions of their own. */
  readonly object = new Group();
  /** World bounds of the surface as received last. */
  readonly bounds = new Box3();
  private readonly streamed = new PointBuffer();
  private points: PointBuffer | EvaluatedPoints = this.streamed;
  private readonly uniforms = surfaceUniforms();
  private readonly material = this.materialOf({ side: DoubleSide, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
  private readonly ghostMaterial = this.materialOf({ side: DoubleSide, transparent: true, depthWrite: false, ...NEARER });
  private readonly mesh = new Mesh(undefined, this.material);
  private readonly ghost = new Mesh(undefined, this.ghostMaterial);
  private readonly flatMaterial = this.materialOf({ side: DoubleSide, ...NEARER });
  private readonly flat = new Mesh(undefined, this.flatMaterial);
  private readonly shadings = new Shadings();
  private readonly overUniforms = overUniforms(this.shadings.of('studio'));
  private readonly normalsMaterial = this.materialOf({ side: DoubleSide });
  private readonly sides = new TriangleSides(this.materialOf({ transparent: true, depthWrite: false }));
  private readonly cavity = new Cavity();
  private readonly alone = new Mesh();
  private readonly aloneScene = new Scene().add(this.alone);
  private readonly patches: PatchColours;
  /** Called when the surface looks different without an update: data for the look has arrived. */
  onChanged?: () => void;
  /** Called when data for a look cannot be fetched. Once for each cause until another look is chosen. */
  onFailed?: (what: PatchFacts, error: unknown) => void;
  private readonly chunkBounds = new ChunkBounds();
  /** What has come of a view whose points are evaluated here. */
  readonly edgeBounds = new EdgeBounds();
  /** The largest distance of points that are evaluated here from the exact surface, in world units; 0: not known. */
  certifiedError = 0;
  /** The layout that is drawn; absent before the first update. */
  layout: TopologyLayout | undefined;
  grid: Grid | undefined;
  /** The largest distance of the surface from the shape if only vertices moved, in world units; 0 if it is not compared. */
  largestDifference = 0;
  private hasNormals = false;
  private shades: Shades = 'new';
  private look: SurfaceLook = {};

  constructor(source: PatchSource) {
    this.patches = new PatchColours(source, () => {
      this.dress();
      this.compareAgain();
      this.onChanged?.();
    }, (what, error) => this.onFailed?.(what, error));
    this.ghostMaterial.uniforms.opacity = { value: 0.2 };
    this.mesh.onBeforeRender = (renderer, _, camera) => this.drawCavity(renderer, camera);
    this.alone.matrixAutoUpdate = false;
    this.alone.frustumCulled = false;
    this.ghost.visible = false;
    this.ghost.renderOrder = 1;
    this.ghost.frustumCulled = false;
    this.mesh.visible = false;
    this.flat.visible = false;
    this.flat.frustumCulled = false;
    this.sides.object.material.uniforms.opacity = { value: 1 };
    this.mesh.add(this.sides.object);
    this.object.add(this.mesh, this.ghost, this.flat);
  }

  /** The distance at the end of the heat map, in world units: the largest one found, at least 0.5 % of the size. */
  get displacementRange(): number {
    return this.uniforms.displacementRange.value;
  }

  /** The number of triangles of each detail, the finest first. */
  get triangles(): readonly number[] {
    return this.layout ? this.points.triangles : [0];
  }

  /** Draws a detail of the patterns by its number, 0 with all points; `shades`: its cavities. */
  setDetail(detail: number, shades: Shades): void {
    this.points.setDetail(detail);
    this.shades = shades;
  }

  /** Points of all patches. */
  get pointCount(): number {
    return this.layout ? this.places.pointCount : 0;
  }

  get patchCount(): number {
    return this.layout?.patchCount ?? 0;
  }

  /** Where the points of each patch are, once the first update has come. */
  get places(): PatchPlaces {
    return this.points.places;
  }

  /** Whether the look's texture is drawn, which needs its coordinates from the server. */
  get isTextured(): boolean {
    return 'TEXTURED' in (this.material.defines ?? {});
  }

  /** World coordinates of a received point, by its place in the vertex buffer. */
  positionOf(point: number): [number, number, number] {
    const [x = 0, y = 0, z = 0] = this.points.pointAt(point);
    const { origin, step } = this.grid!;
    return [origin[0] + x * step, origin[1] + y * step, origin[2] + z * step];
  }

  /** Calls `visit` with the world box of each chunk, which it may not keep. */
  eachBox(visit: (box: Box3) => void): void {
    const { position, scale } = this.mesh;
    this.chunkBounds.each((box) => {
      for (const corner of [box.min, box.max]) corner.multiply(scale).add(position);
      visit(box);
    });
  }

  apply(update: SurfaceUpdate): void {
    const { layout, grid, normals } = update;
    const float = update.chunks[0]?.decoded.points instanceof Float32Array;
    const geometry = this.streamed.prepare(layout, float, update.chunks);
    for (const { index, decoded } of update.chunks) this.streamed.write(index, decoded.points);
    this.edgeBounds.clear();
    this.certifiedError = 0;
    const extents = update.chunks.map(({ index, decoded }) => [index, decoded.extent] as const);
    this.draw(this.streamed, geometry, layout, grid, normals, extents);
  }

  /** Draws points that are evaluated here, in place of those that came. */
  applyEvaluation({ points, grid, normals, extents }: Evaluation): void {
    this.draw(points, points.drawn!, points.places.layout, grid, normals, extents);
  }

  /** Whether these are the points that are drawn. */
  draws(points: EvaluatedPoints): boolean {
    return this.points === points;
  }

  /** The points are gone: nothing is drawn until others come. */
  hide(): void {
    this.points = this.streamed;
    this.layout = undefined;
    this.mesh.visible = false;
    this.dress();
  }

  private draw(
    points: PointBuffer | EvaluatedPoints, geometry: BufferGeometry, layout: TopologyLayout, grid: Grid, normals: boolean,
    extents: Iterable<readonly [number, Float32Array]>,
  ): void {
    if (layout.id !== this.layout?.id || points !== this.points) this.takeLayout(layout);
    this.points = points;
    this.takeGrid(grid);
    for (const [chunk, extent] of extents) this.chunkBounds.set(chunk, extent);
    const areOthers = this.patches.setLayout(layout);
    if (areOthers || !this.mesh.visible || normals !== this.hasNormals || this.mesh.geometry !== geometry) {
      this.hasNormals = normals;
      this.mesh.geometry = this.ghost.geometry = this.flat.geometry = this.alone.geometry = geometry;
      this.mesh.visible = true;
      this.dress();
    }
    this.measure();
    this.scaleHeat();
    this.drawSides();
  }

  /** Draws the surface and nothing else with a material, with few triangles: for pictures that show only what is broad. */
  readonly drawAlone = (renderer: WebGLRenderer, camera: Camera, material: Material): void => {
    if (!this.layout) return;
    this.alone.material = material;
    this.alone.matrix.compose(this.mesh.position, this.mesh.quaternion, this.mesh.scale);
    this.points.drawCoarse(SurfaceMesh.TRIANGLES_ALONE, () => renderer.render(this.aloneScene, camera));
  };

  /** Whether the shape if only vertices moved is shown. */
  get isCompared(): boolean {
    return this.flat.visible;
  }

  /** Moves the shape that only vertices would make, and measures it. Called once a frame, after edits and updates. */
  compareAgain(): void {
    this.largestDifference = 0;
    if (!this.comparesVertices) return;
    this.patches.latticeMoved();
    const { flat } = this.patches;
    if (this.layout && flat) this.largestDifference = largestAtPoints(this.drawnPoints(), flat);
    this.scaleHeat();
  }

  /** The vertices' weights, once the look 'weights' has fetched them. */
  get painted(): PaintedVertices | undefined {
    return this.layout && this.patches.painted;
  }

  /** World positions of the vertices as they are drawn, x y z each, of `painted`. */
  vertexPlaces(): Float64Array {
    return this.painted!.places(this.drawnPoints());
  }

  /** The weights shown are not the server's: fetches them again. */
  dropWeights(): void {
    this.patches.dropWeights();
    this.dress();
  }

  /** Where a split view is divided, in pixels of the frame buffer from its left. */
  setDivider(pixels: number): void {
    this.uniforms.divider.value = pixels;
  }

  /** The knots have changed, so the patches have too: facts about the old ones are dropped. */
  structureChanged(): void {
    this.patches.structureChanged();
    this.dress();
  }

  /** The server is back: data that the look still lacks is fetched again. */
  reconnected(): void {
    this.patches.reconnected();
    this.dress();
  }

  setLook(look: SurfaceLook): void {
    const before = this.look;
    this.look = { ...before, ...look };
    const changed = (keys: readonly (keyof SurfaceLook)[]): boolean => keys.some((key) => this.look[key] !== before[key]);
    if (!changed(Object.keys(look) as (keyof SurfaceLook)[])) return;
    if (changed(['colouring', 'ghost', 'compare'])) this.patches.chosenAnew();
    if (look.colour !== undefined) this.uniforms.baseColour.value.setHex(look.colour);
    if (look.tones !== undefined) this.uniforms.tones.value.set(...look.tones);
    this.uniforms.patchEdges.value = this.look.patchEdges ? 1 : 0;
    this.dress();
    this.drawSides();
    if (changed(['colouring', 'compare'])) this.compareAgain();
  }

  /**
   * Sets base colours in layers, with u v layer for each corner of the mesh; v = 0 is the texture's first row. Without
   * arguments there are none. The caller keeps the texture and disposes of it.
   */
  setTexture(texture: DataArrayTexture | undefined, corners?: Float32Array): void {
    this.uniforms.map.value = texture ?? null;
    this.patches.setUvs(texture ? corners : undefined);
    this.dress();
  }

  dispose(): void {
    this.sides.dispose();
    this.streamed.dispose();
    this.patches.forget();
    for (const material of [this.material, this.ghostMaterial, this.flatMaterial, this.normalsMaterial]) material.dispose();
    this.shadings.dispose();
    this.cavity.dispose();
    this.object.removeFromParent();
  }

  private drawCavity(renderer: WebGLRenderer, camera: Camera): void {
    renderer.getDrawingBufferSize(this.uniforms.viewSize.value);
    // Other targets hold no colours, like the depth of a pick.
    if (!this.hasNormals || renderer.getRenderTarget() !== null) return;
    this.uniforms.hollows.value = this.shades === 'none' ? this.cavity.none : this.cavity.texture;
    if (this.shades !== 'new') return;
    this.cavity.draw(renderer, camera, this.bounds, this.uniforms.size.value, () => this.drawAlone(renderer, camera, this.normalsMaterial));
  }

  private takeLayout(layout: TopologyLayout): void {
    this.layout = layout;
    this.chunkBounds.reset(layout.chunkCount);
    this.uniforms.whole.value = layout.whole;
  }

  private takeGrid(grid: Grid): void {
    this.grid = grid;
    this.mesh.position.fromArray(grid.origin);
    this.mesh.scale.setScalar(grid.step);
    this.uniforms.step.value = grid.step;
    this.uniforms.octahedralMax.value = 2 ** grid.normalBits - 2;
    this.placeRest();
  }

  private get comparesVertices(): boolean {
    return this.look.colouring === 'difference' || (this.look.compare ?? 'off') !== 'off';
  }

  private scaleHeat(): void {
    const { look, patches } = this;
    if (look.colouring !== 'displacement' && look.colouring !== 'difference') return;
    const isDisplacement = look.colouring === 'displacement';
    const reference = isDisplacement ? patches.rest : patches.flat;
    const isKnown = reference !== undefined && this.layout !== undefined;
    const found = isKnown && isDisplacement ? largestAtCorners(this.drawnPoints(), reference) : this.largestDifference;
    const least = SurfaceMesh.LEAST_HEAT * this.bounds.getSize(new Vector3()).length();
    this.uniforms.displacementRange.value = isKnown ? Math.max(found, least) : 0;
  }

  private drawnPoints(): DrawnPoints {
    return { places: this.places, numbers: this.points.numbers, ...this.grid! };
  }

  /** The wireframe: lines at integer barycentrics are the sides of triangles only where all patches have the same segments. */
  private drawSides(): void {
    const { look: { wireframe = false }, layout } = this;
    this.uniforms.wireframe.value = wireframe && !layout?.isAdaptive ? 1 : 0;
    const isDrawn = wireframe && layout?.isAdaptive === true;
    this.sides.object.visible = this.material.polygonOffset = isDrawn;
    if (isDrawn) this.sides.update(this.places, this.mesh.geometry);
  }

  private placeRest(): void {
    const rest = (this.patches.rest ?? this.patches.flat)?.origin;
    if (!rest || !this.grid) return;
    this.ghost.position.fromArray(rest);
    this.flat.position.fromArray(rest);
    const { origin } = this.grid;
    this.uniforms.toRest.value.set(origin[0] - rest[0], origin[1] - rest[1], origin[2] - rest[2]);
  }

  private measure(): void {
    const local = this.chunkBounds.all();
    this.mesh.geometry.boundingBox = local;
    this.mesh.geometry.boundingSphere = local.getBoundingSphere(new Sphere());
    this.mesh.updateMatrix();
    this.bounds.copy(local).applyMatrix4(this.mesh.matrix);
    this.uniforms.size.value = this.bounds.getSize(new Vector3()).length();
  }

  /** Sets the shaders' input from the look and the known facts about patches. Fetches missing facts. */
  private dress(): void {
    const { look, patches } = this;
    if (this.layout) {
      if (look.ghost || look.colouring === 'displacement' || look.colouring === 'boxes') patches.wantRest();
      if (look.colouring === 'texture') patches.wantUvs();
      if (look.colouring === 'weights') patches.wantWeights();
      if (this.comparesVertices) patches.wantFlat();
    }
    const { restCorners, flatCorners, boxColours, uvs, painted } = patches;
    this.uniforms.restCorners.value = restCorners ?? null;
    this.uniforms.flatCorners.value = flatCorners ?? null;
    this.uniforms.boxColours.value = boxColours ?? null;
    this.uniforms.patchUvs.value = uvs ?? null;
    this.uniforms.patchWeights.value = painted?.texture ?? null;
    this.placeRest();
    this.scaleHeat();
    const light = (look.colouring ?? 'plain') === 'plain' ? look.light ?? 'studio' : 'studio';
    this.uniforms.shading.value = this.shadings.of(light);
    const compare = flatCorners ? look.compare : 'off';
    const defines = definesOf({
      look, light, compare, hasFloats: this.points.float, hasNormals: this.hasNormals,
      known: {
        boxes: Boolean(boxColours), displacement: Boolean(restCorners), difference: Boolean(flatCorners),
        texture: Boolean(uvs && this.uniforms.map.value), weights: Boolean(painted),
      },
    });
    redefine(this.material, defines.surface);
    redefine(this.normalsMaterial, defines.normals);
    redefine(this.sides.object.material, defines.sides);
    redefine(this.ghostMaterial, defines.ghost);
    redefine(this.flatMaterial, defines.flat);
    this.ghost.visible = Boolean(look.ghost && restCorners && this.mesh.visible);
    this.flat.visible = compare !== undefined && compare !== 'off' && this.mesh.visible;
    this.flatMaterial.transparent = this.flatMaterial.polygonOffset = compare === 'over';
    const { baseColour, opacity, shading, tones } = compare === 'over' ? this.overUniforms : this.uniforms;
    Object.assign(this.flatMaterial.uniforms, { baseColour, opacity, shading, tones });
  }

  private materialOf(options: ConstructorParameters<typeof ShaderMaterial>[0]): ShaderMaterial {
    return new ShaderMaterial({ ...options, uniforms: { ...this.uniforms }, vertexShader: VERTEX_SHADER, fragmentShader: FRAGMENT_SHADER });
  }
}
