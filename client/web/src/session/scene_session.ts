// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Lattice } from '../lattice/lattice';
import type { LatticeEdit } from './edits/lattice_edit';

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
  /** The whole lattice: the first, after a change of structure, and where a restored scene has another. */
  lattice: (lattice: Lattice) => void;
  /** `session.lattice.points` changed at these control points, by own or others' edits. */
  points: (indices: Uint32Array) => void;
  /** The server's lattice changed. */
  serverMoved: () => void;
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
