// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

const FINE_PIXEL_RATIO = 2; // from this ratio on, a screen's own pixels make edges smooth enough
const PROGRAMS = /swiftshader|llvmpipe|softpipe|lavapipe|basic render|software/i;

/** Whether antialiasing is worth its cost. With software rendering a frame takes three times as long. */
export function wantsAntialiasing(): boolean {
  return window.devicePixelRatio < FINE_PIXEL_RATIO && !PROGRAMS.test(rendererName());
}

/** Name of the GPU or of the software renderer; empty if the browser does not tell. */
function rendererName(): string {
  const context = document.createElement('canvas').getContext('webgl2', { antialias: false, depth: false });
  if (context === null) return '';
  const info = context.getExtension('WEBGL_debug_renderer_info');
  const name = String(context.getParameter(info?.UNMASKED_RENDERER_WEBGL ?? context.RENDERER) ?? '');
  context.getExtension('WEBGL_lose_context')?.loseContext(); // frees it: a browser has only a few
  return name;
}
