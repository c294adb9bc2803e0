// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** A context whose calls succeed and draw nothing: for what the page computes beside the GPU. */
export function silentGl(): WebGL2RenderingContext {
  const answers: Record<string, unknown> = { isContextLost: () => false, getParameter: () => 1 << 14 };
  return new Proxy({}, { get: (_, name) => answers[name as string] ?? (() => ({})) }) as WebGL2RenderingContext;
}
