// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { LatticeStructure } from '../../lattice/grid';
import { OutsideMap } from '../../lattice/outside';
import { ADAPTIVE_WHOLE } from '../../surface/patches/adaptive_pattern';
import { BoxPolynomials } from '../box_polynomials';
import { conormals } from '../conormals';
import { evaluationProgram, PATCH_PLACE, setConstants, TEXTURES } from './evaluation_program';
import { NumberTexture } from './number_texture';
import type { PatchPlan } from '../plan/patch_plan';
import { PatchTables } from './patch_tables';
import { PointBuffers } from './point_buffers';
import { SeamStates } from '../seam_states';

/** What PatchEvaluator.update has changed. */
export interface EvaluatorChange {
  /** Boxes whose polynomials are new, ascending. */
  readonly boxes: readonly number[];
  /** Whether a seam was attached or torn: points on it may have other bits, in any box. */
  readonly seams: boolean;
}

/**
 * Evaluates points of the patches of one plan on the GPU, by transform feedback. Its own calls change what the context has
 * bound: whoever shares the context must set its state anew.
 */
export class PatchEvaluator {
  readonly buffers: PointBuffers;
  readonly boxes: BoxPolynomials;
  private readonly outside: OutsideMap;
  private readonly tables: PatchTables;
  private readonly seams: SeamStates;
  private readonly program: WebGLProgram;
  private readonly feedback: WebGLTransformFeedback;
  private readonly vertexArray: WebGLVertexArrayObject;
  private readonly textures: Record<keyof typeof TEXTURES, NumberTexture>;

  /** Throws, in words, if the GPU or its driver cannot do it. */
  constructor(private readonly gl: WebGL2RenderingContext, plan: PatchPlan, structure: LatticeStructure) {
    this.outside = new OutsideMap(structure);
    const { continued } = this.outside;
    this.boxes = new BoxPolynomials(continued, plan.origin, plan.outside);
    this.tables = new PatchTables(plan, this.boxes.steps, (axis, span) => this.boxes.isSmoothBelow(axis, span));
    this.seams = new SeamStates(plan.seams, continued.size);
    this.program = evaluationProgram(gl, continued.degree, plan.weights !== undefined);
    setConstants(gl, this.program, {
      denominator: ADAPTIVE_WHOLE, boxSteps: this.boxes.steps, conormals: conormals(continued), restEdges: this.boxes.restEdges,
      slopesAt: plan.restNormals.length / 3 });
    this.textures = {
      patches: new NumberTexture(gl, TEXTURES.patches, this.tables.patches),
      seams: new NumberTexture(gl, TEXTURES.seams, this.tables.seams),
      boxes: new NumberTexture(gl, TEXTURES.boxes, this.boxes.numbers),
      normals: new NumberTexture(gl, TEXTURES.normals, restNormals(plan)),
    };
    this.buffers = new PointBuffers(gl);
    this.feedback = gl.createTransformFeedback();
    this.vertexArray = gl.createVertexArray();
    gl.bindVertexArray(this.vertexArray);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers.places);
    gl.enableVertexAttribArray(PATCH_PLACE);
    gl.vertexAttribIPointer(PATCH_PLACE, 2, gl.UNSIGNED_INT, 0, 0);
    gl.bindVertexArray(null);
    gl.bindBuffer(gl.ARRAY_BUFFER, null);
  }

  /** These control points have moved, all if absent. The next `update` takes them into account. */
  moved(indices?: Iterable<number>): void {
    this.boxes.moved(indices && this.outside.reached(indices));
  }

  /** The box of a patch's own spans. */
  boxOf(patch: number): number {
    return this.tables.boxOf(patch);
  }

  /** Takes the control points and the scene's strength: computes the boxes that moved ones affect, and which seams are attached. */
  update(given: Float64Array, strength = 1): EvaluatorChange {
    const points = this.outside.points(given, strength);
    const changed = this.boxes.update(points);
    const { perBox, numbers } = this.boxes;
    for (let i = 0; i < changed.length;) {
      let end = i + 1;
      while (end < changed.length && changed[end] === changed[end - 1]! + 1) ++end;
      this.textures.boxes.write(numbers, perBox * changed[i]!, perBox * (changed[end - 1]! + 1));
      i = end;
    }
    const seams = changed.length > 0 && this.seams.update(points);
    if (seams) {
      this.tables.attach(this.seams.isAttached);
      this.textures.seams.write(this.tables.seams);
    }
    return { boxes: changed, seams };
  }

  /** Evaluates `count` points from `first`, whose places are in the buffers. Does not wait for the GPU. */
  evaluate(first: number, count: number): void {
    if (count === 0) return;
    const { gl, buffers } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, null); // whoever drew the points may have left them bound, and then they cannot be written
    gl.useProgram(this.program);
    for (const texture of Object.values(this.textures)) texture.bind();
    gl.bindVertexArray(this.vertexArray);
    gl.bindTransformFeedback(gl.TRANSFORM_FEEDBACK, this.feedback);
    [buffers.positions, buffers.normals].forEach((buffer, index) =>
      gl.bindBufferRange(gl.TRANSFORM_FEEDBACK_BUFFER, index, buffer, 12 * first, 12 * count));
    gl.enable(gl.RASTERIZER_DISCARD);
    gl.beginTransformFeedback(gl.POINTS);
    gl.drawArrays(gl.POINTS, first, count);
    gl.endTransformFeedback();
    gl.disable(gl.RASTERIZER_DISCARD);
    for (const index of [0, 1]) gl.bindBufferBase(gl.TRANSFORM_FEEDBACK_BUFFER, index, null); // else they may not be drawn from
    gl.bindTransformFeedback(gl.TRANSFORM_FEEDBACK, null);
    gl.bindVertexArray(null);
  }

  dispose(): void {
    const { gl } = this;
    for (const texture of Object.values(this.textures)) texture.dispose();
    this.buffers.dispose();
    gl.deleteTransformFeedback(this.feedback);
    gl.deleteVertexArray(this.vertexArray);
    gl.deleteProgram(this.program);
  }
}

/** Four numbers a texel: the rest normals, then the slopes of weights. A plan without normals has texels of zeros. */
function restNormals({ restNormals: normals, slopes, weights, patchCount }: PatchPlan): Float32Array {
  const texels = new Float32Array(4 * Math.max(1, normals.length / 3 + (weights ? patchCount : 0)));
  [normals, slopes ?? []].reduce((first, vectors) => {
    for (let i = 0; 3 * i < vectors.length; ++i) for (let axis = 0; axis < 3; ++axis) texels[4 * (first + i) + axis] = vectors[3 * i + axis]!;
    return first + vectors.length / 3;
  }, 0);
  return texels;
}
