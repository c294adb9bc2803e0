// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

type Child = Node | string | undefined | false;

/** An element with attributes, `on…` listeners and children; attributes that are false or undefined are left out. */
export function h<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Record<string, unknown> = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === false) continue;
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value as EventListener);
    else element.setAttribute(name, value === true ? '' : String(value));
  }
  element.append(...children.filter((child): child is Node | string => child !== undefined && child !== false));
  return element;
}

const SVG = 'http://www.w3.org/2000/svg';

export function svg(tag: string, attributes: Record<string, string | number>, ...children: Node[]): SVGElement {
  const element = document.createElementNS(SVG, tag);
  setAttributes(element, attributes);
  element.append(...children);
  return element;
}

export function setAttributes(element: Element, attributes: Record<string, string | number>): void {
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
}

/** Enter in a dialog's field takes what was typed, where it is valid, and does what the dialog is for. */
export function onEnter(dialog: HTMLDialogElement, act: () => void): void {
  dialog.addEventListener('keydown', (event) => {
    const field = event.target;
    if (event.key !== 'Enter' || !(field instanceof HTMLInputElement)) return; // of a button it is the press
    event.preventDefault();
    if (field.value === '' || !field.reportValidity()) return;
    field.blur(); // a field changes when it is left
    field.focus();
    act();
  });
}

/** Opens a modal dialog; it is gone from the page once closed. */
export function showDialog(label: string, className: string, ...content: Child[]): HTMLDialogElement {
  const dialog = h('dialog', { class: `dialog ${className}`, 'aria-label': label }, ...content);
  dialog.addEventListener('close', () => dialog.remove());
  dialog.addEventListener('pointerdown', (event) => {
    // A press on the backdrop is one on the dialog itself, outside its box.
    const box = dialog.getBoundingClientRect();
    const inside =
      event.clientX >= box.left &&
      event.clientX <= box.right &&
      event.clientY >= box.top &&
      event.clientY <= box.bottom;
    if (event.target === dialog && !inside) dialog.close();
  });
  document.body.append(dialog);
  dialog.showModal();
  return dialog;
}

/** Gives the focus to the element that is `step` places behind the one that has it, round and round; says which. */
export function moveFocus(elements: readonly HTMLElement[], step: number): HTMLElement | undefined {
  const at = elements.indexOf(document.activeElement as HTMLElement);
  const next = elements[(at + step + elements.length) % elements.length];
  next?.focus();
  return next;
}
