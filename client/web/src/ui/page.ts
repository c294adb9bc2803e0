// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The page's parts and their places: menus above, tools left, the view, properties right, a line below.
import { h } from './dom';

export type Page = ReturnType<typeof buildPage>;

export function buildPage(root: HTMLElement) {
  const page = {
    header: h('header', { class: 'header' }),
    /** The name of the open scene. */
    name: h('span', { class: 'scene-name' }),
    tools: h('div', { class: 'tools' }),
    view: h('main', { class: 'view', id: 'viewport' }),
    side: h('div', { class: 'side' }),
    /** The running action, or a hint. */
    hint: h('span', { class: 'hint', role: 'status' }),
    /** The size of the surface. */
    extent: h('span', { class: 'extent', title: 'Size of the surface along x, y and z' }),
    connection: h('span', { class: 'connection', 'data-state': 'none' }),
    /** Above the view, while something is wrong with the connection. */
    banner: h('div', { class: 'banner', role: 'alert', hidden: true }, h('span')),
    /** Along the view's lower edge. Its elements are stacked, so that none hides another. */
    bottom: h('div', { class: 'bottom' }),
    footer: h('footer', { class: 'footer' }),
  };
  page.footer.append(page.hint, page.extent, page.connection);
  page.view.append(page.banner, page.bottom);
  root.classList.add('app');
  root.replaceChildren(page.header, page.tools, page.view, page.side, page.footer);
  return page;
}
