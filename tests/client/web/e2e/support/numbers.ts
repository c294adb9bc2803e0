// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Brings many numbers from a page as bytes. Playwright checks each value of a list by itself, in the page and here, which
// takes a hundred times as long.
import type { Page } from 'playwright-core';

/** What a page tells: a few values, and lists of numbers by name. */
export interface Told<Few, Name extends string> {
  readonly few: Few;
  readonly lists: Readonly<Record<Name, ArrayLike<number>>>;
}

/** Runs `read` in the page, once. NaN and infinities come as they are. Undefined if `read` returns that. */
export async function numbersFrom<Few, Name extends string, Argument>(
  page: Page, read: (argument: Argument) => Promise<Told<Few, Name> | undefined> | Told<Few, Name> | undefined, argument: Argument,
): Promise<{ few: Few; lists: Record<Name, Float64Array> } | undefined> {
  const handle = await page.evaluateHandle(read as (argument: unknown) => unknown, argument as unknown);
  const told = await handle.evaluate((value) => {
    if (value === undefined) return undefined;
    const { few, lists } = value as Told<unknown, string>;
    const inBase64 = (list: ArrayLike<number>): string => {
      const bytes = new Uint8Array(Float64Array.from(list).buffer);
      let text = '';
      for (let i = 0; i < bytes.length; i += 8192) text += String.fromCharCode(...bytes.subarray(i, i + 8192));
      return btoa(text);
    };
    return { few, texts: Object.entries(lists).map(([name, list]) => [name, inBase64(list)] as const) };
  });
  await handle.dispose();
  if (told === undefined) return undefined;
  const lists = Object.fromEntries(told.texts.map(([name, base64]) => [name, new Float64Array(Uint8Array.from(Buffer.from(base64, 'base64')).buffer)]));
  return { few: told.few as Few, lists: lists as Record<Name, Float64Array> };
}

/** Three numbers each. */
export function triples(list: Float64Array): [number, number, number][] {
  return Array.from({ length: list.length / 3 }, (_, i) => [list[3 * i]!, list[3 * i + 1]!, list[3 * i + 2]!]);
}
