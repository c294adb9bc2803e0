// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Theme } from '../state/settings';

/** Follows the system's preference, or the chosen theme. Calls `apply` at once and after every change. */
export class ThemeSwitch {
  private readonly preference = matchMedia('(prefers-color-scheme: dark)');
  private theme: Theme = 'system';

  constructor(private readonly apply: (dark: boolean) => void) {
    this.preference.addEventListener('change', () => this.set(this.theme));
  }

  get dark(): boolean {
    return this.theme === 'system' ? this.preference.matches : this.theme === 'dark';
  }

  set(theme: Theme): void {
    this.theme = theme;
    document.documentElement.dataset['theme'] = this.dark ? 'dark' : 'light';
    this.apply(this.dark);
  }
}
