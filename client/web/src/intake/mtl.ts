// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Reads the base colours of an MTL file: Kd and map_Kd of every material.

export interface Material {
  /** A CSS colour. */
  readonly colour?: string;
  /** Name of the picture, as in the file. */
  readonly picture?: string;
}

/** Options of map_Kd, and the largest number of values of each. */
const OPTIONS: Record<string, number> = {
  '-blendu': 1, '-blendv': 1, '-boost': 1, '-bm': 1, '-cc': 1, '-clamp': 1, '-imfchan': 1, '-texres': 1, '-type': 1,
  '-mm': 2, '-o': 3, '-s': 3, '-t': 3,
};

export function readMtl(text: string): Map<string, Material> {
  const materials = new Map<string, Material>();
  let name = '';
  for (const line of text.split(/\r\n?|\n/)) {
    const [, word = '', rest = ''] = /^\s*(\S+)\s*(.*?)\s*$/.exec(line) ?? [];
    const extend = (part: Material): unknown => materials.set(name, { ...materials.get(name), ...part });
    if (word === 'newmtl') materials.set((name = rest), {});
    else if (word === 'Kd') extend(ofColour(rest.split(/\s+/).map(Number)));
    else if (word.toLowerCase() === 'map_kd') extend({ picture: withoutOptions(rest) });
  }
  return materials;
}

/** Green and blue default to red. A spectrum gives no colour. */
function ofColour([red = NaN, green = red, blue = red]: readonly number[]): Material {
  const parts = [red, green, blue].map((part) => Math.round(255 * part));
  return parts.some(Number.isNaN) ? {} : { colour: `rgb(${parts.join(' ')})` };
}

/** The file name after the options; it may hold blanks. */
function withoutOptions(text: string): string {
  const words = text.split(/\s+/);
  let at = 0;
  while (at < words.length && words[at] in OPTIONS) {
    const most = OPTIONS[words[at++]];
    const isValue = (word: string | undefined): boolean => most === 1 || !Number.isNaN(Number(word));
    for (let taken = 0; taken < most && at < words.length - 1 && isValue(words[at]); ++taken) ++at;
  }
  return words.slice(at).join(' ');
}
