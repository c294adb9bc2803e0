// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { create } from '@bufbuild/protobuf';
import { Encoding, NormalMode, ViewOptionsSchema, type ViewOptions } from 'latticed/v1/view_pb';
import type { ViewRequest } from '../session/scene_session';

const NORMALS = { none: NormalMode.NONE, facet: NormalMode.FACET, smooth: NormalMode.SMOOTH } as const;
const ENCODINGS = {
  draco: Encoding.DRACO_POINTS, meshopt: Encoding.MESHOPT, quantised: Encoding.QUANTISED, raw: Encoding.RAW, patches: Encoding.PATCHES,
} as const;

/**
 * An absent field gets the scene's default, but an absent encoding is Draco.
 *
 * @param open The encoding of a view that leaves it open.
 */
export function fromView(view: ViewRequest, open: 'draco' | 'meshopt' = 'draco'): ViewOptions {
  const { encoding = 'draco' } = view;
  return create(ViewOptionsSchema, {
    segments: view.segments ?? 0,
    tolerance: view.tolerance ?? 0,
    maxPoints: BigInt(view.maxPoints ?? 0),
    normals: view.normals ? NORMALS[view.normals] : NormalMode.UNSPECIFIED,
    encoding: ENCODINGS[encoding === 'auto' ? open : encoding],
    positionBits: view.positionBits ?? 0,
    normalBits: view.normalBits ?? 0,
  });
}

/** The decoding for chunks of a view in force. */
export function encodingOf(view: Pick<ViewOptions, 'encoding'>): 'draco' | 'meshopt' | 'quantised' | 'raw' | 'patches' {
  switch (view.encoding) {
    case Encoding.RAW: return 'raw';
    case Encoding.QUANTISED: return 'quantised';
    case Encoding.DRACO_POINTS:
    case Encoding.DRACO_MESH: return 'draco';
    case Encoding.MESHOPT: return 'meshopt';
    case Encoding.PATCHES: return 'patches';
    default: throw new Error(`chunks in an encoding that this viewer does not know: ${view.encoding}`);
  }
}

/** From a view in which every field that has a default is filled in. */
export function toView(view: ViewOptions): Required<ViewRequest> {
  const { segments, tolerance, maxPoints, normals, positionBits, normalBits } = view;
  const name = { [NormalMode.NONE]: 'none', [NormalMode.FACET]: 'facet' } as const;
  return {
    segments, tolerance, maxPoints: Number(maxPoints), normals: name[normals as 1 | 2] ?? 'smooth', encoding: encodingOf(view),
    positionBits, normalBits,
  };
}
