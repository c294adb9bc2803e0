// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Texture coordinates and base colour of a GLB, in the order in which the server numbers its corners: nodes of the
// scene from parent to child, their primitives in turn, mirrored nodes with their triangles turned round.
import { Mesh, type BufferGeometry, type MeshStandardMaterial, type Texture } from 'three';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';

export interface GlbTexture {
  readonly cornerUvs: Float32Array;
  /** Of the first material that has one. */
  readonly texture?: Texture;
}

export async function glbTexture(bytes: Uint8Array<ArrayBuffer>): Promise<GlbTexture | undefined> {
  const { scene } = await new GLTFLoader().parseAsync(bytes.slice().buffer, '');
  scene.updateMatrixWorld(true);
  const corners: number[] = [];
  let texture: Texture | undefined;
  let any = false;
  scene.traverse((object) => {
    if (!(object instanceof Mesh)) return;
    const mesh = object as Mesh<BufferGeometry, MeshStandardMaterial>;
    any ||= mesh.geometry.hasAttribute('uv');
    texture ??= mesh.material.map ?? undefined;
    addCorners(mesh.geometry, mesh.matrixWorld.determinant() < 0, corners);
  });
  return any ? { cornerUvs: Float32Array.from(corners), ...(texture && { texture }) } : undefined;
}

function addCorners(geometry: BufferGeometry, mirrored: boolean, corners: number[]): void {
  const uv = geometry.hasAttribute('uv') ? geometry.getAttribute('uv') : undefined;
  const index = geometry.getIndex();
  const count = index?.count ?? geometry.getAttribute('position').count;
  for (let i = 0; i + 2 < count; i += 3) {
    for (const corner of mirrored ? [i, i + 2, i + 1] : [i, i + 1, i + 2]) {
      const vertex = index?.getX(corner) ?? corner;
      corners.push(uv?.getX(vertex) ?? 0, uv?.getY(vertex) ?? 0);
    }
  }
}
