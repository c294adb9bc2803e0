// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Axes } from '../../lattice/grid';
import type { Vec3 } from '../../lattice/vec';
import source from '../evaluate_patch.vert';

/** The units of the textures. */
export const TEXTURES = { patches: 0, seams: 1, boxes: 2, normals: 3 } as const;

/** The place of the attribute patchPlace. */
export const PATCH_PLACE = 0;

const NOTHING_DRAWN = `#version 300 es
void main() {}`;

/** Why this context cannot evaluate patches, in words; undefined if it can. */
export function refusalOf(gl: WebGL2RenderingContext): string | undefined {
  const textures = gl.getParameter(gl.MAX_VERTEX_TEXTURE_IMAGE_UNITS) as number;
  if (textures < Object.keys(TEXTURES).length) return `Its vertex shaders have only ${textures} textures.`;
  const precision = gl.getShaderPrecisionFormat(gl.VERTEX_SHADER, gl.HIGH_FLOAT)?.precision ?? 0;
  if (precision < 23) return `Its vertex shaders compute with ${precision} bits.`;
  return undefined;
}

/** Links the evaluation for degrees, and for plans with weights or without; transform feedback takes positions, and then normals. Throws what the driver says. */
export function evaluationProgram(gl: WebGL2RenderingContext, degree: Axes, isWeighted: boolean): WebGLProgram {
  const defines = degree.map((n, axis) => `#define DEGREE_${axis} ${n}\n`).join('') + (isWeighted ? '#define WEIGHTED\n' : '');
  const program = gl.createProgram();
  const shaders = [[gl.VERTEX_SHADER, source.replace('\n', `\n${defines}`)], [gl.FRAGMENT_SHADER, NOTHING_DRAWN]] as const;
  for (const [type, text] of shaders) {
    const shader = gl.createShader(type)!;
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(`The GPU's driver refuses a shader: ${gl.getShaderInfoLog(shader)}`);
    gl.deleteShader(shader); // with the program
  }
  gl.bindAttribLocation(program, PATCH_PLACE, 'patchPlace');
  gl.transformFeedbackVaryings(program, ['point', 'pointNormal'], gl.SEPARATE_ATTRIBS);
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(`The GPU's driver refuses a program: ${gl.getProgramInfoLog(program)}`);
  return program;
}

/** Sets what does not change from call to call. The program is in use afterwards. */
export function setConstants(
  gl: WebGL2RenderingContext, program: WebGLProgram,
  values: { denominator: number; boxSteps: Vec3; conormals: readonly Vec3[]; restEdges: readonly Vec3[]; slopesAt: number },
): void {
  const at = (name: string): WebGLUniformLocation | null => gl.getUniformLocation(program, name);
  gl.useProgram(program);
  for (const [name, unit] of Object.entries(TEXTURES)) gl.uniform1i(at(name), unit);
  gl.uniform1i(at('denominator'), values.denominator);
  gl.uniform3i(at('boxSteps'), ...(values.boxSteps as [number, number, number]));
  gl.uniformMatrix3fv(at('conormals'), false, values.conormals.flat());
  gl.uniformMatrix3fv(at('restEdges'), false, values.restEdges.flat());
  gl.uniform1i(at('slopesAt'), values.slopesAt);
}
