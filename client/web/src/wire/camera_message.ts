// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { MessageInitShape } from '@bufbuild/protobuf';
import type { Camera, CameraSchema } from 'latticed/v1/event_pb';
import { distance, length } from '../lattice/vec';
import type { CameraPose } from '../state/camera_pose';
import { fromVector, vector } from './lattice_message';

// The ranges of event.proto. What is outside ends the stream.
const MOST = 1e15;
const LEAST_HEIGHT = 1e-15;
const FOV_Y = [0.01, 179] as const;

/** Undefined if the server would refuse it: too far away, or nothing is seen. */
export function fromCamera(pose: CameraPose): MessageInitShape<typeof CameraSchema> | undefined {
  const { position, target, up, projection } = pose;
  const isNear = [...position, ...target, ...up].every((c) => Math.abs(c) <= MOST); // false for NaN
  if (!isNear || distance(position, target) === 0 || length(up) === 0) return undefined;
  const [extent, least, most] = 'fovY' in projection ? [projection.fovY, ...FOV_Y] : [projection.height, LEAST_HEIGHT, MOST];
  if (!(extent >= least && extent <= most)) return undefined;
  return {
    position: fromVector(position), target: fromVector(target), up: fromVector(up),
    projection: 'fovY' in projection ? { case: 'fovY', value: extent } : { case: 'height', value: extent },
  };
}

/** Undefined if it has no projection that this page knows. */
export function toCamera({ position, target, up, projection }: Camera): CameraPose | undefined {
  const place = { position: vector(position), target: vector(target), up: vector(up) };
  switch (projection.case) {
    case 'fovY': return { ...place, projection: { fovY: projection.value } };
    case 'height': return { ...place, projection: { height: projection.value } };
    default: return undefined;
  }
}
