// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** Entry of the viewer: shows the scene that the address names. */
import { PerspectiveCamera, Scene, Vector3, WebGLRenderer } from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { openSession } from './session/open_session';
import { readAddress } from './wire/address';
import { LatticedServer } from './wire/latticed_server';

async function main(): Promise<void> {
  const { origin, token, scene: sceneId } = readAddress(new URL(location.href));
  const status = document.getElementById('status')!;
  if (!sceneId) {
    status.textContent = 'Open this page with #scene=… at the end of its address.';
    return;
  }
  const session = await openSession(new LatticedServer(origin, token), sceneId, {
    onStatus: ({ text }) => (status.textContent = text) });
  const renderer = new WebGLRenderer({ antialias: true });
  document.getElementById('viewport')!.append(renderer.domElement);
  renderer.setSize(innerWidth, innerHeight);
  const camera = new PerspectiveCamera(45, innerWidth / innerHeight);
  const scene = new Scene();
  scene.add(session.surface.object);
  const controls = new OrbitControls(camera, renderer.domElement);
  const draw = (): void => renderer.render(scene, camera);
  controls.addEventListener('change', draw);
  let framed = false;
  session.on('update', () => {
    const { bounds } = session.surface;
    if (!framed && !bounds.isEmpty()) {
      framed = true;
      const size = bounds.getSize(new Vector3()).length();
      bounds.getCenter(controls.target);
      camera.position.copy(controls.target).add(new Vector3(0.4, 0.3, 1).multiplyScalar(size));
      camera.near = size / 100;
      camera.far = size * 10;
      camera.updateProjectionMatrix();
      controls.update();
    }
    draw();
  });
}

void main().catch((error: Error) => (document.getElementById('status')!.textContent = error.message));
