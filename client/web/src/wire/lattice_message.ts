// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { create, type MessageInitShape } from '@bufbuild/protobuf';
import {
  LatticeSchema, OutsideContinuity, OutsideMode,
  type Lattice as LatticeMessage, type LatticeAxes, type LatticeOutside, type LatticeOutsideSchema,
} from 'latticed/v1/lattice_pb';
import type { Vec3 as Vec3Message } from 'latticed/v1/common_pb';
import { Lattice, type Outside, type Vec3 } from '../lattice/lattice';

/** From a message that has all fields, as in LatticeState. Throws if the control points are not as many as the size says. */
export function toLattice(message: LatticeMessage): Lattice {
  const lattice = toGivenLattice(message);
  const [given, needed] = [lattice.points.length, 3 * lattice.count];
  if (given !== needed) throw new Error(`a lattice has ${given} coordinates of control points in place of ${needed}`);
  return lattice;
}

/** From any message: an absent field becomes zeros or an empty array. */
export function toGivenLattice(message: LatticeMessage): Lattice {
  const { frame } = message;
  return new Lattice(
    { origin: vector(frame?.origin), u: vector(frame?.u), v: vector(frame?.v), w: vector(frame?.w) },
    axes(message.degree), axes(message.size),
    [Float64Array.from(message.knotsU), Float64Array.from(message.knotsV), Float64Array.from(message.knotsW)],
    Float64Array.from(message.controlPoints), toOutside(message.outside));
}

export function fromLattice(lattice: Lattice): LatticeMessage {
  const { origin, u, v, w } = lattice.frame;
  return create(LatticeSchema, {
    frame: { origin: fromVector(origin), u: fromVector(u), v: fromVector(v), w: fromVector(w) },
    degree: fromAxes(lattice.degree),
    size: fromAxes(lattice.size),
    knotsU: Array.from(lattice.knots[0]),
    knotsV: Array.from(lattice.knots[1]),
    knotsW: Array.from(lattice.knots[2]),
    controlPoints: Array.from(lattice.points),
    outside: lattice.outside && fromOutside(lattice.outside),
  });
}

/** One number for all six sides becomes six. */
export function toOutside(message: LatticeOutside | undefined): Outside | undefined {
  const mode = message?.mode === OutsideMode.FALLOFF ? 'falloff' : message?.mode === OutsideMode.LINEAR ? 'linear' : undefined;
  if (!message || !mode) return undefined;
  const sides = (numbers: readonly number[]): number[] =>
    numbers.length === 1 ? new Array<number>(6).fill(numbers[0]!) : [...numbers];
  return {
    mode, smooth: message.continuity !== OutsideContinuity.C0, widths: sides(message.widths), steps: sides(message.steps),
  };
}

export function fromOutside({ mode, smooth, widths, steps }: Outside): MessageInitShape<typeof LatticeOutsideSchema> {
  return {
    mode: mode === 'falloff' ? OutsideMode.FALLOFF : OutsideMode.LINEAR,
    continuity: smooth ? OutsideContinuity.UNSPECIFIED : OutsideContinuity.C0,
    widths: [...widths],
    steps: [...steps],
  };
}

export function vector(message: Vec3Message | undefined): [number, number, number] {
  return message ? [message.x, message.y, message.z] : [0, 0, 0];
}

export function fromVector([x, y, z]: Vec3): { x: number; y: number; z: number } {
  return { x, y, z };
}

function axes(message: LatticeAxes | undefined): [number, number, number] {
  return message ? [message.u, message.v, message.w] : [0, 0, 0];
}

export function fromAxes([u, v, w]: Vec3): { u: number; v: number; w: number } {
  return { u, v, w };
}
