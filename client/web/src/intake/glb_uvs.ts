// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Texture coordinates and base colours of a GLB, in the order in which the server numbers its corners: nodes of the
// scene from parent to child, their primitives in turn, mirrored nodes with their triangles turned round.
import { Mesh, type BufferGeometry, type MeshStandardMaterial } from 'three';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';
import type { Layer, MeshLayers } from './corner_layers';

export interface GlbLayers extends MeshLayers {
  readonly hasUvs: boolean;
}

export async function glbLayers(file: ArrayBuffer): Promise<GlbLayers> {
  const { scene } = await new GLTFLoader().parseAsync(file, '');
  scene.updateMatrixWorld(true);
  const corners: number[] = [];
  const materials: MeshStandardMaterial[] = [];
  let hasUvs = false;
  scene.traverse((object) => {
    if (!(object instanceof Mesh)) return;
    const { geometry, material, matrixWorld } = object as Mesh<BufferGeometry, MeshStandardMaterial>;
    const found = materials.indexOf(material);
    const layer = found >= 0 ? found : materials.push(material) - 1;
    const channel = material.map?.channel ?? 0;
    const uvs = `uv${channel > 0 ? channel : ''}`;
    hasUvs ||= geometry.hasAttribute(uvs);
    addCorners(geometry, uvs, layer, matrixWorld.determinant() < 0, corners);
  });
  return { corners: Float32Array.from(corners), layers: materials.map(layerOf), notes: [], hasUvs };
}

function layerOf({ map, color }: MeshStandardMaterial): Layer {
  const picture = map?.image as ImageBitmap | undefined;
  return { ...(picture && { picture }), colour: color.getStyle() };
}

function addCorners(geometry: BufferGeometry, uvs: string, layer: number, mirrored: boolean, corners: number[]): void {
  const uv = geometry.hasAttribute(uvs) ? geometry.getAttribute(uvs) : undefined;
  const index = geometry.getIndex();
  const count = index?.count ?? geometry.getAttribute('position').count;
  for (let i = 0; i + 2 < count; i += 3) {
    for (const corner of mirrored ? [i, i + 2, i + 1] : [i, i + 1, i + 2]) {
      const vertex = index?.getX(corner) ?? corner;
      corners.push(uv?.getX(vertex) ?? 0, uv?.getY(vertex) ?? 0, layer);
    }
  }
}
