// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** Waits, for a minute at most, until `holds` returns something true, and returns that. */
export async function until<T>(holds: () => T | Promise<T>, say: () => unknown = () => holds.toString()): Promise<T> {
  for (const end = Date.now() + 60_000; ; await new Promise((resolve) => setTimeout(resolve, 20))) {
    const answer = await holds();
    if (answer) return answer;
    if (Date.now() > end) throw new Error(`timed out waiting for: ${String(await say())}`);
  }
}
