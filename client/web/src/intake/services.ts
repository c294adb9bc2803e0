// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The page's calls to the server and to this browser's store, besides the scene's stream.
import type { MessageInitShape } from '@bufbuild/protobuf';
import type { LatticeSourceSchema } from 'latticed/v1/lattice_pb';
import { MeshFormat, UpAxis as WireUpAxis, type Mesh, type MeshHeader, type MeshUnits } from 'latticed/v1/mesh_pb';
import type { Fit } from '../lattice/identity';
import { Lattice } from '../lattice/lattice';
import type { MeshExtent } from '../lattice/mesh_extent';
import type { LiveSession } from '../session/live_session';
import { cornersOf } from '../session/patch_corners';
import type { StreamSettings, ViewRequest } from '../session/scene_session';
import type { SceneFacts, Units, UpAxis } from '../state/units';
import type { RestCorners } from '../surface/patch_source';
import { LONG_CALL_MS } from '../wire/deadlines';
import { randomId } from '../wire/ids';
import { fromAxes, fromLattice, fromOutside, vector } from '../wire/lattice_message';
import type { LatticedServer } from '../wire/latticed_server';
import { uploadMesh } from '../wire/upload';
import { fromView, toView } from '../wire/view_message';
import { CompanionStore } from './companion_store';
import type { MeshFile, MeshFormatName } from './mesh_file';

export const EXPORT_FORMATS = ['glb', 'ply', 'obj', 'usda', 'stl', 'drc', 'nets'] as const;
export type ExportFormat = (typeof EXPORT_FORMATS)[number];

export interface PicturedMesh {
  /** Absent if it is too large to fetch without being asked. */
  readonly file?: MeshFile;
  /** Size of the file. */
  readonly bytes: number;
}

const FORMATS: Record<MeshFormatName, MeshFormat> = {
  obj: MeshFormat.OBJ,
  ply: MeshFormat.PLY,
  stl: MeshFormat.STL,
  glb: MeshFormat.GLB,
  drc: MeshFormat.DRACO,
};

const UP_AXES: Record<UpAxis, WireUpAxis> = { x: WireUpAxis.X, y: WireUpAxis.Y, z: WireUpAxis.Z };

const MOST_FETCHED_UNASKED = 64 << 20; // bytes; a person must ask for the colours of a larger mesh

const FORMAT_NAMES = Object.keys(FORMATS) as MeshFormatName[];

/** The part of a session that fetches the mesh of the open scene. */
type MeshSource = Pick<LiveSession, 'downloadMesh'>;

/** The parts that a scene of a mesh is made from. */
export interface NewScene {
  readonly lattice: Fit | Lattice;
  readonly view: ViewRequest;
  /** Undefined: as the mesh says. */
  readonly up?: UpAxis | undefined;
  /** Degrees; undefined: as the mesh has normals, and 30 where it has none. */
  readonly creaseAngle?: number | undefined;
  /** Whether vertices have the weights of the mesh's file. */
  readonly weighted?: boolean;
}

/** A scene's name, its mesh, the view of watchers that ask for none, its units, and how the mesh lies in the lattice. */
export interface DescribedScene extends SceneFacts, Pick<MeshExtent, 'outside' | 'acrossFaces'> {
  readonly mesh: string;
  readonly patches: number;
  readonly view: Partial<StreamSettings>;
}

export class Services {
  private readonly bounds = new Map<string, Mesh['bounds']>(); // by mesh, which never changes
  private channel: BroadcastChannel | undefined;

  constructor(
    readonly server: LatticedServer,
    private readonly store = CompanionStore.ofPage(),
  ) {}

  /** Connects this browser's windows of this server. Opened on first use, since an open channel keeps Node running. */
  private get news(): BroadcastChannel {
    return (this.channel ??= new BroadcastChannel('latticed-companions'));
  }

  /** The largest mesh that the server takes, in bytes; 0: no limit. */
  async mostMeshBytes(): Promise<number> {
    const { limits } = await this.server.server.getServerInfo({});
    return Number(limits?.maxMeshBytes ?? 0);
  }

  /** Rejects with an Error in words; `progress` goes from 0 to 1. */
  async upload(file: MeshFile, progress: (fraction: number) => void, signal: AbortSignal): Promise<Mesh> {
    const header = { name: file.name, format: FORMATS[file.format] };
    const onProgress = (sent: number, all: number): void => progress(sent / all);
    const mesh = await uploadMesh(this.server, header, file.content, { onProgress, signal });
    this.bounds.set(mesh.id, mesh.bounds);
    return mesh;
  }

  /** The triangles of a mesh at rest: of a temporary scene with one knot box, in which each is one patch. */
  async triangles(mesh: string): Promise<RestCorners> {
    const sceneId = `preview-${randomId()}`;
    const call = { headers: { 'latticed-scene': sceneId }, timeoutMs: LONG_CALL_MS };
    const lattices = [latticeSource({ size: [2, 2, 2], degree: [1, 1, 1], padding: 0.05 })];
    await this.server.scenes.createScene({ sceneId, mesh, lattices, idleTtl: { seconds: 60n } }, call);
    try {
      return await cornersOf(this.server, sceneId);
    } finally {
      void this.server.scenes.deleteScene({ scene: sceneId }, call).catch(() => undefined);
    }
  }

  /** Makes a scene and returns its id. */
  async createScene(mesh: string, { lattice, view, up, creaseAngle, weighted }: NewScene): Promise<string> {
    const sceneId = randomId();
    await this.server.scenes.createScene({
      sceneId, mesh, lattices: [latticeSource(lattice)], defaultView: fromView(view), units: { upAxis: up && UP_AXES[up] },
      ...(creaseAngle !== undefined && { creaseAngle }),
      ...(weighted && { weights: { source: { case: 'fromMesh', value: true } } }),
    }, { timeoutMs: LONG_CALL_MS });
    return sceneId;
  }

  /** The file from which the mesh of a scene was uploaded. */
  async downloadMesh(mesh: string, scene: MeshSource): Promise<MeshFile> {
    const { header, content } = await scene.downloadMesh(mesh);
    const file = meshFile(header, content);
    if (file === undefined) throw new Error('The mesh was not uploaded as a file that this page reads.');
    return file;
  }

  /** What was dropped beside a mesh and saved in this browser. */
  keptCompanions(mesh: string): Promise<readonly File[]> {
    return this.store.of(mesh);
  }

  /**
   * Saves pictures and materials that were dropped beside a mesh. Replaces all others, or with `beside` those of the same
   * names. Rejects in words.
   */
  async keepCompanions(mesh: string, files: readonly File[], beside: boolean): Promise<void> {
    await this.store.save(mesh, files, beside);
    this.news.postMessage(mesh); // listeners then read the files
  }

  /** Calls `listener` with the mesh's id after another window of this browser has saved companions of it. */
  onCompanionsKept(listener: (mesh: string) => void): void {
    this.news.addEventListener('message', ({ data }: MessageEvent<string>) => listener(data));
  }

  /** The file of a mesh that may have pictures inside; undefined for other meshes. */
  async picturedMesh(id: string, scene: MeshSource): Promise<PicturedMesh | undefined> {
    const { format, hasUvs, totalBytes } = await this.server.meshes.getMesh({ mesh: id });
    if (format !== MeshFormat.GLB || !hasUvs) return undefined;
    const bytes = Number(totalBytes);
    if (bytes > MOST_FETCHED_UNASKED) return { bytes };
    return { bytes, file: await this.downloadMesh(id, scene) };
  }

  async describeScene(sceneId: string): Promise<DescribedScene> {
    const { name, mesh, patches, defaultView, units, patchesOutside, patchesOnFaces } =
      await this.server.scenes.getScene({ scene: sceneId });
    return {
      name, mesh, patches: Number(patches), view: defaultView === undefined ? {} : streamSettings(toView(defaultView)), units: toUnits(units),
      outside: patchesOutside > 0n, acrossFaces: patchesOnFaces > 0n,
    };
  }

  /** The place of a scene's mesh at rest. The server is not asked about a mesh that it has described to this page. */
  async meshExtent({ mesh, outside, acrossFaces }: DescribedScene): Promise<MeshExtent> {
    const bounds = this.bounds.get(mesh) ?? (await this.server.meshes.getMesh({ mesh })).bounds;
    this.bounds.set(mesh, bounds);
    return { min: vector(bounds?.min), max: vector(bounds?.max), outside, acrossFaces };
  }
}

function streamSettings({ segments, normals, encoding, positionBits, normalBits }: Required<ViewRequest>): StreamSettings {
  return { segments, normals, encoding, positionBits, normalBits };
}

function toUnits(units: MeshUnits | undefined): Units {
  const up = (Object.keys(UP_AXES) as UpAxis[]).find((axis) => UP_AXES[axis] === units?.upAxis);
  return { up, metersPerUnit: units?.metersPerUnit ?? 0 };
}

/** Undefined if the mesh was not uploaded in a file format of this page. */
function meshFile(header: MeshHeader, content: Blob): MeshFile | undefined {
  const format = FORMAT_NAMES.find((name) => FORMATS[name] === header.format);
  return format && { name: header.name, format, content };
}

function latticeSource(lattice: Fit | Lattice): MessageInitShape<typeof LatticeSourceSchema> {
  if (lattice instanceof Lattice) return { source: { case: 'lattice', value: fromLattice(lattice) } };
  const { size, degree, padding, outside } = lattice;
  const value = { size: fromAxes(size), degree: fromAxes(degree), padding, ...(outside && { outside: fromOutside(outside) }) };
  return { source: { case: 'fit', value } };
}
