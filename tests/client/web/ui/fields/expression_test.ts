// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { evaluateExpression } from '@src/ui/fields/expression';

test('expressions have the values of school, and an operator with = changes the value that is there', () => {
  const values: readonly (readonly [string, number])[] = [
    ['7', 7], ['-2.5', -2.5], ['.5', 0.5], ['0,5', 0.5], ['1e-3', 1e-3], ['1/2', 0.5], ['pi*2', 2 * Math.PI], ['π', Math.PI],
    ['1 + 2 * 3', 7], ['(1 + 2) * 3', 9], ['8 / 4 / 2', 1], ['10 - 4 - 3', 3], ['2 ^ 3 ^ 2', 512], ['-2 ^ 2', -4],
    ['2 ^ -1', 0.5], ['2 - -3', 5], ['+4', 4], ['+=0.1', 10.1], ['-= 1/2', 9.5], ['*=-2', -20], ['/= 4', 2.5],
  ];
  for (const [text, value] of values) assert.deepEqual(evaluateExpression(text, 10), { value }, text);
});

test('what is no expression is refused in words', () => {
  const refusals: readonly (readonly [string, string])[] = [
    ['', 'A number is missing.'], ['1 +', 'A number is missing.'], ['+=', 'A number is missing.'],
    ['(1 + 2', 'A closing bracket is missing.'], ['1 2', '“2” is not understood here.'], ['2 * width', '“width” is not understood here.'],
    ['pie', '“pie” is not understood here.'], ['1)', '“)” is not understood here.'], ['==3', '“=” is not understood here.'],
    ['1/0', 'This has no finite value.'], ['(-1) ^ .5', 'This has no finite value.'], ['/=0', 'This has no finite value.'],
  ];
  for (const [text, why] of refusals) assert.deepEqual(evaluateExpression(text, 10), { why }, text);
});
