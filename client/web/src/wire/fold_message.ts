// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Reports of folds (fold.proto) as plain values.
import { FoldState, type FoldReport } from 'latticed/v1/fold_pb';

/** Where a lattice folds around its mesh. */
export interface Folds {
  readonly revision: bigint;
  readonly structureId: bigint;
  /** Whether it is proved that nothing folds. */
  readonly certified: boolean;
  /** Numbers of knot boxes: with a part of the mesh; of these, folded, and neither. */
  readonly boxes: number;
  readonly folded: number;
  readonly undecided: number;
  /** The boxes that are folded, the least det J first, by their numbers on u, v and w among knot intervals that are not empty. */
  readonly places: readonly (readonly [u: number, v: number, w: number])[];
}

export function toFolds(report: FoldReport): Folds {
  const { revision, structureId, certified, places } = report;
  return {
    revision, structureId, certified,
    boxes: Number(report.boxes), folded: Number(report.folded), undecided: Number(report.undecided),
    places: places
      .filter(({ state }) => state === FoldState.FOLDED)
      .sort((a, b) => a.determinant - b.determinant)
      .map(({ box }) => [box?.u ?? 0, box?.v ?? 0, box?.w ?? 0]),
  };
}
