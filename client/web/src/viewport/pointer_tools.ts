// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Mouse, pen and touch on the view. A press on a control point selects or drags it, also where a handle lies over its
// disc. A press on a handle goes to the gizmo, and a press with a tool to the tool. Everything else, and a press of two
// fingers, moves the camera. A transform that keys began gets the pointer while it runs.
import type { Cage } from '../cage/cage';
import type { Editor } from '../edit/editor';
import { WORLD_BASIS } from '../lattice/vec';
import type { Settings, SettingsStore } from '../state/settings';
import { BoxDrag, PointDrag, PullDrag, SteeringDrag, selectMode, type Drag, type Place, type PullListener } from './drags';
import type { Gizmo } from './gizmo';
import { PaintDrag } from './paint_drag';
import type { PointPicker } from './point_picker';
import type { Viewport } from './viewport';

const SLACK = 4; // pixels that the pointer may move in a click

/** Whether presses are of the surface, and not of control points. */
function isSurfaceTool(tool: Settings['tool']): boolean {
  return tool === 'pull' || tool === 'paint';
}

interface Press {
  id: number;
  place: Place;
  point: number | undefined;
  /** The gizmo drags. Without a move the press is a click on the point below the handle. */
  onHandle: boolean;
  drag: Drag | undefined;
  moved: boolean;
  /** The newest event of the pointer. */
  last: PointerEvent;
}

export interface PointerToolsParts {
  viewport: Viewport;
  editor: Editor;
  settings: SettingsStore;
  picker: PointPicker;
  cage: Cage;
  gizmo: Gizmo;
  pulls: PullListener;
}

export class PointerTools {
  /** The pointer's last place, for transforms that keys begin. */
  place: Place = [0, 0];
  private press: Press | undefined;
  private readonly abort = new AbortController();

  constructor(private readonly parts: PointerToolsParts) {
    const { canvas, element } = parts.viewport;
    const options = { signal: this.abort.signal, capture: true };
    // In the capture phase, so that the orbit can be switched off before it gets the press.
    element.addEventListener('pointerdown', (event) => event.target === canvas && event.isTrusted && this.down(event), options);
    window.addEventListener('pointermove', (event) => this.move(event), options);
    window.addEventListener('pointerup', (event) => this.up(event), options);
    window.addEventListener('pointercancel', () => this.lost(), options);
    element.addEventListener('wheel', (event) => this.wheel(event), { ...options, passive: false });
    // Pointer events report a second button, while one is held, as a move; mouse events report a press.
    element.addEventListener('mousedown', (event) => event.button === 2 && this.cancel(), options);
    canvas.addEventListener('contextmenu', (event) => event.preventDefault(), options);
    canvas.addEventListener('pointerleave', () => this.hover(undefined), options);
  }

  /** Whether a press moves something and its release will end that. */
  get dragging(): boolean {
    return this.press !== undefined && this.press.moved && !(this.press.drag instanceof SteeringDrag);
  }

  dispose(): void {
    this.lost();
    this.abort.abort();
  }

  /** Cancels what a press has begun. Returns whether it had begun anything. */
  cancel(): boolean {
    const { press } = this;
    const any = this.parts.gizmo.cancel() || press?.drag !== undefined;
    press?.drag?.cancel();
    if (press !== undefined && any) {
      // The rest of the press is neither a click nor an orbit.
      Object.assign(press, { drag: undefined, point: undefined, moved: true });
      this.parts.viewport.rig.controls.enabled = false;
    }
    return any;
  }

  /** The press ends without a release. */
  private lost(): void {
    this.cancel();
    this.press = undefined;
    this.parts.viewport.rig.controls.enabled = true;
    this.parts.gizmo.setEnabled(true);
  }

  private down(event: PointerEvent): void {
    const { editor, viewport, gizmo } = this.parts;
    viewport.canvas.focus({ preventScroll: true });
    this.place = viewport.place(event);
    if (this.press === undefined && editor.transforming) return this.endTransform(event);
    if (!event.isPrimary && event.pointerType === 'touch') return this.handOver();
    if (!event.isPrimary || event.button !== 0) return;

    const paints = this.parts.settings.value.tool === 'paint'; // also where a control point lies over the surface
    const point = paints ? undefined : this.parts.picker.at(...this.place, event.pointerType);
    const onHandle = !paints && this.isForHandle(point, event.pointerType);
    gizmo.setEnabled(onHandle);
    const drag = onHandle ? undefined : this.toolDrag(event, point);
    this.press = { id: event.pointerId, place: this.place, point, onHandle, drag, moved: false, last: event };
    if (onHandle) return;
    if (drag !== undefined || point !== undefined) viewport.rig.controls.enabled = false;
  }

  private isForHandle(point: number | undefined, pointerType: string): boolean {
    const { picker, gizmo } = this.parts;
    return !(point !== undefined && picker.isOnDisc(point, ...this.place, pointerType)) && gizmo.takes(this.place);
  }

  /** A click confirms the transform that keys began, a right click cancels it, a finger steers it. */
  private endTransform(event: PointerEvent): void {
    const { editor, viewport } = this.parts;
    // A finger has no place before it comes down: it steers, and buttons confirm.
    const drag = event.pointerType === 'touch' ? new SteeringDrag(editor, this.place) : undefined;
    if (event.button === 2) editor.cancelTransform();
    else if (drag === undefined) editor.commitTransform();
    viewport.rig.controls.enabled = false;
    event.preventDefault();
    this.press = { id: event.pointerId, place: this.place, point: undefined, onHandle: false, drag, moved: true, last: event };
  }

  /** A second finger came down: cancels what the first one began, and gives both to the camera. */
  private handOver(): void {
    const { press } = this;
    const { viewport, gizmo } = this.parts;
    if (press === undefined || press.drag instanceof SteeringDrag) return;
    this.cancel();
    gizmo.setEnabled(false);
    Object.assign(press, { drag: undefined, point: undefined, onHandle: false, moved: true });
    viewport.rig.controls.enabled = true;
    viewport.canvas.dispatchEvent(new PointerEvent('pointerdown', press.last)); // the orbit has not got this press
  }

  /** While a transform runs, the wheel changes the soft radius, not the zoom. Turned towards oneself, it enlarges. */
  private wheel(event: WheelEvent): void {
    const { editor, gizmo } = this.parts;
    if (!editor.transforming && !gizmo.dragging) return;
    editor.resizeSoft(Math.sign(event.deltaY));
    event.preventDefault();
    event.stopPropagation();
  }

  private toolDrag(event: PointerEvent, point: number | undefined): Drag | undefined {
    const { viewport, editor, settings, picker, pulls } = this.parts;
    const { tool } = settings.value;
    if (tool === 'paint' && editor.session.mayEdit) {
      if (editor.session.surface.painted === undefined) return undefined;
      return new PaintDrag(viewport, editor.session, settings.value.brush, this.place, picker.occlusion);
    }
    if (tool === 'pull' && editor.session.mayEdit) return new PullDrag(viewport, editor, this.place, pulls);
    if (tool === 'box' || (event.shiftKey && point === undefined)) {
      return new BoxDrag(viewport, picker, editor, this.place, selectMode(event, settings.value.toggling));
    }
    return undefined;
  }

  private move(event: PointerEvent): void {
    const { editor, viewport, gizmo, settings } = this.parts;
    if (!event.isPrimary) return;
    const place = viewport.place(event);
    this.place = place;
    if (settings.value.tool === 'paint') viewport.invalidate(); // the brush's circle follows
    gizmo.setSnapping(
      event.ctrlKey && gizmo.busy
        ? viewport.transformView(editor.pivot(), WORLD_BASIS, WORLD_BASIS).snapStep
        : undefined,
    );
    const modifiers = { shift: event.shiftKey, ctrl: event.ctrlKey || event.metaKey };
    if (this.press === undefined) {
      if (editor.transforming) {
        this.hover(undefined);
        editor.pointerMoved(...place, modifiers);
      } else if (event.target === viewport.canvas && event.buttons === 0) this.hoverAt(event);
      return;
    }
    const { press } = this;
    press.last = event;
    press.moved ||= Math.hypot(place[0] - press.place[0], place[1] - press.place[1]) > SLACK;
    if (press.moved && press.drag === undefined && press.point !== undefined && !press.onHandle)
      press.drag = this.grab(press.point, press.place);
    press.drag?.move(...place, modifiers);
  }

  /** Begins to drag the selection, or only the pressed point if that is not selected. */
  private grab(point: number, place: Place): Drag {
    const { editor, viewport } = this.parts;
    if (!editor.selection.has(point)) editor.selection.select([point]);
    return new PointDrag(viewport, editor, place);
  }

  private up(event: PointerEvent): void {
    const { press, parts } = this;
    if (press === undefined || press.id !== event.pointerId) return;
    this.press = undefined;
    parts.viewport.rig.controls.enabled = true;
    parts.gizmo.setEnabled(true);
    if (press.drag !== undefined && (press.moved || isSurfaceTool(parts.settings.value.tool))) return press.drag.end();
    press.drag?.cancel();
    if (press.moved) return;
    const { tool, toggling } = parts.settings.value;
    const mode = selectMode(event, toggling);
    if (press.point !== undefined) parts.editor.selection.select([press.point], mode);
    else if (mode === 'replace' && !isSurfaceTool(tool) && !press.onHandle) parts.editor.selection.none();
  }

  private hoverAt(event: PointerEvent): void {
    if (event.pointerType === 'touch') return;
    const { gizmo, picker, settings } = this.parts;
    const point = picker.at(...this.place, event.pointerType);
    const onHandle = this.isForHandle(point, event.pointerType);
    gizmo.setEnabled(onHandle);
    this.hover(onHandle || isSurfaceTool(settings.value.tool) ? undefined : point);
  }

  private hover(point: number | undefined): void {
    const { cage, viewport } = this.parts;
    if (cage.hover(point)) viewport.invalidate();
    viewport.canvas.style.cursor = point === undefined ? '' : 'pointer';
  }
}
