// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The place of each point of a page's patches on the mesh, before any deformation.
import type { Page } from 'playwright-core';
import type {} from '@src/main'; // window.latticed
import { add, cross, dot, scale, type Basis, type Vec3 } from '@src/lattice/vec';
import type { PatchOrigins, PatchSource } from '@src/surface/patch_source';
import { numbersFrom } from './numbers';

/** A place in a patch. */
export interface Spot {
  readonly patch: number;
  /** Barycentrics in the patch's corners. */
  readonly weights: Vec3;
}

export interface SourcePlaces {
  /** A place for each spot. */
  readonly places: readonly Vec3[];
  /** The same places as the server names them (surface.proto, SurfacePoint). */
  readonly surfacePoints: readonly { readonly face: number; readonly corners: number[]; readonly barycentrics: number[] }[];
  /** Where the spots would be if only the mesh's vertices were moved. */
  readonly flat: (move: (vertex: Vec3) => Vec3) => Vec3[];
  /** How far the patches are from covering each face once; 0 if they do. */
  readonly uncovered: number;
}

const ANSWER_MS = 3000; // then the caller asks again, on another connection: a test may have frozen this one

/** Corners and barycentrics of each patch, from the server. Undefined if it has another topology or does not answer. */
async function originsOf(page: Page, topology: string): Promise<PatchOrigins | undefined> {
  const told = await numbersFrom(page, async ([id, ms]) => {
    const { patches } = window.latticed.scene!.session.surface as unknown as { patches: { source: PatchSource } };
    const late = new Promise<undefined>((resolve) => setTimeout(resolve, ms));
    const origins = await Promise.race([patches.source.origins(id), late]).catch(() => undefined);
    return origins && { few: undefined, lists: { corners: origins.corners, barycentrics: origins.barycentrics } };
  }, [topology, ANSWER_MS] as const);
  return told && { corners: Uint32Array.from(told.lists.corners), barycentrics: told.lists.barycentrics };
}

/**
 * Undefined if the server does not tell.
 * @param spots By patches, ascending.
 * @param obj The mesh, of triangles.
 */
export async function sourcePlaces(
  page: Page, topology: string, spots: readonly Spot[], obj: string,
): Promise<SourcePlaces | undefined> {
  const origins = await originsOf(page, topology);
  if (origins === undefined) return undefined;
  const { corners, barycentrics } = origins;
  const triangles = trianglesOf(obj);
  const covered = triangles.map(() => 0);
  const patches = Array.from({ length: corners.length / 3 }, (_, patch) => {
    const face = Math.floor(corners[3 * patch] / 3);
    const source = [0, 1, 2].map((k) => triangles[face][corners[3 * patch + k] % 3]);
    const weights = [0, 1, 2].map((k) => [...barycentrics.subarray(9 * patch + 3 * k, 9 * patch + 3 * k + 3)] as unknown as Vec3);
    covered[face] += Math.abs(dot(weights[0], cross(weights[1], weights[2]))); // its part of the face's area
    return { face, corners: [...corners.subarray(3 * patch, 3 * patch + 3)], source, weights };
  });
  if (spots.at(-1)!.patch !== patches.length - 1) return undefined; // a newer topology is on its way
  const placed = spots.map(({ patch, weights }) => ({ source: patches[patch].source, weights: blend(patches[patch].weights, weights) }));
  const surfacePoints = spots.map(({ patch, weights }) => {
    const { face, corners: own, weights: inTriangle } = patches[patch];
    return { face, corners: own, barycentrics: [...blend(inTriangle, weights)] };
  });
  const places = placed.map(({ source, weights }) => blend(source, weights));
  const flat = (move: (vertex: Vec3) => Vec3): Vec3[] => placed.map(({ source, weights }) => blend(source.map(move), weights));
  return { places, surfacePoints, flat, uncovered: Math.max(...covered.map((part) => Math.abs(1 - part))) };
}

function blend([a, b, c]: readonly Vec3[], [i, j, k]: readonly number[]): Vec3 {
  return add(scale(a, i), add(scale(b, j), scale(c, k)));
}

/** The triangles of an OBJ file. The server numbers corners along the faces, three per face. */
function trianglesOf(obj: string): Basis[] {
  const numbers = (line: string): number[] => line.split(' ').slice(1).map((word) => parseFloat(word));
  const lines = obj.split('\n');
  const vertices = lines.filter((line) => line.startsWith('v ')).map((line) => numbers(line) as unknown as Vec3);
  return lines.filter((line) => line.startsWith('f ')).map((line) => {
    const corners = numbers(line).map((number) => vertices[number - 1]);
    if (corners.length !== 3) throw new Error(`no triangle: ${line}`);
    return corners as unknown as Basis;
  });
}
