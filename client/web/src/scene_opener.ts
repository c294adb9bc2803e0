// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// From a file, a sample or a link to an open scene.
import type { Texture } from 'three';
import type { App } from './app';
import { fileKind, readMeshFile, type MeshFile } from './intake/mesh_file';
import { sampleFile, type SampleName } from './intake/samples';
import { meshTexture } from './intake/mesh_texture';
import type { UploadedMesh } from './intake/services';
import type { Fit } from './lattice/identity';
import type { Lattice } from './lattice/lattice';
import { latticeFromJson, latticeToJson } from './lattice/lattice_json';
import { sameStructure } from './lattice/same_structure';
import type { ViewRequest } from './session/scene_session';
import { FitDialog } from './ui/fit_dialog';
import { randomPerson } from './ui/people';
import { saveFile } from './ui/save_file';
import { inWords } from './wire/words';

const TRIANGLES_AT_FIRST = 600_000; // what a laptop's GPU draws at every frame without effort

export class SceneOpener {
  /** Of the scene that is open: its mesh's id, the mesh's file where this page has it, and a picture dropped for it. */
  private mesh: { id: string; file?: MeshFile; picture?: File } = { id: '' };

  private texture: Texture | undefined;
  private readonly person = randomPerson();

  constructor(private readonly app: App) {}

  /** Opens the scene that the page's address names; without one the page asks for a mesh. */
  async openFromAddress(): Promise<void> {
    const id = new URLSearchParams(location.search).get('scene');
    if (id === null || id === this.app.scene?.session.sceneId) return;
    try {
      await this.open(id);
    } catch (error) {
      this.app.toasts.fail(`The scene ${id} could not be opened. ${inWords(error)}`);
    }
  }

  takeSample(name: SampleName): void {
    this.takeMesh(sampleFile(name));
  }

  /** Takes what was dropped or chosen: a mesh, with a picture or not, or a lattice or picture for the scene. */
  takeFiles(files: readonly File[]): void {
    this.take(files).catch((error: unknown) => this.app.toasts.fail(inWords(error)));
  }

  saveLattice(): void {
    const { scene } = this.app;
    if (scene === undefined) return;
    saveFile('lattice.json', new Blob([latticeToJson(scene.session.lattice)], { type: 'application/json' }));
  }

  /** Loads the base colour of the mesh that is open: of the picture dropped for it, or of its file. */
  async loadTexture(): Promise<void> {
    const { scene, services, viewport } = this.app;
    if (scene === undefined) return;
    this.mesh.file ??= await services.downloadMesh(this.mesh.id);
    const { texture, cornerUvs } = await meshTexture(this.mesh.file, this.mesh.picture);
    await scene.session.surface.setTexture(texture, cornerUvs);
    this.texture?.dispose();
    this.texture = texture;
    viewport.invalidate();
  }

  private async take(files: readonly File[]): Promise<void> {
    const lattice = files.find((file) => fileKind(file.name) === 'lattice');
    const picture = files.find((file) => fileKind(file.name) === 'picture');
    const mesh = files.find((file) => file !== lattice && file !== picture);
    if (mesh !== undefined) this.takeMesh(await readMeshFile(mesh), picture);
    else if (lattice !== undefined) await this.takeLattice(lattice);
    else if (picture !== undefined) await this.takePicture(picture);
  }

  /** Shows the mesh with a picture as its base colour. */
  private async takePicture(picture: File): Promise<void> {
    const { scene, settings } = this.app;
    if (scene === undefined) throw new Error('Open a mesh first, then its picture.');
    this.mesh.picture = picture;
    if (settings.value.colouring === 'texture') await this.loadTexture();
    else settings.set({ colouring: 'texture' });
  }

  private takeMesh(file: MeshFile, picture?: File): void {
    const { services } = this.app;
    new FitDialog({
      file,
      upload: (progress, signal) => services.upload(file, progress, signal),
      create: async (mesh, fit) => {
        await this.create(mesh.id, fit, viewFor(mesh));
        this.mesh = { id: mesh.id, file, ...(picture && { picture }) };
        if (picture !== undefined) await this.takePicture(picture);
      },
    });
  }

  /** Another frame, size or degree is another scene of the same mesh. */
  private async takeLattice(file: File): Promise<void> {
    const lattice = latticeFromJson(await file.text());
    const { scene } = this.app;
    if (scene === undefined) throw new Error('Open a mesh first, then its lattice.');
    if (sameStructure(lattice, scene.session.lattice)) scene.session.replace(lattice.points);
    else await this.create(this.mesh.id, lattice, this.app.settings.value.view);
  }

  private async create(mesh: string, lattice: Fit | Lattice, view: ViewRequest): Promise<void> {
    const id = await this.app.services.createScene(mesh, lattice, view);
    await this.open(id);
    history.pushState(null, '', `?scene=${id}${location.hash}`); // the fragment may hold the token
  }

  private async open(id: string): Promise<void> {
    const { services, settings } = this.app;
    // A scene that is about to be restored is not there yet.
    const facts = await services.describeScene(id).catch(() => undefined);
    if (this.mesh.id !== facts?.mesh) this.mesh = { id: facts?.mesh ?? '' };
    if (settings.value.colouring === 'texture') settings.set({ colouring: 'plain' }); // of the mesh before
    if (facts !== undefined) settings.set({ view: { ...settings.value.view, ...facts.view } });
    const session = await services.openSession(id, {
      ...this.person,
      view: settings.value.view,
      onStatus: (status) => this.app.showStatus(status),
    });
    this.app.show(session);
  }
}

/** Fewer segments for more faces; a person may ask for more. */
function viewFor({ faces }: UploadedMesh): ViewRequest {
  const segments = Math.floor(Math.sqrt(TRIANGLES_AT_FIRST / (2 * Math.max(faces, 1))));
  return { segments: Math.min(Math.max(segments, 2), 10), normals: 'smooth' };
}
