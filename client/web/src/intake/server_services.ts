// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The services of a latticed server.
import { Encoding, NormalMode, type ViewOptions } from 'latticed/v1/view_pb';
import type { Fit } from '../lattice/identity';
import { Lattice } from '../lattice/lattice';
import type { Vec3 } from '../lattice/vec';
import { openSession } from '../session/open_session';
import type { ViewRequest } from '../session/scene_session';
import { DEFAULT_SETTINGS } from '../state/settings';
import type { LatticedServer } from '../wire/latticed_server';
import type { Services } from './services';
import { uploadMesh } from './upload';

export function serverServices(server: LatticedServer): Services {
  return {
    upload: (file, progress, signal) => uploadMesh(server, file, progress, signal),
    async createScene(mesh, lattice, view) {
      const sceneId = randomSceneId();
      const source = lattice instanceof Lattice ? latticeSource(lattice) : fitSource(lattice);
      await server.scenes.createScene({ sceneId, mesh, lattices: [{ source }], defaultView: viewOptions(view) });
      return sceneId;
    },
    async describeScene(sceneId) {
      const { mesh, defaultView } = await server.scenes.getScene({ scene: sceneId });
      return { mesh, view: viewRequest(defaultView) };
    },
    openSession: (sceneId, options) => openSession(server, sceneId, options),
    exportAddress: (sceneId, format) => `${server.origin}/export/${sceneId}.${format}`,
  };
}

/** 128 random bits. */
function randomSceneId(): string {
  return Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, '0')).join('');
}

const vector = ([x, y, z]: Vec3) => ({ x, y, z });
const axes = ([u, v, w]: Vec3) => ({ u, v, w });

function fitSource({ size, degree, padding }: Fit) {
  return { case: 'fit', value: { size: axes(size), degree: axes(degree), padding } } as const;
}

function latticeSource({ frame, size, degree, knots, points }: Lattice) {
  const value = {
    frame: { origin: vector(frame.origin), u: vector(frame.u), v: vector(frame.v), w: vector(frame.w) },
    degree: axes(degree),
    size: axes(size),
    knotsU: [...knots[0]],
    knotsV: [...knots[1]],
    knotsW: [...knots[2]],
    controlPoints: Array.from(points),
  };
  return { case: 'lattice', value } as const;
}

const NORMALS = { smooth: NormalMode.SMOOTH, facet: NormalMode.FACET, none: NormalMode.NONE } as const;
const ENCODINGS = { draco: Encoding.DRACO_POINTS, quantised: Encoding.QUANTISED, raw: Encoding.RAW } as const;

function viewOptions({ segments, normals, encoding, positionBits, normalBits }: ViewRequest) {
  return {
    segments,
    normals: normals === undefined ? undefined : NORMALS[normals],
    encoding: encoding === undefined ? undefined : ENCODINGS[encoding],
    positionBits,
    normalBits,
  };
}

function viewRequest(view: ViewOptions | undefined): Required<ViewRequest> {
  const { view: unset } = DEFAULT_SETTINGS;
  return {
    segments: view?.segments ?? unset.segments,
    normals: keyOf(NORMALS, view?.normals) ?? unset.normals,
    encoding: keyOf(ENCODINGS, view?.encoding) ?? unset.encoding,
    positionBits: view?.positionBits ?? unset.positionBits,
    normalBits: view?.normalBits ?? unset.normalBits,
  };
}

function keyOf<K extends string, V>(record: Record<K, V>, value: V | undefined): K | undefined {
  return (Object.keys(record) as K[]).find((key) => record[key] === value);
}
