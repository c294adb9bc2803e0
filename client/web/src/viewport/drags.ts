// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The drags that a press on the view may become: a box, a control point that follows, the surface that is pulled.
import type { Editor } from '../edit/editor';
import type { SelectMode } from '../edit/selection';
import { SurfacePull } from '../edit/surface_pull';
import type { Modifiers } from '../edit/transform_session';
import { amountsInPlane } from '../edit/constraint';
import { WORLD_BASIS, add, combine, type Vec3 } from '../lattice/vec';
import type { PointPicker } from './point_picker';
import type { Viewport } from './viewport';

/** An action that a press has begun. Places are in CSS pixels of the canvas. */
export interface Drag {
  move(x: number, y: number, modifiers: Modifiers): void;
  end(): void;
  cancel(): void;
}

export type Place = [number, number];

/** `toggling`: as if Ctrl were held, for a page without a keyboard. */
export function selectMode(
  event: { shiftKey: boolean; ctrlKey: boolean; metaKey: boolean },
  toggling: boolean,
): SelectMode {
  if (event.ctrlKey || event.metaKey || toggling) return 'toggle';
  return event.shiftKey ? 'extend' : 'replace';
}

/** Selects the points inside a rectangle, which is shown while it is drawn. */
export class BoxDrag implements Drag {
  private readonly frame = document.createElement('div');
  private corner: Place;

  constructor(
    viewport: Viewport,
    private readonly picker: PointPicker,
    private readonly editor: Editor,
    private readonly from: Place,
    private readonly mode: SelectMode,
  ) {
    this.corner = from;
    this.frame.className = 'selection-box';
    viewport.element.append(this.frame);
  }

  move(x: number, y: number): void {
    this.corner = [x, y];
    const [left, top] = [Math.min(x, this.from[0]), Math.min(y, this.from[1])];
    const [width, height] = [Math.abs(x - this.from[0]), Math.abs(y - this.from[1])];
    this.frame.style.cssText = `left:${left}px;top:${top}px;width:${width}px;height:${height}px`;
  }

  end(): void {
    this.frame.remove();
    this.editor.selection.select(this.picker.inBox(this.from, this.corner), this.mode);
  }

  cancel(): void {
    this.frame.remove();
  }
}

/** Moves the selected points with the pointer, in the plane of the view. Keys may constrain the move meanwhile. */
export class PointDrag implements Drag {
  constructor(viewport: Viewport, private readonly editor: Editor, from: Place) {
    editor.beginTransform('move', viewport.transformView.bind(viewport), viewport.rig.basis(), from);
  }

  move(x: number, y: number, modifiers: Modifiers): void {
    this.editor.pointerMoved(x, y, modifiers);
  }

  end(): void {
    this.editor.commitTransform();
  }

  cancel(): void {
    this.editor.cancelTransform();
  }
}

/** A finger that steers a transform that already runs. Lifting it ends nothing. */
export class SteeringDrag implements Drag {
  constructor(private readonly editor: Editor, from: Place) {
    editor.pointerResumed(...from);
  }

  move(x: number, y: number, modifiers: Modifiers): void {
    this.editor.pointerMoved(x, y, modifiers);
  }

  end(): void {}

  cancel(): void {}
}

export interface PullListener {
  /** The press hit no surface. With `error`: the pick failed, or the press was released too early. */
  missed(error?: unknown): void;
  /** The pull has moved, or the server has answered. Undefined: the pull is over. */
  pulled(pull: SurfacePull | undefined): void;
}

/** Pulls the surface at the pressed point, in the plane through it that faces the viewer. */
export class PullDrag implements Drag {
  private static readonly TOO_QUICK = 'You released the surface before the server found the pressed point.';

  private pull: SurfacePull | undefined;
  private at: Place;
  private isReleased = false;
  private isCancelled = false;

  constructor(
    private readonly viewport: Viewport,
    editor: Editor,
    private readonly from: Place,
    private readonly listener: PullListener,
  ) {
    this.at = from;
    const ray = viewport.ray(...from);
    void editor.session.pick(ray.origin, ray.direction).then((point) => {
      if (this.isCancelled || (this.isReleased && !this.isAway)) return;
      if (point === undefined) return listener.missed();
      if (this.isReleased) return listener.missed(new Error(PullDrag.TOO_QUICK));
      this.pull = new SurfacePull(editor.session, point, () => listener.pulled(this.pull), () => this.letGo());
      this.update();
    }, (error: unknown) => listener.missed(error));
  }

  move(x: number, y: number): void {
    this.at = [x, y];
    this.update();
  }

  end(): void {
    this.isReleased = true;
    this.pull?.commit();
    this.listener.pulled(undefined);
  }

  cancel(): void {
    this.isCancelled = true;
    this.pull?.cancel();
    this.listener.pulled(undefined);
  }

  /** The session has ended the pull: the rest of the press does nothing. */
  private letGo(): void {
    this.pull = undefined;
    this.listener.pulled(undefined);
  }

  private get isAway(): boolean {
    return this.at[0] !== this.from[0] || this.at[1] !== this.from[1];
  }

  private update(): void {
    if (this.pull === undefined || !this.isAway) return;
    const held = this.pull.point.position as Vec3;
    const { basis, jacobian } = this.viewport.transformView(held, WORLD_BASIS, WORLD_BASIS);
    const way = [this.at[0] - this.from[0], this.at[1] - this.from[1]] as const;
    const [right, up] = amountsInPlane(jacobian, basis[0], basis[1], ...way);
    this.pull.update(add(held, combine(basis, [right, up, 0])));
    this.listener.pulled(this.pull);
  }
}
