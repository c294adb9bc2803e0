// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the page asks of the server besides the scene's stream.
import type { Bounds, Fit } from '../lattice/identity';
import type { Lattice } from '../lattice/lattice';
import type { SessionOptions } from '../session/open_session';
import type { SceneSession, ViewRequest } from '../session/scene_session';
import type { ExportedFile, ExportView } from '../wire/export_download';
import type { MeshFile } from './mesh_file';

export interface UploadedMesh {
  readonly id: string;
  readonly name: string;
  readonly vertices: number;
  readonly faces: number;
  readonly bounds: Bounds;
}

export const EXPORT_FORMATS = ['glb', 'ply', 'obj', 'stl', 'drc', 'nets'] as const;
export type ExportFormat = (typeof EXPORT_FORMATS)[number];

/** What a scene was made of. */
export interface SceneFacts {
  /** Id of its mesh. */
  readonly mesh: string;
  /** What watchers see who do not say. */
  readonly view: ViewRequest;
}

export interface PicturedMesh {
  /** Absent where it is too large to be fetched unasked. */
  readonly file?: MeshFile;
  /** Of the file. */
  readonly bytes: number;
}

export interface Services {
  /** The largest mesh that the server takes, in bytes; 0: any. */
  mostMeshBytes(): Promise<number>;
  /** Rejects with an Error in words; `progress` goes from 0 to 1. */
  upload(file: MeshFile, progress: (fraction: number) => void, signal: AbortSignal): Promise<UploadedMesh>;
  /** Makes a scene and returns its id. */
  createScene(mesh: string, lattice: Fit | Lattice, view: ViewRequest): Promise<string>;
  /** The file that a mesh was uploaded from. */
  downloadMesh(mesh: string, signal: AbortSignal): Promise<MeshFile>;
  /** What this browser has of a mesh: its file, and pictures and materials that were dropped beside it. */
  keptMesh(mesh: string): Promise<{ readonly file?: MeshFile; readonly companions: readonly File[] }>;
  /** Keeps pictures and materials for keptMesh, in place of all others or `beside` those of other names. Rejects in words. */
  keepCompanions(mesh: string, files: readonly File[], beside: boolean): Promise<void>;
  /** Calls `listener` where another window of this browser has kept pictures or materials beside a mesh. */
  onCompanionsKept(listener: (mesh: string) => void): void;
  /** Of a mesh that may have its pictures inside, and undefined of others. */
  picturedMesh(mesh: string, signal: AbortSignal): Promise<PicturedMesh | undefined>;
  describeScene(sceneId: string): Promise<SceneFacts>;
  openSession(sceneId: string, options: SessionOptions): Promise<SceneSession>;
  /** The deformed surface as a file; of control nets, `view` says nothing. `progress` in bytes. Rejects with an Error in words. */
  exportScene(
    sceneId: string,
    format: ExportFormat,
    view: ExportView,
    progress: (received: number, all: number) => void,
    signal: AbortSignal,
  ): Promise<ExportedFile>;
}
