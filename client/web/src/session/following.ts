// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Presence } from './scene_session';

/**
 * The editor whose camera a follower shows: the one at the end of the chain. If A follows B and B follows C, then A shows
 * C's camera. A chain ends before an editor who is not known yet or shows no camera.
 *
 * A chain may come back to itself. Whoever has the smallest id of that cycle stands, and the others show that camera. All
 * windows find the same one, so it does not matter who began first, or whether it has heard of the cycle yet. Ids are
 * compared by UTF-16 units: for UUIDs, as for all ids in ASCII, that is the order of bytes.
 *
 * @param own The follower's id.
 * @param followed The id of the one whom it follows.
 * @param others The other editors, by id.
 * @returns `own` if the follower is the one who stands, and so has to stop following.
 */
export function leaderOf(own: string, followed: string, others: ReadonlyMap<string, Presence>): string {
  const chain = [own];
  for (let id = followed; ; ) {
    const seenAt = chain.indexOf(id);
    if (seenAt >= 0) return chain.slice(seenAt).reduce((least, each) => (each < least ? each : least));
    chain.push(id);
    const next = others.get(id)?.following ?? '';
    if (next !== own && others.get(next)?.camera === undefined) return id;
    id = next;
  }
}
