// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

type Child = Node | string | undefined | false;

/** An element with attributes, `on…` listeners and children. Attributes that are false or undefined are left out. */
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

/** Leaves alone what is the same already: a screen reader may say again what is written again. */
export function setAttributes(element: Element, attributes: Record<string, string | number>): void {
  for (const [name, value] of Object.entries(attributes)) {
    if (element.getAttribute(name) !== String(value)) element.setAttribute(name, String(value));
  }
}

/** Like setAttributes. */
export function setText(element: Element, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

/** Whether a key is the dialog's: no other dialog is open above it, and no field or button elsewhere has the focus. */
function isKeyOf(dialog: HTMLDialogElement, { target }: KeyboardEvent): boolean {
  const isAbove = [...document.querySelectorAll('dialog[open]')].at(-1) === dialog;
  const isOfView = target === document.body || target instanceof HTMLCanvasElement;
  return isAbove && (isOfView || dialog.contains(target as Node));
}

/** Calls `act` at Enter while the dialog is open, unless the focus is on a button or link, which Enter presses. */
export function onEnter(dialog: HTMLDialogElement, act: () => void): void {
  const confirm = (event: KeyboardEvent): void => {
    const target = event.target as HTMLElement; // the body, after a click beside the fields
    if (event.key !== 'Enter' || !isKeyOf(dialog, event) || target.closest('button:not([role=radio]), a') !== null) return;
    event.preventDefault();
    act();
  };
  window.addEventListener('keydown', confirm);
  dialog.addEventListener('close', () => window.removeEventListener('keydown', confirm));
}

/** Opens a modal dialog. It is removed from the page when it closes. */
export function showDialog(label: string, className: string, ...content: Child[]): HTMLDialogElement {
  const dialog = h('dialog', { class: `dialog ${className}`, 'aria-label': label }, ...content);
  dialog.addEventListener('close', () => dialog.remove());
  dialog.addEventListener('pointerdown', (event) => {
    // A press on the backdrop is a press on the dialog itself, outside its box.
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

/** Opens a dialog that leaves the page in sight and in use. Esc closes it, and it is removed then. */
export function showBeside(label: string, className: string, ...content: Child[]): HTMLDialogElement {
  const dialog = h('dialog', { class: `dialog beside ${className}`, 'aria-label': label }, ...content);
  const escape = (event: KeyboardEvent): void => {
    if (event.key === 'Escape' && isKeyOf(dialog, event)) dialog.close();
  };
  window.addEventListener('keydown', escape);
  dialog.addEventListener('close', () => {
    window.removeEventListener('keydown', escape);
    dialog.remove();
  });
  document.body.append(dialog);
  dialog.show();
  return dialog;
}

/** Moves the focus `step` elements on, wrapping around, from the one that has it. Returns the new one. */
export function moveFocus(elements: readonly HTMLElement[], step: number): HTMLElement | undefined {
  const at = elements.indexOf(document.activeElement as HTMLElement);
  const next = elements[(at + step + elements.length) % elements.length];
  next?.focus();
  return next;
}
