// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { PatchPlanHeader, PatchPlanPart, PatchRun, PatchSeams } from 'latticed/v1/patches_pb';
import { NormalMode } from 'latticed/v1/view_pb';
import { vector } from '../../wire/lattice_message';
import { numberEdges } from './edge_numbers';
import { octahedralNormal } from './octahedral';
import type { PatchPlan, Seams } from './patch_plan';
import { BytePlanes, decodeDifferences, decodeUses, inflated } from './plan_run';

const MOST_PATCHES = 4096; // in a run
const OCTAHEDRAL_BITS = 16;
const SMOOTH_ONE = 32_767;

/** Reads the parts of a patch plan, in their order, and checks them. What it throws is for people. */
export class PlanReader {
  private readonly corners: Uint32Array;
  private readonly places: Int32Array;
  private readonly cornerNormals: Uint32Array;
  private readonly restNormals: Float32Array;
  private readonly weights: Uint16Array | undefined;
  private readonly slopes: Float32Array | undefined;
  private readonly seams = new SeamLists();
  private patches = 0;
  private vertices = 0;
  private normals = 0;

  constructor(private readonly header: PatchPlanHeader) {
    const count = (value: bigint): number => {
      if (value > 0x7fff_ffffn) throw new Error('The patch plan is too large for a browser.');
      return Number(value);
    };
    const patches = count(header.patchCount);
    this.corners = new Uint32Array(3 * patches);
    this.cornerNormals = new Uint32Array(3 * patches);
    this.places = new Int32Array(3 * count(header.vertexCount));
    this.restNormals = new Float32Array(3 * count(header.normalCount));
    if (!header.weighted) return;
    this.weights = new Uint16Array(count(header.vertexCount));
    if (header.normals !== NormalMode.NONE) this.slopes = new Float32Array(3 * patches);
  }

  /** Reads a whole plan from a stream of parts. */
  static async read(parts: AsyncIterable<PatchPlanPart>): Promise<PatchPlan> {
    let reader: PlanReader | undefined;
    for await (const { part } of parts) {
      if (part.case === 'header') reader = new PlanReader(part.value);
      else if (!reader) throw new Error('The patch plan does not begin with its header.');
      else if (part.case === 'run') await reader.run(part.value);
      else if (part.case === 'seams') reader.seams.take(part.value);
    }
    if (!reader) throw new Error('The patch plan is empty.');
    return reader.finish();
  }

  private async run({ firstPatch, patches, newVertices, newNormals, data }: PatchRun): Promise<void> {
    const { normals: mode, patchCount, vertexCount, normalCount } = this.header;
    if (Number(firstPatch) !== this.patches) throw new Error(`A run of the plan begins at patch ${firstPatch} in place of ${this.patches}.`);
    const isTooLong = patches < 1 || patches > MOST_PATCHES || this.patches + patches > Number(patchCount) ||
      this.vertices + newVertices > Number(vertexCount) || this.normals + newNormals > Number(normalCount);
    if (isTooLong) throw new Error('A run of the plan does not fit its header.');
    const uses = mode === NormalMode.FACET ? patches : mode === NormalMode.SMOOTH ? 3 * patches : 0;
    const parts = mode === NormalMode.FACET ? 2 : 3;
    const ofWeights = (this.weights ? 2 * newVertices : 0) + (this.slopes ? 12 * patches : 0);
    const bytes = 12 * patches + 12 * newVertices + 4 * uses + 2 * parts * newNormals + ofWeights;
    const planes = new BytePlanes(await inflated(data as Uint8Array<ArrayBuffer>, bytes));
    this.corners.set(decodeUses(planes.next(3 * patches, 4), this.vertices, newVertices, 'vertex'), 3 * this.patches);
    const places = planes.next(3 * newVertices, 4);
    for (let axis = 0; axis < 3; ++axis) {
      decodeDifferences(places.subarray(newVertices * axis, newVertices * (axis + 1))).forEach((place, i) => (this.places[3 * (this.vertices + i) + axis] = place));
    }
    const normals = decodeUses(planes.next(uses, 4), this.normals, newNormals, 'rest normal');
    for (let at = 0; uses > 0 && at < 3 * patches; ++at) {
      this.cornerNormals[3 * this.patches + at] = normals[uses === patches ? Math.floor(at / 3) : at]!;
    }
    this.takeRest(planes, newNormals);
    this.weights?.set(planes.next(newVertices, 2), this.vertices);
    if (this.slopes) this.takeSlopes(planes, patches);
    this.patches += patches;
    this.vertices += newVertices;
    this.normals += newNormals;
  }

  private takeRest(planes: BytePlanes, count: number): void {
    if (count === 0) return;
    const isFacet = this.header.normals === NormalMode.FACET;
    const parts = isFacet ? 2 : 3;
    const all = planes.next(parts * count, 2);
    for (let i = 0; i < count; ++i) {
      const numbers = Array.from({ length: parts }, (_, part) => all[count * part + i]!);
      const normal = isFacet ? octahedralNormal(numbers[0]!, numbers[1]!, OCTAHEDRAL_BITS)
        : numbers.map((number) => ((number << 16) >> 16) / SMOOTH_ONE);
      this.restNormals.set(normal, 3 * (this.normals + i));
    }
  }

  private takeSlopes(planes: BytePlanes, patches: number): void {
    const numbers = new Float32Array(planes.next(3 * patches, 4).buffer);
    if (!numbers.every(Number.isFinite)) throw new Error('A weight of the patch plan has no finite slope.');
    numbers.forEach((number, i) => (this.slopes![3 * (this.patches + (i % patches)) + Math.floor(i / patches)] = number));
  }

  private finish(): PatchPlan {
    const { header, corners, places } = this;
    const counts = [[this.patches, header.patchCount, 'patches'], [this.vertices, header.vertexCount, 'vertices'],
      [this.normals, header.normalCount, 'rest normals']] as const;
    for (const [had, all, what] of counts) if (had !== Number(all)) throw new Error(`The patch plan ended after ${had} of ${all} ${what}.`);
    if (header.patchesOutside > header.patchCount) throw new Error('The patch plan has more patches outside the frame than in all.');
    const { edges, before } = numberEdges(corners, this.vertices);
    const edgeCount = before.at(-1)!;
    if (edgeCount !== Number(header.edgeCount)) throw new Error(`The patch plan has ${edgeCount} edges in place of ${header.edgeCount}.`);
    const { outsideLower: lower, outsideUpper: upper } = header;
    return {
      topologyId: header.topologyId, patchCount: this.patches, insideCount: this.patches - Number(header.patchesOutside),
      vertexCount: this.vertices, edgeCount, hasNormals: header.normals !== NormalMode.NONE, origin: vector(header.origin),
      outside: lower && upper ? [vector(lower), vector(upper)] : undefined, curvatureUnit: header.curvatureUnit,
      corners, places, cornerNormals: this.cornerNormals, restNormals: this.restNormals, edges, edgesBefore: before,
      seams: this.seams.finish(this.vertices, edgeCount), weights: this.weights, slopes: this.slopes,
    };
  }
}

/** The arrays of all PatchSeams. */
class SeamLists {
  private readonly lists = {
    ranges: [] as number[], vertices: [] as number[], vertexSeams: [] as number[], outsidePlaces: [] as number[],
    edges: [] as number[], edgeSeams: [] as number[], identityPoints: [] as number[],
  };

  take(part: PatchSeams): void {
    for (const key of Object.keys(this.lists) as (keyof SeamLists['lists'])[]) {
      for (const number of part[key]) this.lists[key].push(number);
    }
  }

  finish(vertexCount: number, edgeCount: number): Seams {
    const { ranges, vertices, vertexSeams, outsidePlaces, edges, edgeSeams, identityPoints } = this.lists;
    const seams = ranges.length / 6;
    const fits = Number.isInteger(seams) && vertexSeams.length === vertices.length && outsidePlaces.length === 3 * vertices.length &&
      edgeSeams.length === edges.length && identityPoints.length % 3 === 0 && [...vertexSeams, ...edgeSeams].every((seam) => seam < seams) &&
      vertices.every((vertex) => vertex < vertexCount) && edges.every((edge) => edge < edgeCount);
    if (!fits) throw new Error('The seams of the patch plan contradict each other.');
    const integers = Uint32Array.from.bind(Uint32Array) as (list: number[]) => Uint32Array;
    return {
      ranges: integers(ranges), vertices: integers(vertices), vertexSeams: integers(vertexSeams),
      outsidePlaces: Int32Array.from(outsidePlaces), edges: integers(edges), edgeSeams: integers(edgeSeams),
      identityPoints: Float64Array.from(identityPoints),
    };
  }
}
