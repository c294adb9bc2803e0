// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One scene in the view: its surface and its cage, kept in step with the session, and the tools that edit them.
import { Box3, Vector3 } from 'three';
import { Cage } from './cage/cage';
import { DARK_CAGE, LIGHT_CAGE } from './cage/cage_style';
import { FoldedBoxes } from './cage/folded_boxes';
import { KnotBoxes } from './cage/knot_boxes';
import type { Constraint } from './edit/constraint';
import { DetailWatch } from './detail_watch';
import { EvaluationWatch } from './evaluation_watch';
import { Editor } from './edit/editor';
import { handleHeadline, pullHeadline } from './edit/headline';
import type { Motion, MotionKind } from './edit/motion';
import type { SurfacePull } from './edit/surface_pull';
import type { TransformGesture } from './edit/transform_gesture';
import { FoldsWatch } from './folds_watch';
import { pointAt } from './lattice/vec';
import { GroundShadow } from './light/ground_shadow';
import type { LiveSession } from './session/live_session';
import type { Settings, SettingsStore } from './state/settings';
import { uprightDirection, type Units } from './state/units';
import { allowedReach, showAddLatticeDialog } from './ui/dialogs/add_lattice_dialog';
import { showCarryDialog } from './ui/dialogs/carry_dialog';
import { showKnotDialog } from './ui/dialogs/knot_dialog';
import { showOutsideDialog } from './ui/dialogs/outside_dialog';
import { showResizeDialog } from './ui/dialogs/resize_dialog';
import { PullLine } from './ui/overlays/pull_line';
import { SoftCircle } from './ui/overlays/soft_circle';
import { Gizmo } from './viewport/gizmo';
import { KnotPlacer } from './viewport/knot_placer';
import { OutsideHandles } from './viewport/outside_handles';
import { PointPicker } from './viewport/point_picker';
import { PointerTools } from './viewport/pointer_tools';
import type { Folds } from './wire/fold_message';
import type { Viewport } from './viewport/viewport';

/** Between the background and the cage, in light and in shade: three times as light as the one, a third of the other, or the reverse. */
const DARK_SURFACE = { colour: 0x6c7788, tones: [0.12, 0.2] } as const;
const LIGHT_SURFACE = { colour: 0x5e6876, tones: [0.11, 0.17] } as const;

export interface SceneViewEvents {
  /** The selection, the lattice, the surface or a setting has changed: panels must refresh. */
  changed(): void;
  headline(text: string | undefined): void;
  /** The press hit no surface. With `error`: the pick failed, or the press was released too early. */
  pullMissed(error?: unknown): void;
}

export class SceneView {
  readonly editor: Editor;
  readonly pointer: PointerTools;
  private readonly cage: Cage;
  private readonly knotBoxes = new KnotBoxes();
  private readonly foldedBoxes = new FoldedBoxes();
  private readonly foldsWatch: FoldsWatch;
  private knownFolds: Folds | undefined;
  private readonly shadow = new GroundShadow();
  private readonly softCircle = new SoftCircle();
  private readonly pullLine = new PullLine();
  private readonly detail: DetailWatch;
  private readonly evaluation: EvaluationWatch;
  /** Called when the page has evaluated points after an edit of that age. */
  onEvaluated?: (ms: number) => void;
  private readonly gizmo: Gizmo;
  private readonly picker: PointPicker;
  private gizmoGesture: TransformGesture | undefined;
  private pull: SurfacePull | undefined;
  private readonly ends: (() => void)[] = [];
  private closeDialog: (() => void) | undefined;
  private stale = false;
  private hasMoved = false;
  private isShadowOld = true;

  constructor(
    private readonly viewport: Viewport,
    readonly session: LiveSession,
    private known: Units,
    private readonly settings: SettingsStore,
    private readonly events: SceneViewEvents,
  ) {
    this.detail = new DetailWatch(session, settings, viewport);
    this.evaluation = new EvaluationWatch(session, settings, viewport, {
      changed: () => (this.stale = this.hasMoved = true),
      evaluated: (ms) => this.onEvaluated?.(ms),
      failed: () => this.detail.needsPoints(),
    });
    this.editor = new Editor(session, settings, (text) => this.headline(text));
    this.cage = new Cage(session.lattice, this.editor.selection);
    this.cage.setHeld(session.held);
    this.picker = new PointPicker(viewport, this.editor);
    this.gizmo = new Gizmo(viewport, {
      begin: () => (this.gizmoGesture = this.editor.beginGesture(() => this.pointer.cancel())),
      update: (motion, constraint) => this.dragHandle(motion, constraint),
      end: () => this.endGizmo((gesture) => gesture.commit()),
      cancel: () => this.endGizmo((gesture) => gesture.cancel()),
    });
    const { editor, picker, cage, gizmo } = this;
    this.pointer = new PointerTools({
      viewport,
      editor,
      settings,
      picker,
      cage,
      gizmo,
      pulls: { missed: (error) => events.pullMissed(error), pulled: (pull) => this.showPull(pull) },
    });
    viewport.element.append(this.softCircle.element, this.pullLine.element);
    viewport.scene.add(session.surface.object, this.cage.object, this.knotBoxes.object, this.foldedBoxes.object, this.shadow.object);
    session.surface.onChanged = () => this.refreshSoon();
    viewport.coarsened = session.surface;
    this.setUnits(known);
    this.listen();
    this.applySettings(settings.value);
    this.foldsWatch = new FoldsWatch(session, (folds) => this.showFolds(folds));
    this.refresh();
  }

  /** Where the server has found folds; undefined where that is not known. */
  get folds(): Folds | undefined {
    return this.knownFolds;
  }

  /** Whether the page evaluates the surface by itself. */
  get isEvaluated(): boolean {
    return this.evaluation.isActive;
  }

  get units(): Units {
    return this.known;
  }

  /** Turns the view if another axis is up. */
  setUnits(units: Units): void {
    const isTurned = units.up !== this.known.up;
    this.known = units;
    this.viewport.rig.setUp(units.up ?? 'z');
    if (isTurned) this.frameAll();
    this.isShadowOld = true;
    this.refreshSoon();
  }

  setDark(dark: boolean): void {
    const style = dark ? DARK_CAGE : LIGHT_CAGE;
    this.cage.setStyle(style);
    this.knotBoxes.setColour(style.knotBoxes);
    this.shadow.strength = dark ? 0.6 : 0.4;
    this.session.surface.setLook(dark ? DARK_SURFACE : LIGHT_SURFACE);
    this.viewport.invalidate();
  }

  /** Begins the transform of G, R or S at the pointer; false if nothing is selected. */
  beginTransform(kind: MotionKind): boolean {
    const { viewport } = this;
    return this.editor.beginTransform(
      kind,
      viewport.transformView.bind(viewport),
      viewport.rig.basis(),
      this.pointer.place,
    );
  }

  /** Shows all of the surface, and of the cage unless it is hidden. */
  frameAll(): void {
    const { surface } = this.session;
    const isAlone = !this.settings.value.cage && !surface.bounds.isEmpty();
    this.viewport.rig.frame(isAlone ? surface.bounds : this.bounds());
  }

  frameSelected(): void {
    const box = new Box3();
    for (const index of this.editor.selection.indices)
      box.expandByPoint(new Vector3(...pointAt(this.session.lattice.points, index)));
    const size = this.bounds().getSize(new Vector3()).length();
    this.viewport.rig.frame(box.isEmpty() ? this.bounds() : box.expandByScalar(size / 12));
  }

  /** The bounds of the control points and the surface. */
  bounds(): Box3 {
    const { surface } = this.session;
    const box = new Box3().setFromArray(this.session.lattice.points as unknown as number[]);
    return surface.bounds.isEmpty() ? box : box.union(surface.bounds);
  }

  /** Asks for a knot plane, which the view shows meanwhile. */
  placeKnot(): void {
    this.closeDialog?.();
    this.closeDialog = showKnotDialog(this.editor, new KnotPlacer(this.viewport, () => this.session.lattice));
  }

  /** Asks what goes on outside the lattice, with handles in the view. */
  chooseOutside(): void {
    this.closeDialog?.();
    this.closeDialog = showOutsideDialog(this.session, new OutsideHandles(this.viewport, this.session.lattice.frame));
  }

  /** Asks for a lattice to add, with handles in the view. */
  addLattice(): void {
    this.closeDialog?.();
    const { frame } = this.session.lattice;
    this.closeDialog = showAddLatticeDialog(this.session, new OutsideHandles(this.viewport, frame, allowedReach, 'Face'));
  }

  /** Asks for a parent lattice that carries control points. */
  carryPoints(): void {
    this.closeDialog?.();
    this.closeDialog = showCarryDialog(this.editor);
  }

  /** Asks for another size or degree of the lattice. */
  resizeLattice(): void {
    this.closeDialog?.();
    this.closeDialog = showResizeDialog(this.session);
  }

  dispose(): void {
    this.closeDialog?.();
    for (const end of this.ends) end();
    this.detail.dispose();
    this.evaluation.dispose();
    this.foldsWatch.dispose();
    this.pointer.dispose();
    this.editor.dispose();
    this.gizmo.dispose();
    this.softCircle.element.remove();
    this.pullLine.element.remove();
    this.viewport.coarsened = undefined;
    const { surface } = this.session;
    this.viewport.scene.remove(
      surface.object, this.cage.object, this.knotBoxes.object, this.foldedBoxes.object, this.shadow.object,
    );
    this.foldedBoxes.dispose();
    this.shadow.dispose();
    this.cage.dispose();
    this.knotBoxes.dispose();
    this.picker.dispose();
    this.session.close();
    this.viewport.invalidate();
  }

  /** At the end of a transform the handles come back, even if it moved nothing. */
  private headline(text: string | undefined): void {
    this.events.headline(text);
    if (text === undefined) this.refreshSoon();
  }

  private showPull(pull: SurfacePull | undefined): void {
    this.pull = pull;
    this.events.headline(pull && pullHeadline(pull));
    this.viewport.invalidate();
  }

  private showFolds(folds: Folds | undefined): void {
    this.knownFolds = folds;
    const { count } = this.foldedBoxes;
    this.foldedBoxes.setBoxes(folds?.places ?? [], this.session.lattice);
    if (count > 0 || this.foldedBoxes.count > 0) this.refreshSoon();
    else this.events.changed(); // the view stays as it is
  }

  private showPresence(): void {
    const { others, shownLatticeIndex } = this.session;
    const isOther = this.cage.setPresence([...others.values()].filter(({ lattice }) => lattice === shownLatticeIndex));
    if (isOther) this.viewport.invalidate(); // most news are of cameras, which are not drawn
  }

  private listen(): void {
    const { session, editor, viewport: { canvas } } = this;
    this.ends.push(
      session.on('points', (indices) => {
        this.cage.updatePoints(indices);
        this.hasMoved = true;
        this.refreshSoon();
        this.viewport.moved();
      }),
      session.on('lattice', (lattice) => {
        editor.latticeReplaced();
        this.cage.setLattice(lattice);
        this.showPresence();
        this.refreshSoon();
      }),
      session.on('constraints', () => {
        this.cage.setHeld(session.held);
        this.refreshSoon();
      }),
      session.on('update', () => {
        this.hasMoved = true;
        this.refreshSoon();
      }),
      session.on('refused', () => session.surface.painted && session.surface.dropWeights()),
      session.on('answered', () => this.refreshSoon()),
      session.on('status', () => this.refreshSoon()), // the token may allow more than before, or less
      session.on('presence', () => this.showPresence()),
      editor.selection.onChange(() => {
        this.cage.updateStates();
        this.refreshSoon();
      }),
      this.settings.subscribe((settings) => this.applySettings(settings)),
      this.viewport.onFrame(() => this.frame()),
      () => canvas.removeEventListener('webglcontextrestored', this.restored),
    );
    canvas.addEventListener('webglcontextrestored', this.restored);
  }

  /** The shadow's picture is lost. */
  private readonly restored = (): void => {
    this.isShadowOld = true;
    this.refreshSoon();
  };

  private applySettings(settings: Settings): void {
    const { surface } = this.session;
    const { colouring, light, wireframe, patchEdges, ghost, compare } = settings;
    surface.setLook({ colouring: settings.tool === 'paint' ? 'weights' : colouring, light, wireframe, patchEdges, ghost, compare });
    surface.object.visible = settings.surface;
    this.shadow.object.visible = settings.surface && settings.shadow;
    this.cage.object.visible = settings.cage;
    this.cage.setThrough(settings.through);
    this.knotBoxes.object.visible = settings.knotBoxes;
    this.viewport.rig.setOrthographic(settings.orthographic);
    this.session.refuseFolds = settings.refuseFolds;
    this.refreshSoon();
  }

  /** Many changes between two frames are shown once, by the next one. */
  private refreshSoon(): void {
    this.stale = true;
    this.viewport.invalidate();
  }

  private refresh(): void {
    this.stale = false;
    this.picker.invalidate();
    this.knotBoxes.update(this.session.lattice);
    this.foldedBoxes.update(this.session.lattice);
    if (this.hasMoved) this.session.surface.compareAgain();
    this.isShadowOld ||= this.hasMoved;
    this.hasMoved = false;
    if (this.isShadowOld) this.castShadow();
    this.viewport.content.copy(this.bounds());
    this.placeGizmo();
    this.events.changed();
  }

  private castShadow(): void {
    const { surface } = this.session;
    if (!this.shadow.object.visible || surface.bounds.isEmpty()) return;
    this.isShadowOld = false;
    this.shadow.update(this.viewport.renderer, surface.bounds, uprightDirection([0, 0, 1], this.known.up ?? 'z'), surface.drawAlone);
  }

  /** Called before each frame. Shows the changes, and updates what depends on the camera. */
  private frame(): void {
    if (this.stale) this.refresh();
    this.detail.ask();
    if (this.settings.value.orientation === 'view') this.placeGizmo();
    this.cage.setPixelRatio(this.viewport.renderer.getPixelRatio());
    const { soft, divider, tool, brush } = this.settings.value;
    this.session.surface.setDivider(divider * this.viewport.canvas.width);
    const missed = this.pull !== undefined && this.pull.outOfReach > 0 ? this.pull : undefined;
    this.pullLine.show(missed && this.viewport.project(missed.point.position), missed && this.viewport.project(missed.target));
    const busy = this.editor.transforming || this.gizmoGesture !== undefined;
    const [x, y] = this.pointer.place;
    if (tool === 'paint') this.softCircle.show({ x, y, radius: brush.radius });
    else this.softCircle.show(soft.enabled && busy ? this.viewport.disc(this.editor.pivot(), soft.radius) : undefined);
  }

  private placeGizmo(): void {
    const { gizmo, tool, cage } = this.settings.value;
    const shown =
      this.session.mayEdit && gizmo !== 'none' && tool !== 'pull' && tool !== 'paint' && cage && this.editor.selection.size > 0 && !this.editor.transforming;
    if (!shown) return this.gizmo.hide();
    this.gizmo.show(gizmo, this.editor.pivot(), this.editor.axes(this.viewport.rig.basis()));
  }

  private dragHandle(motion: Motion, constraint: Constraint | undefined): void {
    if (this.gizmoGesture === undefined) return;
    this.gizmoGesture.update(motion);
    this.events.headline(handleHeadline(motion, constraint, this.settings.value.orientation));
  }

  private endGizmo(end: (gesture: TransformGesture) => void): void {
    if (this.gizmoGesture !== undefined) end(this.gizmoGesture);
    this.gizmoGesture = undefined;
    this.headline(undefined);
  }
}
