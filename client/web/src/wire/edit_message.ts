// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { create, type MessageInitShape } from '@bufbuild/protobuf';
import { EditSchema, ResetTarget, UndoScope, type Edit } from 'latticed/v1/edit_pb';
import { LatticeAxis } from 'latticed/v1/lattice_pb';
import { SurfacePointSchema, type SurfacePoint as SurfacePointMessage } from 'latticed/v1/surface_pb';
import type { LatticeEdit, SurfacePoint } from '../session/edits/lattice_edit';
import type { Constraints } from '../lattice/constraints';
import type { Lattice } from '../lattice/lattice';
import { fromConstraints } from './constraint_message';
import { fromLattice, fromVector, vector } from './lattice_message';

type Arm = Exclude<MessageInitShape<typeof EditSchema>['edit'], undefined>;

const made = (edit: Arm): Edit => create(EditSchema, { edit });

export function fromEdit(edit: LatticeEdit): Edit {
  if (edit.kind === 'drag') {
    const { points, targets } = edit;
    return made({ case: 'dragPoints', value: { points: points.map(fromSurfacePoint), targets: Array.from(targets) } });
  }
  if (edit.kind === 'strength') return made({ case: 'setStrength', value: { strength: edit.strength } });
  const indices = Array.from(edit.indices);
  switch (edit.kind) {
    case 'move': return made({ case: 'moveControlPoints', value: { indices, offset: fromVector(edit.offset) } });
    case 'transform': return made({ case: 'transformControlPoints', value: { indices, matrix: Array.from(edit.matrix) } });
    case 'set': return made({ case: 'setControlPoints', value: { indices, positions: Array.from(edit.positions) } });
  }
}

export const edits = {
  undo: () => made({ case: 'undo', value: { scope: UndoScope.MINE } }),
  redo: () => made({ case: 'redo', value: {} }),
  reset: (to: 'identity' | 'initial') =>
    made({ case: 'reset', value: { target: to === 'initial' ? ResetTarget.INITIAL : ResetTarget.IDENTITY } }),
  insertKnot: (axis: 0 | 1 | 2, value: number) =>
    made({ case: 'insertKnot', value: { axis: [LatticeAxis.U, LatticeAxis.V, LatticeAxis.W][axis]!, value } }),
  /** Without control points the server fits them to the present shape. */
  replaceLattice: (lattice: Lattice, keepShape: boolean) => {
    const message = fromLattice(lattice);
    if (keepShape) message.controlPoints = [];
    return made({ case: 'replaceLattice', value: { lattice: message, keepShape } });
  },
  removeLattice: () => made({ case: 'removeLattice', value: {} }),
  /** float32 weights of some vertices, in their order. */
  setWeights: (indices: readonly number[], values: Float32Array) =>
    made({ case: 'setWeights', value: { change: { case: 'some', value: {
      indices: [...indices], values: new Uint8Array(values.buffer, values.byteOffset, values.byteLength) as Uint8Array<ArrayBuffer>,
    } } } }),
  clearWeights: () => made({ case: 'setWeights', value: { change: { case: 'clear', value: true } } }),
  setConstraints: (constraints: Constraints) =>
    made({ case: 'setConstraints', value: { constraints: fromConstraints(constraints) } }),
  /** Without indices all control points are carried. */
  carry: (indices: Iterable<number>, parent: Lattice) =>
    made({ case: 'carryControlPoints', value: { indices: [...indices], parent: fromLattice(parent) } }),
  replace: (points: Float64Array) => made({ case: 'replaceControlPoints', value: { controlPoints: Array.from(points) } }),
};

export function toSurfacePoint(message: SurfacePointMessage): SurfacePoint {
  const [a = 0, b = 0, c = 0] = message.corners;
  const [p = 0, q = 0, r = 0] = message.barycentrics;
  return {
    face: message.face, corners: [a, b, c], barycentrics: [p, q, r], position: vector(message.position),
    ...(message.normal && { normal: vector(message.normal) }),
  };
}

function fromSurfacePoint(point: SurfacePoint): SurfacePointMessage {
  return create(SurfacePointSchema, {
    face: point.face, corners: [...point.corners], barycentrics: [...point.barycentrics] });
}
