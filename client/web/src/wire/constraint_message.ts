// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { create } from '@bufbuild/protobuf';
import { ConstraintsSchema, LatticeAxis, type Constraints as ConstraintsMessage } from 'latticed/v1/lattice_pb';
import { NO_CONSTRAINTS, type Constraints } from '../lattice/constraints';
import type { Axis } from '../lattice/grid';

const AXIS_VALUES = [LatticeAxis.U, LatticeAxis.V, LatticeAxis.W];

export function toConstraints(message: ConstraintsMessage | undefined): Constraints {
  if (!message) return NO_CONSTRAINTS;
  return {
    held: message.held,
    layers: message.heldLayers.map(({ axis, atEnd, layers }) => ({ axis: toAxis(axis) ?? 0, atEnd, layers })),
    mirror: toAxis(message.mirror),
    volume: message.volume && { volume: message.volume.volume, axis: toAxis(message.volume.axis) },
  };
}

export function fromConstraints({ held, layers, mirror, volume }: Constraints): ConstraintsMessage {
  return create(ConstraintsSchema, {
    held: [...held],
    heldLayers: layers.map(({ axis, atEnd, layers: count }) => ({ axis: AXIS_VALUES[axis]!, atEnd, layers: count })),
    mirror: fromAxis(mirror),
    ...(volume && { volume: { axis: fromAxis(volume.axis), ...(volume.volume !== undefined && { volume: volume.volume }) } }),
  });
}

function toAxis(axis: LatticeAxis): Axis | undefined {
  const found = AXIS_VALUES.indexOf(axis);
  return found < 0 ? undefined : (found as Axis);
}

function fromAxis(axis: Axis | undefined): LatticeAxis {
  return axis === undefined ? LatticeAxis.UNSPECIFIED : AXIS_VALUES[axis]!;
}
