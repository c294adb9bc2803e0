// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { GuestRole, SceneShare, SceneShares } from '../../wire/scene_shares';
import { inWords } from '../../wire/words';
import { button, choice, field, segmented } from '../controls';
import { h, showDialog } from '../dom';

const DAY = 24 * 60 * 60; // seconds
const TIMES = { day: 'A day', week: '7 days', month: '30 days', year: 'A year' };
const SECONDS: Record<keyof typeof TIMES, number> = { day: DAY, week: 7 * DAY, month: 30 * DAY, year: 365 * DAY };
const ROLES: Record<GuestRole, string> = { read: 'Watch', edit: 'Edit' };

export interface ShareDialogParts {
  readonly shares: Pick<SceneShares, 'make' | 'list' | 'revoke'>;
  /** The address that opens the scene with the token. */
  linkWith(token: string): string;
  /** Whether the clipboard took the text. */
  copy(text: string): Promise<boolean>;
  /** What the link does not give: of files that are on this computer. */
  readonly remark: string;
}

/** Makes links that open the scene to whoever has them, and shows and revokes those that there are. */
export function showShareDialog({ shares, linkWith, copy, remark }: ShareDialogParts): void {
  let role: GuestRole = 'read';
  let time: keyof typeof TIMES = 'week';
  const who = segmented<GuestRole>({ label: 'They may', get: () => role, set: (chosen) => {
    role = chosen;
    who.refresh();
  } }, ROLES);
  const until = choice<keyof typeof TIMES>({ label: 'For', get: () => time, set: (chosen) => (time = chosen) }, TIMES);
  const link = h('input', { class: 'text', readonly: true, 'aria-label': 'Link', onfocus: () => link.select() });
  const linkField = field('Link', link);
  linkField.hidden = true;
  const note = h('p', { class: 'note', role: 'status' });
  const error = h('p', { class: 'error', role: 'alert' });
  const list = h('ul', { class: 'shares', 'aria-label': 'Links to this scene', 'aria-busy': 'true' });

  /** Shows what failed, in words. */
  const trying = async (act: () => Promise<void>): Promise<void> => {
    error.textContent = '';
    try {
      await act();
    } catch (failure) {
      error.textContent = inWords(failure);
    }
  };
  let [asked, shown] = [0, 0];
  const showList = async (): Promise<void> => {
    const turn = ++asked;
    const all = await shares.list();
    if (turn < shown) return; // a newer list has overtaken this one
    shown = turn;
    list.replaceChildren(...all.map(row));
    list.ariaBusy = 'false';
  };
  const row = ({ id, role: may, until: end, madeBy }: SceneShare): HTMLElement => {
    const words = `${ROLES[may]} until ${end.toLocaleDateString()}${madeBy === '' ? '' : `, by ${madeBy}`}`;
    const revoke = (): void => void trying(async () => {
      await shares.revoke(id);
      await showList();
    });
    return h('li', { 'data-share': id }, h('span', {}, words), button('Revoke', revoke, { 'aria-label': `Revoke: ${words}` }));
  };
  const make = (): void => void trying(async () => {
    maker.disabled = true;
    try {
      link.value = linkWith(await shares.make(role, SECONDS[time]));
      linkField.hidden = false;
      note.textContent = `${(await copy(link.value)) ? 'The link is copied.' : 'Copy this link.'} It is shown only once.${remark}`;
      await showList();
    } finally {
      maker.disabled = false;
    }
  });
  const maker = button('Make a link', make, { class: 'button primary' });
  const dialog = showDialog(
    'Share',
    'share',
    h('h2', {}, 'Share this scene'),
    h('p', { class: 'note' }, 'Whoever has a link opens this scene, and no other, without a token of the server.'),
    who.element,
    until.element,
    linkField,
    note,
    error,
    list,
    h('footer', {}, button('Close', () => dialog.close()), maker),
  );
  void trying(showList);
}
