// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Opens a scene from a file, a sample or a link.
import { Code } from '@connectrpc/connect';
import type { Mesh } from 'latticed/v1/mesh_pb';
import type { DataArrayTexture } from 'three';
import { firstView, segmentsFor } from './detail_watch';
import { shownAtRest } from './intake/glb_json';
import { fileKind, readMeshFile, type MeshFile } from './intake/mesh_file';
import { sampleFile, sampleLattice, type SampleName } from './intake/samples';
import type { MeshLayers } from './intake/corner_layers';
import type { DescribedScene, NewScene } from './intake/services';
import { layerTexture, uvGrid } from './intake/layer_texture';
import { hasColours, meshLayers } from './intake/mesh_layers';
import type { Lattice } from './lattice/lattice';
import type { MeshExtent } from './lattice/mesh_extent';
import { latticeFromJson, latticeToJson } from './wire/lattice_json';
import { sameStructure } from './lattice/grid';
import { distance } from './lattice/vec';
import type { LiveSession } from './session/live_session';
import { openSession } from './session/open_session';
import type { SessionStatus, ViewRequest } from './session/scene_session';
import { showFitDialog } from './ui/dialogs/fit_dialog';
import { saveFile } from './ui/save_file';
import type { Settings } from './state/settings';
import { UNKNOWN_FACTS, type UpAxis } from './state/units';
import { ServerError } from './wire/server_error';
import { bytes, inWords } from './wire/words';
import type { Workspace } from './workspace';

const SEGMENTS_AT_FIRST = 10; // at most, where all patches have the same

/** The mesh of the open scene: its id, its file if this page has it, and the files that were dropped with it. */
interface OpenMesh {
  /** Empty until it is known. */
  id: string;
  file?: MeshFile;
  companions: readonly File[];
  /** Companions that this browser has not saved, or not yet. */
  unkept: readonly File[];
  /** Whether files that this browser saved with the mesh in earlier drops belong to it too. */
  takesKept: boolean;
  /** True: dropped or chosen on this page. False: opened by a link or after a reload. */
  readonly isDropped: boolean;
}

type MadeTexture = Pick<MeshLayers, 'corners' | 'notes'> & { readonly texture: DataArrayTexture };

/** A mesh that is dropped with companions uses only these, and not the saved ones. */
function openMesh(known: Partial<OpenMesh> = {}): OpenMesh {
  const { companions = [] } = known;
  return { id: '', isDropped: false, companions, unkept: companions, takesKept: companions.length === 0, ...known };
}

export class SceneOpener {
  private mesh = openMesh();
  private closeFitting: (() => void) | undefined;
  private texture: DataArrayTexture | undefined;
  private textureTurn = 0;
  /** The person's look, which the open sample replaces. */
  private lookBefore: Pick<Settings, 'compare' | 'cage'> | undefined;
  private openTurn = 0;
  private watchTurn = 0;

  constructor(private readonly app: Workspace) {
    // After a failure, a reload shows them.
    app.services.onCompanionsKept((mesh) => void this.companionsCame(mesh).catch(() => undefined));
  }

  /** Opens the scene that the page's address names; without one the page asks for a mesh. */
  async openFromAddress(): Promise<void> {
    const id = new URLSearchParams(location.search).get('scene');
    if (id === null) return;
    const isAsked = this.ask();
    const { scene } = this.app;
    if (id === scene?.session.sceneId) return this.app.showStatus(scene.session.status); // another one may be opening
    try {
      await this.app.busy.during('Opening the scene …', this.open(id, isAsked));
    } catch (error) {
      if (ServerError.fromConnect(error).code === Code.NotFound) this.app.recent.forget(id);
      this.app.toasts.fail(`The scene ${id} could not be opened. ${inWords(error)}`);
    }
  }

  openRecent(id: string): void {
    history.pushState(null, '', addressOf(id));
    void this.openFromAddress();
  }

  /** Where the files that were dropped beside the mesh are kept. Others who open the scene do not have them. */
  get companionsStay(): 'in this browser' | 'on this page' | undefined {
    const { companions, unkept } = this.mesh;
    if (companions.length === 0) return undefined;
    return unkept.length === 0 ? 'in this browser' : 'on this page';
  }

  takeSample(name: SampleName): void {
    this.openSample(name).catch((error: unknown) => this.app.toasts.fail(inWords(error)));
  }

  private async openSample(name: SampleName): Promise<void> {
    this.closeFitting?.();
    const isAsked = this.ask();
    const [file, lattice] = await Promise.all([sampleFile(name), sampleLattice(name)]);
    if (!isAsked()) return;
    if (lattice === undefined) return this.takeMesh(file, [], 'z');
    await this.app.busy.during('Making the scene …', this.openCompared(file, lattice, isAsked));
  }

  /** Opens a mesh under a lattice, beside its shape if only the vertices moved. */
  private async openCompared(file: MeshFile, lattice: Lattice, isAsked: () => boolean): Promise<void> {
    const { services, settings } = this.app;
    const mesh = await services.upload(file, () => undefined, new AbortController().signal);
    const made = openMesh({ id: mesh.id, file, isDropped: true });
    const view = { ...viewFor(mesh), normals: 'facet' } as const;
    if (!(await this.create(made, { lattice, view, up: 'z' }, isAsked))) return;
    const { compare, cage } = settings.value;
    this.lookBefore = { compare, cage };
    settings.set({ compare: 'split', cage: false });
    this.app.scene?.frameAll();
  }

  /** Takes dropped or chosen files: a mesh with pictures and materials, or a lattice or pictures for the scene. */
  takeFiles(files: readonly File[]): void {
    this.take(files).catch((error: unknown) => this.app.toasts.fail(inWords(error)));
  }

  saveLattice(): void {
    const { scene } = this.app;
    if (scene === undefined) return;
    saveFile('lattice.json', new Blob([latticeToJson(scene.session.lattice)], { type: 'application/json' }));
  }

  /** Loads the base colours of the open mesh, from its file and from the files that were dropped with it. */
  async loadTexture(): Promise<void> {
    const { scene } = this.app;
    if (scene === undefined) return;
    const { mesh } = this;
    const turn = ++this.textureTurn;
    const isAsked = (): boolean => turn === this.textureTurn && scene === this.app.scene;
    try {
      const { texture, corners, notes } = await this.makeTexture(mesh, scene.session);
      if (!isAsked()) return texture.dispose();
      scene.session.surface.setTexture(texture, corners);
      for (const note of notes) this.app.toasts.tell(note);
      this.texture?.dispose();
      this.texture = texture;
      this.app.viewport.invalidate();
      void this.keepCompanions(mesh);
    } catch (error) {
      if (isAsked()) throw error; // errors of a replaced request or of a closed scene are dropped
    }
  }

  private async makeTexture(mesh: OpenMesh, session: LiveSession): Promise<MadeTexture> {
    const id = await this.idOf(mesh, session);
    mesh.file ??= await this.app.services.downloadMesh(id, session);
    const grid = uvGrid();
    const { corners, layers, notes } = await meshLayers(mesh.file, mesh.companions, grid);
    const lacksPictures = !mesh.isDropped && mesh.companions.length === 0 && layers.some(({ picture }) => picture === grid);
    const elsewhere = `This browser has no pictures for ${mesh.file.name}, and shows a grid. Pictures dropped in another browser are only there.`;
    return { texture: await layerTexture(layers), corners, notes: lacksPictures ? [...notes, elsewhere] : notes };
  }

  /** Saves the companions for reloads and other windows. */
  private async keepCompanions(mesh: OpenMesh): Promise<void> {
    const { companions, unkept, takesKept } = mesh;
    if (unkept.length === 0) return;
    try {
      await this.app.services.keepCompanions(mesh.id, takesKept ? unkept : companions, takesKept);
      mesh.takesKept = true;
      mesh.unkept = mesh.unkept.filter((file) => !unkept.includes(file)); // others may have come meanwhile
    } catch (error) {
      this.app.toasts.fail(`The files dropped with this mesh will be missing after a reload: ${inWords(error)}`);
    }
  }

  /** Another window has saved companions of this mesh. They are shown here too, unless another colouring is chosen. */
  private async companionsCame(id: string): Promise<void> {
    const { mesh, app } = this;
    if (id !== mesh.id || !mesh.takesKept) return;
    mesh.companions = byName(await app.services.keptCompanions(id), mesh.unkept);
    const { colouring } = app.settings.value;
    if (mesh === this.mesh && (colouring === 'plain' || colouring === 'texture')) await this.showIfColoured(mesh);
  }

  private async take(files: readonly File[]): Promise<void> {
    const kinds = files.map(({ name }) => fileKind(name));
    const isCompanion = (_: File, i: number): boolean => kinds[i] === 'picture' || kinds[i] === 'materials';
    const companions = files.filter(isCompanion);
    const lattice = files[kinds.indexOf('lattice')];
    const others = files.filter((file, i) => file !== lattice && !isCompanion(file, i));
    const mesh = others.find(({ name }) => fileKind(name) !== undefined) ?? others[0];
    if (mesh !== undefined) this.takeMesh(await readMeshFile(mesh, () => this.app.services.mostMeshBytes()), companions);
    else if (lattice !== undefined) await this.takeLattice(lattice);
    else if (companions.length > 0) this.takeCompanions(companions);
  }

  /** Adds pictures or materials to the open mesh, and shows them. */
  private takeCompanions(companions: readonly File[]): void {
    if (this.app.scene === undefined) throw new Error('Open a mesh first, then its pictures.');
    this.mesh.companions = byName(this.mesh.companions, companions);
    this.mesh.unkept = byName(this.mesh.unkept, companions);
    this.showColours();
  }

  private showColours(): void {
    const { settings } = this.app;
    settings.set({ colouring: 'plain' }); // a change to 'texture' loads it; the old one is not shown until then
    settings.set({ colouring: 'texture' });
  }

  /** @param up The axis that is up, if it is known. */
  private takeMesh(file: MeshFile, companions: readonly File[] = [], up?: UpAxis): void {
    const { services } = this.app;
    this.closeFitting?.(); // the dialog of an earlier drop
    const { format } = file;
    this.closeFitting = showFitDialog({
      file,
      up: format === 'glb' ? undefined : (up ?? this.app.settings.value.upAxes[format]),
      upload: (progress, signal) => services.upload(file, progress, signal),
      triangles: (mesh) => services.triangles(mesh),
      create: async (mesh, fit, { up: chosen, creaseAngle, weighted }) => {
        const made = openMesh({ id: mesh.id, file, companions, isDropped: true });
        const isShown = await this.create(made, { lattice: fit, view: viewFor(mesh), up: chosen, creaseAngle, weighted });
        const { settings } = this.app;
        if (format !== 'glb' && chosen !== undefined && up === undefined)
          settings.set({ upAxes: { ...settings.value.upAxes, [format]: chosen } });
        // The server accepts some files that JSON.parse refuses.
        if (isShown) void this.tellRest(file).catch(() => undefined);
      },
    });
  }

  private async tellRest(file: MeshFile): Promise<void> {
    const rest = await shownAtRest(file);
    if (rest !== undefined) this.app.toasts.tell(rest);
  }

  /** A lattice with another frame, size, degree or knots replaces the scene's, for all who are in it. */
  private async takeLattice(file: File): Promise<void> {
    const { scene } = this.app;
    if (scene?.session.mayEdit === false) throw new Error('The token of this page only allows to watch the scene.');
    const lattice = latticeFromJson(await file.text());
    if (scene === undefined) throw new Error('Open a mesh first, then its lattice.');
    if (sameStructure(lattice, scene.session.lattice)) scene.session.replace(lattice.points);
    else scene.session.replaceLattice(lattice, false);
  }

  /** Requests a scene. The function returned says whether no later request has replaced this one. */
  private ask(): () => boolean {
    const turn = ++this.openTurn;
    return () => turn === this.openTurn;
  }

  /** Returns whether the scene is shown. It is not if another one was requested meanwhile. */
  private async create(mesh: OpenMesh, scene: NewScene, isAsked = this.ask()): Promise<boolean> {
    if (!isAsked()) return false;
    const id = await this.app.services.createScene(mesh.id, scene);
    if (!isAsked() || !(await this.open(id, isAsked, mesh))) return false;
    history.pushState(null, '', addressOf(id));
    return true;
  }

  /** Opens a scene and shows it in its colours, if it is still requested. Returns whether it is shown. */
  private async open(id: string, isAsked: () => boolean, known?: OpenMesh): Promise<boolean> {
    const { services, settings } = this.app;
    const facts = await services.describeScene(id).catch(() => undefined); // connect() says why
    const view = { ...settings.value.view, ...facts?.view };
    if (view.encoding === 'draco') view.encoding = settings.value.view.encoding; // what scenes have unless somebody chose
    const session = await this.connect(id, await this.firstView({ ...settings.value, view }, facts), isAsked);
    if (session === undefined) return false;
    const wasTextured = settings.value.colouring === 'texture';
    if (wasTextured) settings.set({ colouring: 'plain' }); // the texture belongs to the mesh before
    settings.set({ view, ...this.lookBefore });
    this.lookBefore = undefined;
    this.app.show(session, facts ?? UNKNOWN_FACTS);
    void this.watchLattice(session, facts);
    session.on('lattice', () => void this.watchLattice(session)); // its frame may have changed
    if (facts === undefined) void this.learnFacts(session).catch(() => undefined);
    const { mesh: before } = this;
    if (known !== undefined) this.mesh = known;
    else if (before.id !== facts?.mesh) this.mesh = openMesh({ id: facts?.mesh ?? '' });
    // Errors are dropped, since no person has asked for this. A person who chooses the texture sees them.
    if (this.mesh !== before || wasTextured) void this.recallColours(this.mesh, session).catch(() => undefined);
    return true;
  }

  /** A tolerance in world units needs the size of the surface, which is guessed from the mesh before the surface is known. */
  private async firstView(settings: Settings, facts: DescribedScene | undefined): Promise<ViewRequest> {
    const { pictureHeight, evaluatesPatches } = this.app.viewport;
    const patches = facts?.patches ?? 0;
    const view = firstView(settings, { diagonal: 0, patches }, pictureHeight, evaluatesPatches);
    if (!facts || view.encoding === 'patches' || settings.detail === 'segments') return view;
    const extent = await this.app.services.meshExtent(facts).catch(() => undefined);
    if (extent === undefined) return view;
    return firstView(settings, { diagonal: distance(extent.min, extent.max), patches }, pictureHeight, evaluatesPatches);
  }

  /** @param known What the server has told of the scene with its present lattice; asked for if absent. */
  private async watchLattice(session: LiveSession, known?: DescribedScene): Promise<void> {
    const turn = ++this.watchTurn;
    const { services } = this.app;
    const asked = async (): Promise<MeshExtent> => services.meshExtent(known ?? (await services.describeScene(session.sceneId)));
    const extent = await asked().catch(() => undefined);
    if (turn === this.watchTurn && session === this.app.scene?.session) this.app.watchLattice(extent);
  }

  /** Name and units of a scene that the server could not describe before. */
  private async learnFacts(session: LiveSession): Promise<void> {
    const facts = await this.app.services.describeScene(session.sceneId);
    if (session === this.app.scene?.session) this.app.setFacts(facts);
  }

  /** Undefined if the scene is no longer requested. */
  private async connect(id: string, view: ViewRequest, isAsked: () => boolean): Promise<LiveSession | undefined> {
    const shown = this.app.scene?.session;
    let session: LiveSession | undefined;
    const onStatus = (status: SessionStatus): void => {
      if (isAsked() || (session !== undefined && session === this.app.scene?.session)) this.app.showStatus(status);
    };
    try {
      session = await openSession(this.app.services.server, id, { view }, onStatus);
    } catch (error) {
      if (!isAsked()) return undefined;
      if (shown !== undefined) onStatus(shown.status);
      throw error;
    }
    if (isAsked()) return session;
    session.close();
    return undefined;
  }

  private async recallColours(mesh: OpenMesh, session: LiveSession): Promise<void> {
    if (mesh.takesKept) await this.recall(mesh, session);
    await this.showIfColoured(mesh);
  }

  private async showIfColoured(mesh: OpenMesh): Promise<void> {
    const { file, companions } = mesh;
    const isColoured = file === undefined ? companions.length > 0 : await hasColours(file, companions);
    if (isColoured && mesh === this.mesh) this.showColours();
  }

  /** Fills in the companions that this browser has saved, or else a file with pictures from the server. */
  private async recall(mesh: OpenMesh, session: LiveSession): Promise<void> {
    const { services } = this.app;
    const id = await this.idOf(mesh, session);
    const kept = await services.keptCompanions(id).catch(() => []);
    mesh.companions = byName(kept, mesh.companions); // others may have come meanwhile
    if (mesh.companions.length > 0 || mesh.file !== undefined) return;
    const pictured = await services.picturedMesh(id, session);
    mesh.file ??= pictured?.file;
    if (pictured === undefined || mesh.file !== undefined || mesh !== this.mesh) return;
    const size = bytes(pictured.bytes);
    this.app.toasts.tell(`The colours of this mesh are inside its file of ${size}: choose the texture to fetch it.`);
  }

  /** The mesh's id. The server is asked if it could not describe the scene before. */
  private async idOf(mesh: OpenMesh, { sceneId }: LiveSession): Promise<string> {
    return (mesh.id ||= (await this.app.services.describeScene(sceneId)).mesh);
  }
}

/** All files of `newer`, and the files of `older` that have other names. */
function byName(older: readonly File[], newer: readonly File[]): File[] {
  const names = new Set(newer.map(({ name }) => name));
  return [...older.filter(({ name }) => !names.has(name)), ...newer];
}

/** The view of clients that ask for none: fewer segments for more faces. A person may ask for more. */
function viewFor({ faces }: Mesh): ViewRequest {
  return { segments: segmentsFor(2 * Number(faces), SEGMENTS_AT_FIRST), normals: 'smooth' };
}

function addressOf(sceneId: string): string {
  return `?scene=${sceneId}${location.hash}`; // the fragment may hold the token
}
