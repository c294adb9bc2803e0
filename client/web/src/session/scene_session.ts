// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Lattice, Vec3 } from '../lattice/lattice';
import type { Surface } from '../surface/surface';
import type { LatticeEdit, SurfacePoint } from './lattice_edit';

/** One undo step. Every update replaces the one before, applied to the state at the gesture's begin. */
export interface Gesture {
  /** `session.lattice` follows at once; the newest replaces what is unsent. */
  update(edit: LatticeEdit): void;
  /** Ends the gesture; with an edit, that replaces the last update first. */
  commit(edit?: LatticeEdit): void;
  /** Ends the gesture and restores the state at its begin. */
  cancel(): void;
}

/** Whoever has begun a gesture. */
export interface GestureListener {
  /** The server has moved the points of a drag, and left them at most so far from their targets, in world units. */
  dragged?(left: number): void;
  /** The session has ended it: the scene was made anew, its structure changed, or other edits of this window came. */
  ended?(): void;
}

/** Another editor of the scene. */
export interface Presence {
  /** For people; may be empty. */
  readonly name: string;
  /** 0xRRGGBB. */
  readonly colour: number;
  /** Control points that the editor has selected. */
  readonly selected: Uint32Array;
}

/** New data of the surface. */
export interface UpdateInfo {
  readonly revision: number;
  /** From the newest own edit that the update holds to its upload, in ms; absent where it holds none of ours. */
  readonly msFromEdit?: number;
  /** Of chunk data. */
  readonly bytes: number;
  /** Patches in the update's chunks, each counted once. */
  readonly patchesSent: number;
  readonly patchesAll: number;
  /** Whether this is all detail that the view asks for. */
  readonly fullDetail: boolean;
  /** Where the time went, in ms. */
  readonly times: { readonly server: number; readonly transfer: number; readonly decode: number; readonly upload: number };
}

/** connecting: not yet live; live; retrying: lost, trying again; restored: the server had lost the scene; failed: gave up. */
export interface SessionStatus {
  readonly state: 'connecting' | 'live' | 'retrying' | 'restored' | 'failed';
  /** For people. */
  readonly text: string;
}

export interface SessionEvents {
  /** The whole lattice: after a change of structure, and where a restored scene has another. */
  lattice: (lattice: Lattice) => void;
  /** `session.lattice.points` changed at these control points, by own or others' edits. */
  points: (indices: Uint32Array) => void;
  update: (info: UpdateInfo) => void;
  /** By editor id. */
  presence: (others: ReadonlyMap<string, Presence>) => void;
  status: (status: SessionStatus) => void;
  /** An edit or a view was refused or dropped, or a gesture ended, in words; `idle`: there was nothing to undo or redo. */
  refused: (text: string, idle?: boolean) => void;
  /** What this browser keeps does not restore the scene in a server that has lost it, in words; told once. */
  notKept: (text: string) => void;
  /** The view that was asked for was refused: this one is in force again. */
  view: (view: ViewRequest) => void;
}

/** How the surface is sent; what is absent stays (view.proto, ViewOptions). */
export interface ViewRequest {
  /** Subdivisions per patch edge, 1 to 32. */
  readonly segments?: number;
  readonly normals?: 'facet' | 'smooth' | 'none';
  readonly encoding?: 'draco' | 'quantised' | 'raw';
  /** 8 to 16. */
  readonly positionBits?: number;
  /** 6 to 12. */
  readonly normalBits?: number;
}

/** A scene that is watched and edited. It reconnects by itself. */
export interface SceneSession {
  readonly sceneId: string;
  /** Editor of this window, a UUID. */
  readonly editorId: string;
  /** The newest of the server with this window's own edits on top. Another object after a change of structure. */
  readonly lattice: Lattice;
  readonly surface: Surface;
  readonly status: SessionStatus;
  /** Returns what takes the listener away. */
  on<K extends keyof SessionEvents>(event: K, listener: SessionEvents[K]): () => void;
  /** With what listens to the gesture until it ends. */
  gesture(listener?: GestureListener): Gesture;
  /** A gesture of one step. */
  apply(edit: LatticeEdit): void;
  undo(): void;
  redo(): void;
  reset(to: 'identity' | 'initial'): void;
  insertKnot(axis: 0 | 1 | 2, value: number): void;
  /** All control points at once, x y z each. */
  replace(points: Float64Array): void;
  setView(view: ViewRequest): void;
  /** Tells other windows what is selected here; at most 10 a second are sent, the newest wins. */
  announce(selected: Uint32Array): void;
  /** The first point of the deformed surface on a ray in world units. */
  pick(origin: Vec3, direction: Vec3): Promise<SurfacePoint | undefined>;
  close(): void;
}
