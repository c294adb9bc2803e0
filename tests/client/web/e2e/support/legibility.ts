// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Whether people can read what a page shows: the contrast of texts and icons (WCAG 2.2, 1.4.3 and 1.4.11), and their place.
import type { Page } from 'playwright-core';

/**
 * What is hard to read, in words. Texts need 4.5 : 1, large ones and icons 3 : 1. What is disabled or hidden does not count, as in
 * WCAG, nor what lies behind a modal dialog, which is inert. Where no element has a background, it is `back`, the view's.
 * Whatever can be pressed must lie inside the window.
 */
export function illegible(page: Page, back: string): Promise<string[]> {
  return page.evaluate((viewBack) => {
    type Colour = [number, number, number, number];
    const pixel = new OffscreenCanvas(1, 1).getContext('2d', { willReadFrequently: true })!;
    const parsed = (css: string): Colour => {
      pixel.clearRect(0, 0, 1, 1);
      pixel.fillStyle = css;
      pixel.fillRect(0, 0, 1, 1);
      const [r, g, b, a] = pixel.getImageData(0, 0, 1, 1).data;
      return [r!, g!, b!, a! / 255];
    };
    const over = (above: Colour, below: Colour): Colour =>
      [0, 1, 2].map((i) => above[i]! * above[3] + below[i]! * (1 - above[3])).concat(1) as Colour;
    const luminance = (colour: Colour): number => {
      const [r, g, b] = colour.map((c) => (c / 255 <= 0.04045 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4));
      return 0.2126 * r! + 0.7152 * g! + 0.0722 * b!;
    };
    const contrast = (a: Colour, b: Colour): number => {
      const [x, y] = [luminance(a), luminance(b)];
      return (Math.max(x, y) + 0.05) / (Math.min(x, y) + 0.05);
    };
    const backOf = (element: Element | null): Colour => {
      if (element === null) return parsed(viewBack);
      const own = parsed(getComputedStyle(element).backgroundColor);
      return own[3] === 1 ? own : over(own, backOf(element.parentElement));
    };
    const opacityOf = (element: Element | null): number =>
      element === null ? 1 : Number(getComputedStyle(element).opacity) * opacityOf(element.parentElement);
    const found = new Set<string>();
    const check = (element: Element, what: string, needed: number): void => {
      const behind = backOf(element);
      const ink = parsed(getComputedStyle(element).color);
      const seen = over([ink[0], ink[1], ink[2], ink[3] * opacityOf(element)], behind);
      const ratio = contrast(seen, behind);
      if (ratio < needed) found.add(`${what}: ${ratio.toFixed(2)} of ${needed}`);
    };
    const isShown = (element: Element): boolean => {
      const { width, height } = element.getBoundingClientRect();
      return width > 1 && height > 1 && element.checkVisibility({ visibilityProperty: true }) &&
        element.closest(':disabled, [aria-disabled=true], .visually-hidden') === null;
    };
    const root = document.querySelector('dialog:modal') ?? document.body;
    const texts = document.createTreeWalker(root, NodeFilter.SHOW_TEXT);
    while (texts.nextNode()) {
      const element = texts.currentNode.parentElement!;
      const text = texts.currentNode.textContent!.trim();
      if (text === '' || !isShown(element)) continue;
      const { fontSize, fontWeight } = getComputedStyle(element);
      const isLarge = parseFloat(fontSize) >= 24 || (parseFloat(fontSize) >= 18.66 && Number(fontWeight) >= 700);
      check(element, `"${text.slice(0, 40)}" in ${element.tagName.toLowerCase()}.${element.className}`, isLarge ? 3 : 4.5);
    }
    for (const icon of root.querySelectorAll('button svg'))
      if (isShown(icon)) check(icon, `icon of ${icon.closest('button')!.title || icon.closest('button')!.textContent}`, 3);
    for (const control of root.querySelectorAll('button, input, select, a')) {
      const { left, right } = control.getBoundingClientRect();
      const name = control.getAttribute('aria-label') ?? control.getAttribute('title') ?? control.textContent;
      if (isShown(control) && (left < -1 || right > innerWidth + 1)) found.add(`"${name}" from ${left} to ${right} of ${innerWidth}`);
    }
    return [...found];
  }, back);
}
