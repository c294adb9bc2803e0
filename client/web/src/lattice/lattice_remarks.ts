// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Remarks on a lattice and its mesh that a person should know, in words, with the control points that they concern.
import type { Folds } from '../wire/fold_message';
import { pointsOfBox } from './box_grid';
import type { LatticeStructure } from './grid';
import { identityPoints } from './identity';
import type { Lattice } from './lattice';
import { movedPoints, pointsOnCrossedFaces, pointsThatReach, type MeshExtent } from './mesh_extent';
import { OutsideMap } from './outside';

export interface Remark {
  readonly kind: 'fold' | 'tear' | 'outside';
  readonly text: string;
  readonly points: readonly number[];
}

export class LatticeRemarks {
  /** The control points of faces beyond which the mesh goes on. */
  private readonly crossed: readonly number[];
  /** Those of them that tear the mesh if they are not at rest. */
  private readonly tearing: readonly number[];
  private readonly rest: Float64Array;
  private readonly outside: OutsideMap;

  /** @param extent Undefined if the mesh is not known: then there are only remarks on folds. */
  constructor(private readonly structure: LatticeStructure, private readonly extent: MeshExtent | undefined) {
    this.crossed = extent?.outside ? pointsOnCrossedFaces(structure, extent) : [];
    this.tearing = extent?.acrossFaces ? pointsThatReach(structure, extent, this.crossed) : [];
    this.rest = identityPoints(structure);
    this.outside = new OutsideMap(structure);
  }

  /** @param folds The server's newest report. */
  of({ points, strength }: Pick<Lattice, 'points' | 'strength'>, folds: Folds | undefined): Remark[] {
    const { extent, crossed } = this;
    const remarks: Remark[] = [];
    const worst = folds?.places[0];
    if (worst !== undefined) {
      const text = 'The lattice folds over itself around the mesh.';
      remarks.push({ kind: 'fold', text, points: this.outside.sources(pointsOfBox(this.outside.continued, worst)) });
    }
    const torn = strength === 0 ? [] : movedPoints(this.structure, this.rest, this.tearing, points);
    if (torn.length > 0) {
      remarks.push({ kind: 'tear', text: 'The mesh is torn at a face of the lattice: outside, nothing moves it.', points: torn });
    } else if (extent?.outside) {
      remarks.push({ kind: 'outside', text: 'Part of the mesh lies outside the lattice, where nothing moves it.', points: crossed });
    }
    return remarks;
  }
}
