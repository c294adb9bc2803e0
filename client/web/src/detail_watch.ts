// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Keeps the view that a session asks for in step with the settings and the camera. By tolerance, the surface is within some
// pixels of the exact one where it is nearest. The tolerance is a power of two, so that windows may share a view, and is asked
// for again only once the camera needs a finer one, or allows one four times as large: an orbit asks for nothing.
import type { LiveSession } from './session/live_session';
import type { StreamSettings, ViewRequest } from './session/scene_session';
import type { Settings, SettingsStore } from './state/settings';
import { leastTolerance, meetsTolerance } from './surface/grid_tolerance';
import { pixelSize } from './viewport/pixel_size';
import type { Viewport } from './viewport/viewport';

const TRIANGLES_DRAWN = 600_000; // what a laptop's GPU draws at every frame without effort
const MOST_SEGMENTS = 32;
const MOST_WHILE_EDITING = 100_000; // points: a laptop decodes them in 25 ms
const NEAREST_AT_FIRST = 0.6; // of a surface's diagonal: the height of the view where it is nearest, when all of it is seen

/** The surface of a scene that opens. */
export interface SurfaceSize {
  /** World units. */
  readonly diagonal: number;
  readonly patches: number;
}

/** The segments at which so many patches have as many triangles as draw without effort; at least 2. */
export function segmentsFor(patches: number, most = MOST_SEGMENTS): number {
  return Math.min(Math.max(Math.floor(Math.sqrt(TRIANGLES_DRAWN / Math.max(patches, 1))), 2), most);
}

/**
 * The view with which a scene opens, before its surface is known.
 *
 * @param height Of the picture, in pixels.
 * @param evaluates Whether this page's GPU can evaluate patches.
 */
export function firstView(settings: Settings, { diagonal, patches }: SurfaceSize, height: number, evaluates: boolean): ViewRequest {
  const { detail, pixels } = settings;
  if (detail === 'tolerance' && settings.view.encoding === 'patches' && evaluates) return { ...settings.view, tolerance: 0, maxPoints: 0 };
  const view = withPoints(settings.view);
  const tolerance = powerOfTwoBelow((pixels * NEAREST_AT_FIRST * diagonal) / height);
  if (detail === 'segments' || !(tolerance > 0)) return { ...view, tolerance: 0, maxPoints: 0 };
  return { ...view, tolerance, segments: segmentsFor(patches), positionBits: 0 };
}

/** Without points, segments and bits mean nothing. */
function withPoints(view: StreamSettings): StreamSettings {
  return view.encoding === 'patches' ? { ...view, encoding: 'auto' } : view;
}

export class DetailWatch {
  /** Whether the page asks for patches and evaluates them, where the settings do not say otherwise. */
  private evaluates: boolean;
  /** The server refused the tolerance, or one finer than this, in world units. Until something else is chosen. */
  private isRefused = false;
  private finest = 0;
  /** The newest surface in full detail is not within the tolerance, since it may have no more points: a finer one is of no use. */
  private isLimited = false;
  /** The settings at the last question. */
  private before: Settings;
  private readonly ends: readonly (() => void)[];

  constructor(
    private readonly session: LiveSession,
    private readonly settings: SettingsStore,
    private readonly viewport: Viewport,
  ) {
    this.before = settings.value;
    this.evaluates = viewport.evaluatesPatches;
    this.ends = [
      settings.subscribe((now, before) => {
        if (now.detail !== before.detail || now.pixels !== before.pixels) [this.isRefused, this.finest] = [false, 0];
        this.ask();
      }),
      session.on('view', (view) => this.takeBack(view)),
      session.on('update', ({ fullDetail, certifiedError }) => {
        if (fullDetail) this.isLimited = certifiedError > (session.askedView.tolerance ?? 0);
      }),
    ];
  }

  dispose(): void {
    for (const end of this.ends) end();
  }

  /** The surface cannot be evaluated here: points are asked for. */
  needsPoints(): void {
    this.evaluates = false;
    this.ask();
  }

  /** Called before each frame. Asks for another view if the present one does not fit. */
  ask(): void {
    const view = this.wanted();
    const { askedView } = this.session;
    const keys = Object.keys(view) as (keyof ViewRequest)[];
    if (keys.some((key) => view[key] !== askedView[key])) this.session.setView(view);
    this.before = this.settings.value;
  }

  /** Whether the settings want the page to evaluate patches, and it can. */
  private get isEvaluated(): boolean {
    const { view, detail } = this.settings.value;
    return this.evaluates && detail === 'tolerance' && view.encoding === 'patches';
  }

  private wanted(): ViewRequest {
    const { view: chosen, detail } = this.settings.value;
    if (this.isEvaluated) return { ...chosen, tolerance: 0, maxPoints: 0 };
    const view = withPoints(chosen);
    const tolerance = detail === 'tolerance' && !this.isRefused ? this.tolerance() : 0;
    const { askedView, surface } = this.session;
    if (tolerance === undefined && askedView.encoding !== 'patches') return {};
    if (!tolerance) return { ...view, tolerance: 0, maxPoints: 0 };
    const segments = askedView.tolerance! > 0 ? askedView.segments! : segmentsFor(surface.patchCount);
    const range = surface.grid?.range ?? 0;
    // Bits that suffice stay as they are: others would send all points again.
    const isSame = tolerance === askedView.tolerance && askedView.positionBits === 0 &&
      view.positionBits === this.before.view.positionBits;
    const positionBits = !isSame && range > 0 && meetsTolerance(tolerance, range, view.positionBits) ? view.positionBits : 0;
    return { ...view, tolerance, segments, positionBits, maxPoints: Math.max(MOST_WHILE_EDITING, 6 * surface.patchCount) };
  }

  /** The tolerance for the view as it is: the one asked for, if that fits. Undefined before there is a surface. */
  private tolerance(): number | undefined {
    const { surface, askedView: { tolerance: asked = 0 } } = this.session;
    if (!surface.layout) return undefined;
    const { rig, pictureHeight } = this.viewport;
    const size = pixelSize(rig.camera, pictureHeight, (visit) => surface.eachBox(visit));
    if (size === undefined) return asked > 0 ? asked : undefined;
    const range = surface.grid?.range || 2 * surface.bounds.min.distanceTo(surface.bounds.max); // floats have no grid
    const least = 2 * powerOfTwoBelow(leastTolerance(range));
    const { pixels } = this.settings.value;
    const needed = Math.max(powerOfTwoBelow(pixels * size), least, this.finest);
    const fits = (needed >= asked || this.isLimited) && needed < 4 * asked;
    return fits && asked > 0 && pixels === this.before.pixels ? asked : needed;
  }

  /** The server refused a view: what it grants becomes the setting, and a tolerance is not asked for again. */
  private takeBack(granted: ViewRequest): void {
    const { view, detail } = this.settings.value;
    if (this.isEvaluated && granted.encoding !== 'patches') return this.needsPoints();
    const isTolerance = (granted.tolerance ?? 0) > 0;
    if (detail === 'tolerance' && !isTolerance) this.isRefused = true;
    this.finest = granted.tolerance ?? 0;
    const { segments, positionBits, ...rest } = pick(granted, view);
    this.settings.set({ view: isTolerance ? { ...view, ...rest } : { ...view, ...rest, segments, positionBits } });
  }
}

/** The members of `from` that `like` has. */
function pick<T extends object>(from: Partial<T>, like: T): T {
  return Object.fromEntries(Object.keys(like).map((key) => [key, from[key as keyof T] ?? like[key as keyof T]])) as T;
}

function powerOfTwoBelow(x: number): number {
  return x > 0 && Number.isFinite(x) ? 2 ** Math.floor(Math.log2(x)) : 0;
}
