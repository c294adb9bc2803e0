// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A random lattice, and the plan of patches in and beside it, as a server would send it: written from patches.proto, without the
// code under test.
import { create } from '@bufbuild/protobuf';
import { PatchPlanPartSchema, type PatchPlanPart } from 'latticed/v1/patches_pb';
import { NormalMode } from 'latticed/v1/view_pb';
import type { Axes } from '@src/lattice/grid';
import { identityPoints } from '@src/lattice/identity';
import { Lattice, type Vec3 } from '@src/lattice/lattice';
import { RandomNumbers } from './random_numbers';

export const UNIT = 65_535;
const MOVE = 0.5; // of control points; the lattice is some 5 long

/** One patch, by the numbers of vertices. */
interface Patch {
  readonly corners: readonly [number, number, number];
  readonly isOutside: boolean;
}

export interface RandomPlan {
  readonly lattice: Lattice;
  readonly identity: Float64Array;
  readonly parts: PatchPlanPart[];
  readonly origin: Vec3;
  readonly outside: readonly [Vec3, Vec3];
  readonly patches: readonly Patch[];
  /** Places of vertices in the lattice, or in the outside box for those of patches outside alone. */
  readonly places: readonly Vec3[];
  /** Places in the outside box, of the vertices on the seam too. */
  readonly outsidePlaces: ReadonlyMap<number, Vec3>;
  readonly edgeCount: number;
  /** Rest normals of a patch's corners, as they were rounded. */
  readonly restNormals: readonly (readonly [Vec3, Vec3, Vec3])[];
  /** Of vertices, 0 to 65535; empty without weights. */
  readonly weights: readonly number[];
  /** Of the weight, of patches; of any direction, as they were rounded. Empty without weights or without normals. */
  readonly slopes: readonly Vec3[];
}

/**
 * A curtain through the lattice: rows along axis 0 and 1, folded along axis 2 so that each patch lies in one box and many edges lie
 * on knot planes. The patches at the lower face of axis 0 go on outside, behind a seam that all control points of this face hold.
 */
export async function randomPlan(seed: number, degree: Axes, mode: NormalMode, isWeighted = false): Promise<RandomPlan> {
  const random = new RandomNumbers(seed);
  const size = degree.map((n) => n + 3) as [number, number, number];
  const knots = degree.map((n, axis) => randomKnots(random, n, size[axis])) as unknown as Lattice['knots'];
  const [v, w] = [[0.2, 0.1, 3], [-0.4, -5, 0.2]] as const;
  const frame = { origin: [10, -3, 2], u: [4, 0.3, 0], ...(seed % 2 === 0 ? { v, w } : { v: w, w: v }) } as const; // odd: left-handed
  const atRest = new Lattice(frame, degree, size, knots, new Float64Array());
  const identity = identityPoints(atRest);
  const points = identity.map((x, at) => ((at / 3) % size[0] < 1 ? x : x + MOVE * (random.next() - 0.5))); // the face is held
  const lattice = new Lattice(frame, degree, size, knots, points);

  const spans = knots.map((list, axis) => new Set(list.subarray(degree[axis], size[axis] + 1)).size - 1) as [number, number, number];
  const rows = 2 * spans[0] + 1;
  const columns = 2 * spans[1] + 1;
  const places: Vec3[] = [];
  const within = (): number => 1 + random.below(UNIT - 1);
  const stop = (i: number): number => (i % 2 === 0 ? UNIT * (i / 2) : UNIT * Math.floor(i / 2) + within());
  const rowPlaces = Array.from({ length: rows }, (_, i) => stop(i));
  for (let j = 0; j < columns; ++j) {
    const along = stop(j);
    for (let i = 0; i < rows; ++i) {
      const knot = UNIT * (i % 4 === 0 ? 0 : 1); // rows alternate between knot plane 0, inside, knot plane 1, inside
      places.push([rowPlaces[i], along, i % 2 === 0 ? knot : within()]);
    }
  }
  const at = (i: number, j: number): number => i + rows * j;
  const patches: Patch[] = [];
  const turned = (...corners: [number, number, number]): [number, number, number] => {
    const first = random.below(3);
    return [corners[first], corners[(first + 1) % 3], corners[(first + 2) % 3]];
  };
  for (let j = 0; j + 1 < columns; ++j) {
    for (let i = 0; i + 1 < rows; ++i) {
      patches.push({ corners: turned(at(i, j), at(i + 1, j), at(i, j + 1)), isOutside: false });
      patches.push({ corners: turned(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)), isOutside: false });
    }
  }
  const outside: [Vec3, Vec3] = [[0, -9, -1], [15, -2, 6]];
  const outsidePlaces = new Map<number, Vec3>();
  const outsidePlace = (): Vec3 => [random.below(UNIT + 1), random.below(UNIT + 1), random.below(UNIT + 1)];
  for (let j = 0; j < columns; ++j) {
    const world = worldOf(lattice, places[at(0, j)]);
    outsidePlaces.set(at(0, j), [0, 1, 2].map((axis) =>
      Math.round((UNIT * (world[axis] - outside[0][axis])) / (outside[1][axis] - outside[0][axis]))) as unknown as Vec3);
  }
  for (let j = 0; j + 1 < columns; ++j) {
    const far = places.push(outsidePlace()) - 1;
    outsidePlaces.set(far, places[far]);
    patches.push({ corners: turned(at(0, j), at(0, j + 1), far), isOutside: true });
  }
  return { lattice, identity, outside, origin: [11, -4, 3], ...(await written({
    random, lattice, identity, patches, places, outsidePlaces, mode, outside, weighing: isWeighted ? new RandomNumbers(seed + 500) : undefined,
    seamed: Array.from({ length: columns }, (_, j) => at(0, j)) })) };
}

/** The world position at rest of a place in the lattice. */
export function worldOf(lattice: Lattice, place: Vec3): Vec3 {
  const { frame } = lattice;
  const shares = place.map((p, axis) => {
    const distinct = [...new Set(lattice.knots[axis].subarray(lattice.degree[axis], lattice.size[axis] + 1))];
    const span = Math.min(Math.floor(p / UNIT), distinct.length - 2);
    const t = distinct[span] + ((distinct[span + 1] - distinct[span]) * (p - UNIT * span)) / UNIT;
    return (t - distinct[0]) / (distinct.at(-1)! - distinct[0]);
  });
  return [0, 1, 2].map((a) => frame.origin[a] + shares[0] * frame.u[a] + shares[1] * frame.v[a] + shares[2] * frame.w[a]) as unknown as Vec3;
}

/** Clamped; a knot inside has full multiplicity if there is room. */
function randomKnots(random: RandomNumbers, degree: number, size: number): Float64Array {
  const inner: number[] = [];
  while (inner.length < size - degree - 1) inner.push(...Array<number>(inner.length === 0 && degree < 3 ? degree : 1).fill(0.2 + 0.6 * random.next()));
  inner.length = size - degree - 1;
  const ends = (value: number): number[] => Array<number>(degree + 1).fill(value);
  return Float64Array.from([...ends(0), ...inner.sort((a, b) => a - b), ...ends(1.5)]);
}

interface ToWrite extends Pick<RandomPlan, 'lattice' | 'identity' | 'patches' | 'places' | 'outsidePlaces' | 'outside'> {
  readonly random: RandomNumbers;
  readonly mode: NormalMode;
  /** Makes weights and slopes; absent: there are none. */
  readonly weighing: RandomNumbers | undefined;
  readonly seamed: readonly number[];
}

async function written(all: ToWrite): Promise<Pick<RandomPlan, 'parts' | 'edgeCount' | 'restNormals' | 'patches' | 'places' | 'outsidePlaces' | 'weights' | 'slopes'>> {
  const { patches, places, mode, lattice, weighing } = all;
  const weights: number[] = [];
  const slopes: Vec3[] = [];
  const vertexOf = new Map<number, number>();
  const newPlaces: Vec3[] = [];
  const [normals, coded] = randomNormals(all.random, patches.length, mode);
  const runs: PatchPlanPart[] = [];
  const inside = patches.filter(({ isOutside }) => !isOutside).length;
  const bounds = [0, Math.floor(inside / 2), inside, patches.length];
  for (let run = 0; run < 3; ++run) {
    const own = patches.slice(bounds[run], bounds[run + 1]);
    const before = newPlaces.length;
    const codes = own.flatMap(({ corners }) => corners.map((corner) => {
      const known = vertexOf.get(corner);
      if (known !== undefined) return newPlaces.length - known;
      vertexOf.set(corner, newPlaces.length);
      newPlaces.push(places[corner]);
      return 0;
    }));
    const news = newPlaces.slice(before);
    const newWeights = weighing ? news.map(() => weighing.below(UNIT + 1)) : [];
    const newSlopes = weighing && mode !== NormalMode.NONE
      ? own.map(() => [0, 1, 2].map(() => Math.fround(0.6 * weighing.next() - 0.3)) as unknown as Vec3) : [];
    weights.push(...newWeights);
    slopes.push(...newSlopes);
    const perPatch = mode === NormalMode.FACET ? 1 : mode === NormalMode.SMOOTH ? 3 : 0;
    const rest = coded.slice(perPatch * bounds[run], perPatch * bounds[run + 1]);
    const numbers = [
      planes(codes, 4), planes([0, 1, 2].flatMap((axis) => differences(news.map((place) => place[axis]))), 4), planes(rest.map(() => 0), 4),
      planes([0, 1, 2].slice(0, perPatch === 1 ? 2 : 3).flatMap((part) => rest.map((code) => code[part])), 2),
      planes(newWeights, 2), planes([0, 1, 2].flatMap((axis) => newSlopes.map((slope) => bitsOf(slope[axis]))), 4)];
    runs.push(create(PatchPlanPartSchema, { part: { case: 'run', value: {
      firstPatch: BigInt(bounds[run]), patches: own.length, newVertices: news.length, newNormals: rest.length,
      data: await deflated(Uint8Array.from(numbers.flat())) } } }));
  }
  const renamed = patches.map(({ corners, isOutside }) => ({ corners: corners.map((c) => vertexOf.get(c)!) as unknown as Patch['corners'], isOutside }));
  const edges = new Map<string, number>();
  for (const { corners } of renamed) for (const [e, p] of corners.entries()) {
    const key = edgeKey(p, corners[(e + 1) % 3]);
    if (!edges.has(key)) edges.set(key, edges.size);
  }
  const outsidePlaces = new Map([...all.outsidePlaces].map(([vertex, place]) => [vertexOf.get(vertex)!, place]));
  const seamed = all.seamed.map((vertex) => vertexOf.get(vertex)!);
  const seamEdges = seamed.slice(1).map((vertex, i) => edges.get(edgeKey(vertex, seamed[i]))!).sort((a, b) => a - b);
  const sorted = [...seamed].sort((a, b) => a - b);
  const vec = ([x, y, z]: Vec3): { x: number; y: number; z: number } => ({ x, y, z });
  const header = create(PatchPlanPartSchema, { part: { case: 'header', value: {
    topologyId: 'random', normals: mode, patchCount: BigInt(patches.length), patchesOutside: BigInt(patches.length - inside),
    vertexCount: BigInt(newPlaces.length), edgeCount: BigInt(edges.size), normalCount: BigInt(coded.length), weighted: weighing !== undefined, origin: vec([11, -4, 3]),
    outsideLower: vec(all.outside[0]), outsideUpper: vec(all.outside[1]), curvatureUnit: 2 ** -30 } } });
  const seams = create(PatchPlanPartSchema, { part: { case: 'seams', value: {
    ranges: [0, 0, 0, lattice.size[1] - 1, 0, lattice.size[2] - 1], vertices: sorted, vertexSeams: sorted.map(() => 0),
    outsidePlaces: sorted.flatMap((vertex) => [...outsidePlaces.get(vertex)!]), edges: seamEdges, edgeSeams: seamEdges.map(() => 0),
    identityPoints: [...all.identity] } } });
  return { parts: [header, ...runs, seams], edgeCount: edges.size, restNormals: normals, patches: renamed, places: newPlaces, outsidePlaces, weights, slopes };
}

function bitsOf(float: number): number {
  return new Uint32Array(Float32Array.of(float).buffer)[0];
}

export function edgeKey(p: number, q: number): string {
  return `${Math.min(p, q)} ${Math.max(p, q)}`;
}

/** Normals of the corners of each patch, and how they are written. */
function randomNormals(random: RandomNumbers, patches: number, mode: NormalMode): [[Vec3, Vec3, Vec3][], number[][]] {
  const normals: [Vec3, Vec3, Vec3][] = [];
  const coded: number[][] = [];
  for (let patch = 0; patch < patches; ++patch) {
    if (mode === NormalMode.FACET) {
      const code = [1 + random.below(UNIT - 1), 1 + random.below(UNIT - 1)];
      let [y, z] = code.map((c) => (2 * c) / (UNIT - 1) - 1);
      const x = 1 - Math.abs(y) - Math.abs(z);
      if (x < 0) [y, z] = [y + (y < 0 ? -x : x), z + (z < 0 ? -x : x)];
      const length = Math.sqrt(x * x + y * y + z * z);
      const normal: Vec3 = [x / length, y / length, z / length];
      normals.push([normal, normal, normal]);
      coded.push(code);
    } else if (mode === NormalMode.SMOOTH) {
      // Close to each other, so that no sum of them is near zero.
      const corners = [0, 1, 2].map(() => [20_000 + random.below(2000), random.below(9000) - 15_000, random.below(9000)]);
      normals.push(corners.map((corner) => corner.map((c) => c / 32_767)) as unknown as [Vec3, Vec3, Vec3]);
      coded.push(...corners.map((corner) => corner.map((c) => c & 0xffff)));
    }
  }
  return [normals, coded];
}

function differences(numbers: readonly number[]): number[] {
  return numbers.map((number, i) => {
    const d = number - (i === 0 ? 0 : numbers[i - 1]);
    return d >= 0 ? 2 * d : -2 * d - 1;
  });
}

function planes(numbers: readonly number[], width: number): number[] {
  return Array.from({ length: width }, (_, byte) => numbers.map((number) => Math.floor(number / 256 ** byte) % 256)).flat();
}

async function deflated(bytes: Uint8Array<ArrayBuffer>): Promise<Uint8Array<ArrayBuffer>> {
  const stream = new Blob([bytes]).stream().pipeThrough(new CompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
