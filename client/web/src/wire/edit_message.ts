// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { create } from '@bufbuild/protobuf';
import { EditSchema, ResetTarget, UndoScope, type Edit } from 'latticed/v1/edit_pb';
import { LatticeAxis } from 'latticed/v1/lattice_pb';
import { SurfacePointSchema, type SurfacePoint as SurfacePointMessage } from 'latticed/v1/surface_pb';
import type { LatticeEdit, SurfacePoint } from '../session/edits/lattice_edit';
import { fromVector, vector } from './lattice_message';

export function fromEdit(edit: LatticeEdit): Edit {
  switch (edit.kind) {
    case 'move':
      return create(EditSchema, { edit: { case: 'moveControlPoints',
        value: { indices: Array.from(edit.indices), offset: fromVector(edit.offset) } } });
    case 'transform':
      return create(EditSchema, { edit: { case: 'transformControlPoints',
        value: { indices: Array.from(edit.indices), matrix: Array.from(edit.matrix) } } });
    case 'set':
      return create(EditSchema, { edit: { case: 'setControlPoints',
        value: { indices: Array.from(edit.indices), positions: Array.from(edit.positions) } } });
    case 'drag':
      return create(EditSchema, { edit: { case: 'dragPoints',
        value: { points: edit.points.map(fromSurfacePoint), targets: Array.from(edit.targets) } } });
  }
}

export const edits = {
  undo: (): Edit => create(EditSchema, { edit: { case: 'undo', value: { scope: UndoScope.MINE } } }),
  redo: (): Edit => create(EditSchema, { edit: { case: 'redo', value: {} } }),
  reset: (to: 'identity' | 'initial'): Edit => create(EditSchema, { edit: { case: 'reset',
    value: { target: to === 'initial' ? ResetTarget.INITIAL : ResetTarget.IDENTITY } } }),
  insertKnot: (axis: 0 | 1 | 2, value: number): Edit => create(EditSchema, { edit: { case: 'insertKnot',
    value: { axis: [LatticeAxis.U, LatticeAxis.V, LatticeAxis.W][axis]!, value } } }),
  replace: (points: Float64Array): Edit => create(EditSchema, { edit: { case: 'replaceControlPoints',
    value: { controlPoints: Array.from(points) } } }),
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
