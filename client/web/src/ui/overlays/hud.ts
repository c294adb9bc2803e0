// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The line of measurements: how fast the surface follows, and what that costs.
import type { UpdateInfo } from '../../session/scene_session';
import { lengthsInWords, type Units } from '../../state/units';
import type { Folds } from '../../wire/fold_message';
import { bytes } from '../../wire/words';
import { h } from '../dom';

const WINDOW_MS = 1000; // the time over which updates/s are counted
const LATENCY = 'Median time from an edit until a frame that shows it is drawn';
const CERTIFIED = 'The largest distance between the triangles and the exact surface, at any point; – where it is not known';
const FOLDS = 'Knot boxes around the mesh that fold over; 0 is proved, +? is not decided';
const LATENCIES = 31; // the number of newest latencies whose median is shown

export class Hud {
  readonly element = h('div', { class: 'hud', role: 'group', 'aria-label': 'How fast the surface follows' });
  private readonly values: Record<string, HTMLElement> = {};
  private readonly tip = h('p', { class: 'hud-tip', role: 'tooltip', hidden: true });
  private arrivals: number[] = [];
  private latencies: number[] = [];
  /** Time of the newest own edit that an update has brought and no frame has shown. */
  private undrawn: number | undefined;
  private timer = 0;

  constructor() {
    for (const [name, unit, hint] of [
      ['updates', 'updates/s', 'Updates of the surface in the last second'],
      ['latency', 'ms edit → pixel', LATENCY],
      ['bytes', 'per update', 'Bytes of the newest update'],
      ['patches', 'patches', 'Patches that the newest update sent, each counted once, of all'],
      ['points', 'points', 'Points of the surface'],
      ['error', 'off', CERTIFIED],
      ['folds', 'folds', FOLDS],
    ] as const) {
      this.values[name] = h('b', { 'data-hud': name }, '–');
      this.element.append(h('span', { title: hint }, this.values[name], ` ${unit}`));
    }
    this.element.append(this.tip);
    window.addEventListener('pointermove', (event) => this.explain(event));
    document.documentElement.addEventListener('pointerleave', () => (this.tip.hidden = true));
  }

  /** Forgets the measurements, as for another scene. */
  reset(): void {
    this.arrivals = [];
    this.latencies = [];
    this.undrawn = undefined;
    clearTimeout(this.timer);
    for (const value of Object.values(this.values)) value.textContent = '–';
    this.values['latency'].title = this.values['bytes'].title = '';
  }

  /**
   * An update without patches, which a gesture's last one often is, keeps the numbers of the one before.
   *
   * @param isEvaluated The page evaluates points by itself: its edits are shown, and measured, before an update comes.
   */
  update(info: UpdateInfo, units: Units, isEvaluated: boolean): void {
    if (info.patchesSent > 0) this.arrivals.push(performance.now());
    if (info.msFromEdit !== undefined && !isEvaluated) this.undrawn = performance.now() - info.msFromEdit;
    if (info.patchesSent > 0) {
      this.values['bytes'].textContent = bytes(info.bytes);
      this.values['bytes'].title = info.chosen ?? '';
      this.values['patches'].textContent =
        `${info.patchesSent.toLocaleString('en')} / ${info.patchesAll.toLocaleString('en')}`;
    }
    this.tellDetail(info.points, info.certifiedError, units);
    const { server, transfer, decode, upload } = info.times;
    this.values['latency'].title =
      `The newest: server ${ms(server)}, transfer ${ms(transfer)}, decoding ${ms(decode)}, upload ${ms(upload)}`;
    this.showRate();
  }

  /** The page has evaluated points after an edit that is `ms` old, before the server has answered. */
  evaluated(ms: number): void {
    this.undrawn = performance.now() - ms;
  }

  /** What is drawn, if the page evaluates it: an update tells otherwise. `error`: 0 where it is not known. */
  tellDetail(points: number, error: number, units: Units): void {
    this.values['points'].textContent = points.toLocaleString('en');
    this.values['error'].textContent = error > 0 ? lengthsInWords([error], units, 2) : '–';
  }

  /** Undefined where it is not known. */
  tellFolds(folds: Folds | undefined): void {
    const value = this.values['folds'];
    value.textContent = folds === undefined ? '–' : `${folds.folded}${folds.undecided > 0 ? ` +${folds.undecided}?` : ''}`;
    value.toggleAttribute('data-bad', folds !== undefined && !folds.certified);
  }

  /** Called for each frame; `seen` resolves when its pixels are there. */
  async drawn(seen: Promise<void>): Promise<void> {
    const edit = this.undrawn;
    this.undrawn = undefined;
    if (edit === undefined) return;
    await seen;
    this.latencies = [...this.latencies, performance.now() - edit].slice(-LATENCIES);
    this.values['latency'].textContent = median(this.latencies).toFixed(0);
  }

  /** Tells what the number below the mouse measures. The line itself takes no pointer, so that points below it can be pressed. */
  private explain({ clientX, clientY, pointerType, buttons }: PointerEvent): void {
    const isAt = (part: Element): boolean => {
      const { left, right, top, bottom } = part.getBoundingClientRect();
      return clientX >= left && clientX <= right && clientY >= top && clientY <= bottom;
    };
    if (this.element.hidden) return; // no layout for what nobody sees
    const isHover = document.querySelector('dialog:modal') === null && pointerType !== 'touch' && buttons === 0;
    const part = isHover ? [...this.element.querySelectorAll('span')].find(isAt) : undefined;
    this.tip.hidden = part === undefined;
    if (part !== undefined) this.tip.textContent = [part.title, part.querySelector('b')!.title].filter(Boolean).join('. ');
  }

  /** Shows the rate, and repeats this until the rate is 0. */
  private showRate(): void {
    const now = performance.now();
    this.arrivals = this.arrivals.filter((time) => now - time <= WINDOW_MS);
    this.values['updates'].textContent = String(this.arrivals.length);
    clearTimeout(this.timer);
    if (this.arrivals.length > 0) this.timer = window.setTimeout(() => this.showRate(), WINDOW_MS / 4);
  }
}

function ms(time: number): string {
  return `${time.toFixed(1)} ms`;
}

function median(values: readonly number[]): number {
  return [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];
}
