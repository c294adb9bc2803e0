// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Texture coordinates and base colours of a GLB, in the server's order of corners: nodes of the scene from parent to
// child, their primitives in turn. Triangles of mirrored nodes are turned round.
//
// Shows base colours and their pictures (PNG, JPEG, WebP, AVIF), one material per primitive, with any set of texture
// coordinates and KHR_texture_transform. Notes tell what is not shown: vertex colours, wrapping other than repetition,
// materials of KHR_materials_pbrSpecularGlossiness, broken or missing pictures.
import { Mesh, RepeatWrapping, Vector2, type BufferGeometry, type Group, type MeshStandardMaterial, type Texture } from 'three';
import { GLTFLoader, type GLTF, type GLTFParser } from 'three/examples/jsm/loaders/GLTFLoader.js';
import { missing, type Layer, type MeshLayers } from './corner_layers';
import { GlbPictures } from './glb_pictures';

const TRIANGLES = 4;
const STRIP = 5;
const ROUNDING = 1e-3; // tolerance for coordinates that are meant to end at 0 or 1

export interface GlbLayers extends MeshLayers {
  readonly hasUvs: boolean;
  /** Whether the file names a picture that was dropped. */
  readonly takesPictures: boolean;
}

/**
 * @param name The file's name, for notes.
 * @param pictures Pictures that were dropped with it.
 *
 * Throws an Error in words if the file has no scene, or has pictures of a kind that is not shown.
 */
export async function glbLayers(name: string, file: ArrayBuffer, pictures: readonly File[]): Promise<GlbLayers> {
  const found = new GlbPictures(pictures);
  try {
    const gltf = await new GLTFLoader(found.manager).register(refuseKtx(name)).parseAsync(file, '');
    if ((gltf.scene as Group | undefined) === undefined) throw new Error(`${name} has no scene, so its pictures cannot be chosen.`);
    const { isWrapped, ...read } = new CornerReader(gltf).read();
    const notes = [...unshown(name, gltf.parser, isWrapped), ...found.missing.map((picture) => missing(name, picture))];
    if (found.broken) notes.push(`A picture of ${name} cannot be read.`);
    return { ...read, notes, takesPictures: found.taken };
  } finally {
    found.dispose();
  }
}

interface GlbTexture {
  readonly source?: number;
  readonly extensions?: Readonly<Record<string, unknown>>;
}

/** Replaces three's plugin for KTX2 pictures, which needs a decoder. A texture's other picture is used instead. */
function refuseKtx(name: string): (parser: GLTFParser) => { name: string } {
  return ({ json }) => {
    const isShown = ({ source, extensions = {} }: GlbTexture): boolean =>
      source !== undefined || 'EXT_texture_webp' in extensions || 'EXT_texture_avif' in extensions;
    if (!(json.textures ?? []).every(isShown)) {
      throw new Error(`Pictures of ${name} are of a kind that is not shown, KTX2 for instance; PNG, JPEG, WebP and AVIF are.`);
    }
    return { name: 'KHR_texture_basisu' };
  };
}

interface Primitive {
  readonly mode?: number;
  readonly attributes: Readonly<Record<string, number>>;
}

class CornerReader {
  private readonly corners: number[] = [];
  private readonly materials: MeshStandardMaterial[] = [];
  private hasUvs = false;
  private isWrapped = false;

  constructor(private readonly gltf: GLTF) {}

  read(): Pick<GlbLayers, 'corners' | 'layers' | 'hasUvs'> & { isWrapped: boolean } {
    const { scene } = this.gltf;
    scene.updateMatrixWorld(true);
    scene.traverse((object) => object instanceof Mesh && this.addMesh(object));
    const { materials, hasUvs, isWrapped } = this;
    return { corners: Float32Array.from(this.corners), layers: materials.map(layerOf), hasUvs, isWrapped };
  }

  private addMesh(mesh: Mesh<BufferGeometry, MeshStandardMaterial>): void {
    const { geometry, material, matrixWorld } = mesh;
    if (!geometry.hasAttribute('position')) return;
    const known = this.materials.indexOf(material);
    const layer = known >= 0 ? known : this.materials.push(material) - 1;
    const uvOf = this.uvsOf(geometry, material.map ?? null);
    const index = geometry.getIndex();
    const vertexAt = (corner: number): number => index?.getX(corner) ?? corner;
    const mode = this.modeOf(mesh);
    const count = index?.count ?? geometry.getAttribute('position').count;
    for (let i = 0; i + 2 < count; i += 3) {
      let [a, b, c] = [i, i + 1, i + 2].map(vertexAt);
      if (mode !== TRIANGLES && (a === b || b === c || c === a)) continue; // a degenerate triangle joins two strips
      if (mode === STRIP && (i / 3) % 2 === 1) [a, b, c] = [b, c, a]; // three begins these at their last vertex
      if (matrixWorld.determinant() < 0) [b, c] = [c, b];
      for (const vertex of [a, b, c]) {
        const { x, y } = uvOf(vertex);
        this.corners.push(x, y, layer);
      }
    }
  }

  /** Returns a vertex's texture coordinates, in the set and with the transform that the material's map uses. */
  private uvsOf(geometry: BufferGeometry, map: Texture | null): (vertex: number) => Vector2 {
    const channel = map?.channel ?? 0;
    const name = `uv${channel > 0 ? channel : ''}`;
    const uv = new Vector2();
    if (!geometry.hasAttribute(name)) return () => uv;
    this.hasUvs = true;
    const attribute = geometry.getAttribute(name);
    if (map?.matrixAutoUpdate) map.updateMatrix();
    return (vertex) => {
      uv.set(attribute.getX(vertex), attribute.getY(vertex));
      if (map !== null) uv.applyMatrix3(map.matrix);
      const leaves = (x: number): boolean => x < -ROUNDING || x > 1 + ROUNDING;
      this.isWrapped ||= (leaves(uv.x) && isOther(map?.wrapS)) || (leaves(uv.y) && isOther(map?.wrapT));
      return uv;
    };
  }

  /** The primitive's mode in the file. three has turned strips and fans into triangles. */
  private modeOf(mesh: Mesh): number {
    const { associations, json } = this.gltf.parser;
    const at = associations.get(mesh);
    const primitive: Primitive | undefined = json.meshes?.[at?.meshes ?? -1]?.primitives[at?.primitives ?? 0];
    return primitive?.mode ?? TRIANGLES;
  }
}

function isOther(wrapping: number | undefined): boolean {
  return wrapping !== undefined && wrapping !== RepeatWrapping;
}

function layerOf({ map, color }: MeshStandardMaterial): Layer {
  const picture = map?.image as ImageBitmap | undefined;
  return { ...(picture && { picture }), colour: color.getStyle() };
}

function unshown(name: string, { json }: GLTFParser, isWrapped: boolean): string[] {
  const primitives: Primitive[] = (json.meshes ?? []).flatMap((mesh: { primitives: Primitive[] }) => mesh.primitives);
  const notes: string[] = [];
  if (primitives.some(({ attributes }) => 'COLOR_0' in attributes)) notes.push(`The vertex colours of ${name} are not shown.`);
  if (isWrapped) notes.push(`${name} clamps or mirrors pictures outside of 0 to 1; they are shown repeated.`);
  if ((json.extensionsUsed ?? []).includes('KHR_materials_pbrSpecularGlossiness')) {
    notes.push(`Materials of ${name} are of KHR_materials_pbrSpecularGlossiness, whose pictures are not shown.`);
  }
  return notes;
}
