// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Below the sentence that a token is wanted: the field that takes it. The text around it in an address may be pasted too.
import { h } from '../dom';

export class TokenForm {
  private readonly field = h('input', {
    type: 'password', autocomplete: 'off', required: true, 'aria-label': 'New token', placeholder: 'New token, or the link with it',
  });
  readonly element = h('form', { class: 'token-form', hidden: true, onsubmit: (event: Event) => this.take(event) },
    this.field, h('button', {}, 'Go on'));

  /** @param taken Called with the token that a person has entered. */
  constructor(private readonly taken: (token: string) => void) {}

  show(on: boolean): void {
    this.element.hidden = !on;
  }

  private take(event: Event): void {
    event.preventDefault();
    const text = this.field.value.trim();
    this.field.value = '';
    if (text !== '') this.taken(tokenIn(text) ?? text);
  }
}

/** The token of an address or of its fragment, after #token=. */
export function tokenIn(address: string): string | undefined {
  return new URLSearchParams(address.slice(address.indexOf('#') + 1)).get('token') ?? undefined;
}
