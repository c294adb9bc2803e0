// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

const FINE_PIXEL_RATIO = 2; // from which on a screen's own pixels make edges smooth enough
const PROGRAMS = /swiftshader|llvmpipe|softpipe|lavapipe|basic render|software/i;

/** Whether several samples of each pixel are worth what they take: three times a frame where a program draws it. */
export function wantsAntialiasing(): boolean {
  return window.devicePixelRatio < FINE_PIXEL_RATIO && !PROGRAMS.test(rendererName());
}

/** Of the graphics processor, or of the program that draws in place of one; empty where the browser does not tell. */
function rendererName(): string {
  const context = document.createElement('canvas').getContext('webgl2', { antialias: false, depth: false });
  if (context === null) return '';
  const info = context.getExtension('WEBGL_debug_renderer_info');
  const name = String(context.getParameter(info?.UNMASKED_RENDERER_WEBGL ?? context.RENDERER) ?? '');
  context.getExtension('WEBGL_lose_context')?.loseContext(); // or it counts as one of the few that a browser has
  return name;
}
