// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Tokens of callers, one for each role.
import { createHash } from 'node:crypto';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';

export const TOKENS = { edit: 'let-me-edit', read: 'let-me-look' } as const;

/** Writes a file of the tokens into a folder. Returns the options of a server that asks for them. */
export function tokenOptions(folder: string): string[] {
  const file = join(folder, 'tokens');
  const lines = Object.entries(TOKENS).map(([role, token]) => `${createHash('sha256').update(token).digest('hex')} ${role} ${role}`);
  writeFileSync(file, lines.join('\n'));
  return ['--token-file', file];
}
