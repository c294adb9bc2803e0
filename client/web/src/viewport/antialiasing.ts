// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

const FINE_PIXEL_RATIO = 2; // from this ratio on, a screen's own pixels make edges smooth enough
const PROGRAMS = /swiftshader|llvmpipe|softpipe|lavapipe|basic render|software/i;

/**
 * How edges become smooth: by the screen, by the GPU in every frame, or by several frames at rest. With software rendering a
 * frame with antialiasing takes three times as long, too long while something moves.
 */
export function antialiasing(): 'screen' | 'every frame' | 'at rest' {
  if (window.devicePixelRatio >= FINE_PIXEL_RATIO) return 'screen';
  return PROGRAMS.test(rendererName()) ? 'at rest' : 'every frame';
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
