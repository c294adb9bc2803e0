// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// All pixels of the view, and their luminance.
import type { Page } from 'playwright-core';
import type {} from '@src/main'; // window.latticed

export interface Picture {
  readonly width: number;
  readonly height: number;
  /** Red, green, blue, alpha; the lowest row first. */
  readonly pixels: Uint8Array;
}

/** Draws the view, and reads it back. */
export async function picture(of: Page): Promise<Picture> {
  const { width, height, base64 } = await of.evaluate(() => {
    const { viewport } = window.latticed;
    viewport.renderer.render(viewport.scene, viewport.rig.camera);
    const gl = viewport.renderer.getContext();
    const [w, h] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
    const all = new Uint8Array(4 * w * h);
    gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, all);
    let text = '';
    for (let i = 0; i < all.length; i += 8192) text += String.fromCharCode(...all.subarray(i, i + 8192));
    return { width: w, height: h, base64: btoa(text) };
  });
  return { width, height, pixels: Buffer.from(base64, 'base64') };
}

/** Of each value of 8 bits its linear light, 0 to 1. */
const LINEAR = Float64Array.from({ length: 256 }, (_, i) => (i / 255 <= 0.04045 ? i / 255 / 12.92 : ((i / 255 + 0.055) / 1.055) ** 2.4));

/** The relative luminance of a pixel, 0 to 1 (WCAG 2.2). */
export function luminance({ pixels }: Picture, pixel: number): number {
  return 0.2126 * LINEAR[pixels[4 * pixel]!]! + 0.7152 * LINEAR[pixels[4 * pixel + 1]!]! + 0.0722 * LINEAR[pixels[4 * pixel + 2]!]!;
}

/** The contrast of two luminances, 1 to 21 (WCAG 2.2). */
export function contrast(one: number, other: number): number {
  return (Math.max(one, other) + 0.05) / (Math.min(one, other) + 0.05);
}

/** The pixels at which two pictures differ. */
export function differing(one: Picture, other: Picture): number[] {
  const [a, b] = [one, other].map(({ pixels }) => new DataView(pixels.buffer, pixels.byteOffset, pixels.byteLength));
  return Array.from({ length: one.width * one.height }, (_, i) => i).filter((i) => a!.getUint32(4 * i) !== b!.getUint32(4 * i));
}

/** The value below which this share of the values lies. */
export function quantile(values: readonly number[], share: number): number {
  return [...values].sort((a, b) => a - b)[Math.min(Math.floor(share * values.length), values.length - 1)]!;
}
