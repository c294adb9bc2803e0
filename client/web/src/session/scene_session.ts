// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Lattice } from '../lattice/lattice';
import type { CameraPose } from '../state/camera_pose';
import type { Person } from '../state/person';
import type { LatticeEdit } from './edits/lattice_edit';

/** One undo step. Each update replaces the one before, and applies to the state at the gesture's begin. */
export interface Gesture {
  /** `session.lattice` changes at once, except by a drag. The newest update replaces one that was not sent. */
  update(edit: LatticeEdit): void;
  /** Ends the gesture. `edit` replaces the last update first. */
  commit(edit?: LatticeEdit): void;
  /** Ends the gesture and restores the state at its begin. */
  cancel(): void;
}

/** The callbacks of whoever began a gesture. */
export interface GestureListener {
  /** The server has moved the points of a drag. `left` is their largest distance from their targets, in world units. */
  dragged?(left: number): void;
  /** The session has ended it: the scene was made again, its structure changed, or this window made another edit. */
  ended?(): void;
}

/** An editor of the scene. */
export interface Presence extends Person {
  /** Control points that the editor has selected. */
  readonly selected: Uint32Array;
  /** The lattice of `selected`, from 0. */
  readonly lattice: number;
  /** How the editor looks at the scene, if it is known. */
  readonly camera?: CameraPose;
  /** The id of the editor whose camera this one shows; empty: nobody's. */
  readonly following: string;
}

/** New data of the surface. */
export interface UpdateInfo {
  readonly revision: number;
  /** From the newest own edit in the update to the update's upload, in ms; absent if it holds none. */
  readonly msFromEdit?: number;
  /** Bytes of chunk data. */
  readonly bytes: number;
  /** Patches in the update's chunks, each counted once. */
  readonly patchesSent: number;
  readonly patchesAll: number;
  /** Of the whole surface. */
  readonly points: number;
  /** The largest distance of the surface from the exact one, in world units; 0: not known, in a view without a tolerance. */
  readonly certifiedError: number;
  /** Whether this is all detail that the view asks for. */
  readonly fullDetail: boolean;
  /** Which encoding the page has chosen and why, if that was left to it. For people. */
  readonly chosen?: string;
  /** Where the time went, in ms. */
  readonly times: { readonly server: number; readonly transfer: number; readonly decode: number; readonly upload: number };
}

/** connecting: not yet live; live; retrying: lost, trying again; token: waits for one that is valid; failed: gave up. */
export interface SessionStatus {
  readonly state: 'connecting' | 'live' | 'retrying' | 'token' | 'failed';
  /** For people. */
  readonly text: string;
}

export interface SessionEvents {
  /** The first lattice, or one with another structure or structure id. */
  lattice: (lattice: Lattice) => void;
  /** `session.constraints` changed, or the lattice did. */
  constraints: () => void;
  /** `session.lattice.points` changed at these control points. `isOwn`: by an edit of this window, before the server's answer. */
  points: (indices: Uint32Array, isOwn: boolean) => void;
  /** The server has answered an edit of this window: the steps to undo or redo may have changed. */
  answered: () => void;
  /** This window has given the scene a lattice that keeps the shape: the largest distance by which it did not, world units. */
  refitted: (distance: number) => void;
  update: (info: UpdateInfo) => void;
  /** The other editors, by editor id. */
  presence: (others: ReadonlyMap<string, Presence>) => void;
  status: (status: SessionStatus) => void;
  /** An edit or view was refused or dropped, or a gesture ended, in words. `idle`: nothing to undo or redo. */
  refused: (text: string, idle?: boolean) => void;
  /** The requested view was refused; this one is in force, as far as it is known. */
  view: (view: ViewRequest) => void;
}

/** How the surface is sent. An absent field keeps its value, at first the scene's default (view.proto, ViewOptions). */
export interface ViewRequest {
  /** Subdivisions per patch edge, 1 to 32. With a tolerance, the surface has at most as many points as these would give. */
  readonly segments?: number;
  /** The largest distance from the exact surface, in world units. 0: each patch has `segments`. */
  readonly tolerance?: number;
  /** Most points while edits come. 0: no limit. */
  readonly maxPoints?: number;
  readonly normals?: 'facet' | 'smooth' | 'none';
  /**
   * patches: no points come, and the page evaluates them by itself, within a tolerance of its own. auto: Draco, then Meshopt if the
   * rates of line and decoding favour it.
   */
  readonly encoding?: 'auto' | 'draco' | 'meshopt' | 'quantised' | 'raw' | 'patches';
  /** 8 to 16. 0 with a tolerance: the least that meet it. */
  readonly positionBits?: number;
  /** 6 to 12. */
  readonly normalBits?: number;
}

/** What a person chooses of a view. The rest follows from the camera. */
export type StreamSettings = Omit<Required<ViewRequest>, 'tolerance' | 'maxPoints'>;
