// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { BufferAttribute, BufferGeometry, LineSegments, Sphere, Vector2, type Camera, type ShaderMaterial, type WebGLRenderer } from 'three';
import type { PatchPlaces } from './patches/patch_places';
import type { PatchPattern } from './patches/patch_pattern';

/**
 * The sides of triangles as lines, for patches that have patterns of their own: a fragment does not know how far it is from
 * the sides of its triangle, since triangles share points. Lines are one pixel wide.
 */
export class TriangleSides {
  readonly object: LineSegments<BufferGeometry, ShaderMaterial>;
  private readonly sides = new Map<PatchPattern, Uint16Array>();
  private readonly pixels = new Vector2();
  private triangles = 0;
  /** What the lines were made of. */
  private made: { readonly places: PatchPlaces; readonly version: number; readonly vertices: BufferGeometry } | undefined;

  /** @param material With a uniform `opacity` of its own. */
  constructor(material: ShaderMaterial) {
    this.object = new LineSegments(new BufferGeometry(), material);
    this.object.frustumCulled = false;
    this.object.visible = false;
    this.object.renderOrder = 1;
    this.object.onBeforeRender = (renderer, _, camera) => this.fade(renderer, camera);
  }

  /** Makes the lines for the vertices of a geometry, anew if other points are joined. */
  update(places: PatchPlaces, vertices: BufferGeometry): void {
    const { geometry } = this.object;
    geometry.boundingSphere = vertices.boundingSphere;
    const { made } = this;
    if (made?.places === places && made.version === places.version && made.vertices === vertices) return;
    this.made = { places, version: places.version, vertices };
    const ends: number[] = [];
    places.eachPatch(1, (_, pattern, firstPoint) => {
      for (const point of this.sidesOf(pattern)) ends.push(firstPoint + point);
    });
    this.release();
    for (const [name, attribute] of Object.entries(vertices.attributes)) geometry.setAttribute(name, attribute);
    geometry.setIndex(new BufferAttribute(Uint32Array.from(ends), 1));
    this.triangles = places.triangleCounts[0]!;
  }

  dispose(): void {
    this.release();
  }

  /** Frees the lines and not the vertices, which are of another geometry. */
  private release(): void {
    const { geometry } = this.object;
    for (const name of Object.keys(geometry.attributes)) geometry.deleteAttribute(name);
    geometry.dispose();
  }

  /** Each side once, as two point numbers. */
  private sidesOf(pattern: PatchPattern): Uint16Array {
    const known = this.sides.get(pattern);
    if (known) return known;
    const triangles = pattern.details[0]!;
    const found = new Map<number, [number, number]>();
    for (let i = 0; i < triangles.length; ++i) {
      const [a, b] = [triangles[i]!, triangles[i % 3 === 2 ? i - 2 : i + 1]!];
      found.set(Math.min(a, b) * 65_536 + Math.max(a, b), [a, b]);
    }
    const sides = Uint16Array.from([...found.values()].flat());
    this.sides.set(pattern, sides);
    return sides;
  }

  /** Lines closer than a few pixels would be one dark area: they fade. */
  private fade(renderer: WebGLRenderer, camera: Camera): void {
    const { geometry, material, matrixWorld } = this.object;
    const sphere = new Sphere().copy(geometry.boundingSphere!).applyMatrix4(matrixWorld);
    const { elements } = camera.projectionMatrix;
    const away = elements[11] === 0 ? 1 : Math.max(sphere.center.applyMatrix4(camera.matrixWorldInverse).length(), sphere.radius);
    const radius = (sphere.radius * elements[5]! * renderer.getDrawingBufferSize(this.pixels).y) / 2 / away;
    const perPixel = Math.sqrt(this.triangles / 2) / radius;
    const share = Math.min(Math.max((perPixel - 0.15) / 0.35, 0), 1);
    material.uniforms['opacity']!.value = 0.55 * (1 - 0.75 * share);
    material.uniformsNeedUpdate = true;
  }
}
