// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A person at a scene, as others see them: a name and a colour.

export interface Person {
  /** May be empty. */
  readonly name: string;
  /** 0xRRGGBB. */
  readonly colour: number;
}

/** What one has chosen for oneself. */
export interface You {
  /** Empty: the name of the colour. */
  readonly name: string;
  /** 0xRRGGBB; random: each window has its own. */
  readonly colour: number | 'random';
}

/** Easy to tell apart on light and on dark, and not used by the page itself. */
export const PERSON_COLOURS: readonly Person[] = [
  { name: 'Plum', colour: 0xd65cff },
  { name: 'Teal', colour: 0x2ec4b6 },
  { name: 'Rose', colour: 0xff5c8a },
  { name: 'Iris', colour: 0x5c7cff },
  { name: 'Fern', colour: 0x9bd13c },
  { name: 'Honey', colour: 0xffd23f },
  { name: 'Sky', colour: 0x00b4ff },
  { name: 'Coral', colour: 0xff7a45 },
];

export function randomPerson(): Person {
  return PERSON_COLOURS[Math.floor(Math.random() * PERSON_COLOURS.length)];
}

/** The person that others see. `random` stands in for what is not chosen. */
export function personOf(you: You, random: Person): Person {
  const colour = you.colour === 'random' ? random.colour : you.colour;
  const named = PERSON_COLOURS.find((person) => person.colour === colour) ?? random;
  return { name: you.name || named.name, colour };
}

/** The beginning of a name, with at most `most` code points, as the server counts them. */
export function clipped(name: string, most: number): string {
  return [...name].slice(0, most).join('');
}

/** A person's colour for CSS. */
export function cssColour({ colour }: Person): string {
  return `#${colour.toString(16).padStart(6, '0')}`;
}
