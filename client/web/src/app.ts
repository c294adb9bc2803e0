// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Connects the page, the settings, the view and the open scene.
import { makeCommands, type CommandTarget } from './commands/all_commands';
import { stepOfKey } from './edit/point_steps';
import { SceneOpener } from './scene_opener';
import { SceneView } from './scene_view';
import type { Services } from './intake/services';
import type { MeshExtent } from './lattice/mesh_extent';
import { LatticeWatch } from './lattice_watch';
import { VolumeWatch } from './volume_watch';
import { PeopleHere } from './people_here';
import type { LiveSession } from './session/live_session';
import type { SessionStatus } from './session/scene_session';
import { rememberedSettings, type Settings } from './state/settings';
import { RecentScenes } from './state/recent_scenes';
import { lengthsInWords, type SceneFacts, volumeInWords } from './state/units';
import type { PatchFacts } from './surface/patch_source';
import { Commands, letterOf } from './ui/commands';
import { h } from './ui/dom';
import { acceptDrops } from './ui/drop_zone';
import { BusySign } from './ui/overlays/busy_sign';
import { CompareDivider } from './ui/overlays/compare_divider';
import { HeatLegend } from './ui/overlays/heat_legend';
import { Hud } from './ui/overlays/hud';
import { MenuBar } from './ui/menu_bar';
import { NavGizmo } from './ui/overlays/nav_gizmo';
import { Remarks } from './ui/overlays/remarks';
import { TokenForm } from './ui/overlays/token_form';
import { buildPage, type Page } from './ui/page';
import { Panel } from './ui/panel';
import { startScreen } from './ui/dialogs/start_screen';
import { ThemeSwitch } from './ui/theme';
import { Toasts } from './ui/toasts';
import { Toolbar } from './ui/toolbar';
import { TransformBar } from './ui/transform_bar';
import { Viewport } from './viewport/viewport';
import { inWords } from './wire/words';

const TOOLS = [
  ['tool-select', 'tool-box', 'tool-pull', 'tool-paint'],
  ['gizmo-move', 'gizmo-rotate', 'gizmo-scale'],
  ['toggling', 'soft', 'through'],
  ['undo', 'redo'],
  ['frame-selected', 'view-front', 'view-side', 'view-top', 'orthographic', 'compare'],
];
const HEADER_TOOLS = [['share', 'export', 'theme', 'panel', 'help']];

const HINTS: Record<Settings['tool'], string> = {
  select: 'Click or drag a control point; G R S move, turn and scale what is selected; ? shows all keys',
  box: 'Draw a box around control points; Shift adds, Ctrl toggles',
  pull: 'Press on the surface and pull it',
  paint: 'Paint how far vertices follow the lattice: red all the way, blue not at all',
};

const ONLY_LOOKING = 'The token of this page only allows to watch this scene, not to edit it';

const CONNECTIONS: Record<SessionStatus['state'], string> = {
  connecting: 'connecting',
  live: 'live',
  retrying: 'trying again',
  token: 'needs a token',
  failed: 'not connected',
};

const ROUNDING = 1e-9; // of the surface's extent: below it a shape has not changed
const LACKS: Record<PatchFacts, string> = {
  rest: 'Displacement, knot boxes and rest shape cannot be shown.',
  uvs: 'The texture cannot be shown.',
  flat: 'The comparison with vertices only cannot be shown.',
  weights: 'The weights cannot be shown.',
};

export class App implements CommandTarget {
  readonly settings = rememberedSettings(localStorage);
  readonly recent = new RecentScenes(localStorage);
  readonly viewport: Viewport;
  readonly toasts: Toasts;
  readonly busy = new BusySign();
  readonly people: PeopleHere;
  readonly opener: SceneOpener;
  readonly commands: Commands;
  scene: SceneView | undefined;
  private readonly page: Page;
  private readonly hud = new Hud();
  private readonly heatLegend = new HeatLegend();
  private readonly divider = new CompareDivider((divider) => this.settings.set({ divider }));
  private readonly remarks = new Remarks((points) => this.selectRemarked(points));
  private readonly tokenForm: TokenForm;
  private watch: LatticeWatch | undefined;
  private volumeWatch: VolumeWatch | undefined;
  private readonly transformBar = new TransformBar(() => this.scene?.editor);
  private readonly panel = new Panel(this.settings, () => this.viewport.canvas.focus());
  private readonly toolbars: Toolbar[];
  private readonly theme: ThemeSwitch;
  private readonly start: HTMLElement;

  constructor(root: HTMLElement, readonly services: Services) {
    this.page = buildPage(root);
    this.viewport = new Viewport(this.page.view);
    this.tokenForm = new TokenForm((token) => this.useToken(token));
    this.toasts = new Toasts(this.page.bottom);
    this.people = new PeopleHere(this.settings, this.viewport, (text) => this.toasts.tell(text));
    this.opener = new SceneOpener(this);
    this.commands = new Commands(makeCommands(this));
    this.toolbars = [
      new Toolbar('Tools', 'toolbar tools-bar', this.commands, TOOLS),
      new Toolbar('Page', 'toolbar page-bar', this.commands, HEADER_TOOLS),
    ];
    this.start = startScreen({
      files: (files) => this.opener.takeFiles(files),
      sample: (name) => this.opener.takeSample(name),
      scene: (id) => this.opener.openRecent(id),
    }, this.recent.list());
    this.theme = new ThemeSwitch((dark) => this.setDark(dark));
    this.layOut();
    document.body.classList.add('no-scene');
    this.settings.subscribe((settings, before) => this.showSettings(settings, before));
    // On narrow screens the panel covers the view, so it starts closed.
    if (matchMedia('(max-width: 900px)').matches) this.settings.set({ panel: false });
    this.theme.set(this.settings.value.theme);
    this.showSettings(this.settings.value, this.settings.value);
    window.addEventListener('keydown', (event) => this.key(event));
    window.addEventListener('popstate', () => void this.opener.openFromAddress());
  }

  /** Shows a scene in place of the one before. */
  show(session: LiveSession, facts: SceneFacts): void {
    this.scene?.dispose();
    this.watch?.dispose();
    this.remarks.clear();
    this.toasts.clearErrors(); // errors of the scene before, or of a scene that could not be opened
    this.scene = new SceneView(this.viewport, session, facts.units, this.settings, {
      changed: () => this.refresh(),
      headline: (text) => this.showHint(text),
      pullMissed: (error) =>
        error === undefined ? this.toasts.tell('There is no surface here to pull.') : this.toasts.fail(inWords(error)),
    });
    session.surface.onFailed = (what, error) => this.toasts.fail(`${LACKS[what]} ${inWords(error)}`);
    this.scene.setDark(this.theme.dark);
    this.tellName(facts.name);
    this.start.hidden = true;
    document.body.classList.remove('no-scene');
    this.hud.reset();
    this.hud.element.hidden = false;
    session.on('update', (info) => this.hud.update(info, this.scene?.units ?? facts.units, this.scene?.isEvaluated ?? false));
    this.scene.onEvaluated = (ms) => this.hud.evaluated(ms);
    session.on('refused', (text, idle) => (idle ? this.toasts.tell(text) : this.toasts.fail(text)));
    session.on('refitted', (distance) => this.toasts.tell(this.refitInWords(distance)));
    this.showStatus(session.status);
    const size = Math.hypot(...this.scene.bounds().getSize(this.viewport.rig.target.clone()).toArray());
    this.panel.show(this.scene.editor, size);
    this.volumeWatch?.dispose();
    this.volumeWatch = new VolumeWatch(session, (volume) => this.showVolume(volume));
    this.scene.frameAll();
    this.people.open(session);
    this.refresh();
  }

  setFacts({ name, units }: SceneFacts): void {
    this.scene?.setUnits(units);
    this.tellName(name);
  }

  private tellName(name: string): void {
    document.title = name ? `${name} · latticed` : 'latticed';
    this.page.name.textContent = name;
    if (this.scene !== undefined) this.recent.add({ id: this.scene.session.sceneId, name });
  }

  private refitInWords(distance: number): string {
    const { x, y, z } = this.scene!.bounds().getSize(this.viewport.rig.target.clone());
    if (distance <= ROUNDING * Math.max(x, y, z)) return 'The new lattice keeps the shape.';
    return `The new lattice changes the shape by about ${lengthsInWords([distance], this.scene!.units)}.`;
  }

  watchLattice(extent: MeshExtent | undefined): void {
    const { scene } = this;
    if (scene === undefined) return;
    this.watch?.dispose();
    this.watch = new LatticeWatch(scene.session, extent, () => scene.folds, (remarks) => this.remarks.show(remarks));
  }

  private showVolume(volume: number | string): void {
    this.panel.constraints.showVolume(typeof volume === 'string' ? volume : volumeInWords(volume, this.scene!.units));
  }

  private selectRemarked(points: readonly number[]): void {
    this.settings.set({ cage: true });
    this.scene?.editor.selection.select(points);
    this.viewport.canvas.focus();
  }

  showStatus({ state, text }: SessionStatus): void {
    this.page.connection.dataset['state'] = state;
    this.page.connection.textContent = CONNECTIONS[state];
    this.page.connection.title = text;
    // If a scene cannot be opened, SceneOpener shows the error.
    const trouble = state === 'retrying' || state === 'token' || (state === 'failed' && this.scene?.session.status.state === 'failed');
    this.page.banner.hidden = !trouble;
    this.page.banner.firstElementChild!.textContent = trouble ? text : '';
    this.tokenForm.show(state === 'token');
    if (!this.scene?.editor.transforming) this.showHint(undefined); // the token may allow more than before, or less
  }

  /** Goes on with another token, which a reload keeps. */
  private useToken(token: string): void {
    history.replaceState(null, '', `${location.search}#${new URLSearchParams({ token })}`);
    this.services.server.useToken(token);
  }

  private refresh(): void {
    this.panel.refresh();
    this.showDistances();
    this.hud.tellFolds(this.scene?.folds);
    this.watch?.checkSoon();
    if (this.scene?.isEvaluated) {
      const { pointCount, certifiedError } = this.scene.session.surface;
      this.hud.tellDetail(pointCount, certifiedError, this.scene.units);
    }
    const extent = this.scene?.session.surface.bounds.getSize(this.viewport.rig.target.clone());
    this.page.extent.textContent = extent && this.scene ? lengthsInWords([extent.x, extent.y, extent.z], this.scene.units) : '';
    for (const toolbar of this.toolbars) toolbar.refresh();
  }

  /** The divider stands only where the other shape is drawn. */
  private showDivider(): void {
    const { compare, divider } = this.settings.value;
    this.divider.show(this.scene?.session.surface.isCompared ? compare : 'off', divider);
  }

  private showDistances(): void {
    const { colouring, compare } = this.settings.value;
    const { scene } = this;
    this.showDivider();
    const what = { displacement: 'displacement', difference: 'vertices only to exact' }[colouring as string];
    this.heatLegend.show(what ?? '', what === undefined ? 0 : scene?.session.surface.displacementRange);
    if (compare === 'off' || scene === undefined) return;
    const { largestDifference, bounds } = scene.session.surface;
    this.divider.tell(largestDifference, bounds.min.distanceTo(bounds.max));
  }

  private layOut(): void {
    const { header, tools, side, view, bottom } = this.page;
    const nav = new NavGizmo((direction) => this.viewport.rig.lookFrom(direction));
    this.viewport.onFrame(() => nav.update(this.viewport.rig.basis()));
    this.viewport.onDrawn((seen) => void this.hud.drawn(seen));
    const [left, right] = this.toolbars;
    header.append(h('strong', {}, 'latticed'), new MenuBar(this.commands).element, this.page.name, this.people.element, right.element);
    tools.append(left.element);
    side.append(this.panel.element);
    this.hud.element.hidden = true;
    this.page.banner.append(this.tokenForm.element);
    bottom.append(this.transformBar.element, this.remarks.element, this.hud.element);
    view.append(this.divider.element, this.people.overlay, nav.element, this.heatLegend.element, this.start, this.busy.element);
    acceptDrops((files) => this.opener.takeFiles(files), (over) => view.classList.toggle('drop-target', over));
  }

  private setDark(dark: boolean): void {
    this.viewport.setBackground(dark ? '#14181f' : '#f3f5f9');
    this.scene?.setDark(dark);
  }

  private showSettings(settings: Settings, before: Settings): void {
    this.theme.set(settings.theme);
    this.showDivider();
    document.body.classList.toggle('panel-closed', !settings.panel);
    if (settings.colouring === 'texture' && before.colouring !== 'texture') this.loadTexture();
    if (!this.scene?.editor.transforming) this.showHint(undefined); // a hint would replace the headline
    for (const toolbar of this.toolbars) toolbar.refresh();
  }

  private loadTexture(): void {
    this.opener.loadTexture().catch((error: unknown) => {
      this.settings.set({ colouring: 'plain' });
      this.toasts.fail(inWords(error));
    });
  }

  private showHint(text: string | undefined): void {
    const { scene } = this;
    this.transformBar.show(scene !== undefined && scene.editor.transforming && !scene.pointer.dragging);
    const hint = scene?.session.mayEdit === false ? ONLY_LOOKING : HINTS[this.settings.value.tool];
    this.page.hint.textContent = text ?? (scene === undefined ? '' : hint);
    this.page.hint.classList.toggle('running', text !== undefined);
  }

  /** Arrow keys step through control points, unless the focus is on what has a use for them. */
  private step(event: KeyboardEvent): boolean {
    const step = stepOfKey(event.key, event.ctrlKey || event.metaKey);
    const { canvas, rig } = this.viewport;
    const isFree = event.target === canvas || event.target === document.body;
    if (step === undefined || !isFree || event.altKey || this.scene === undefined) return false;
    this.scene.editor.step(step, rig.basis(), event.shiftKey ? 'extend' : 'replace');
    return true;
  }

  /** A key goes to the running transform, else to a command. Fields and open dialogs keep their keys. */
  private key(event: KeyboardEvent): void {
    const target = event.target as HTMLElement;
    if (document.querySelector('dialog[open]') !== null) return; // even if the dialog has lost the focus
    if (target.closest('input:not([type=checkbox]):not([type=range]), select, textarea') !== null) return;
    const editor = this.scene?.editor;
    if (editor?.transforming) {
      // Ctrl snaps during a transform, and an undo would break the gesture: these keys run no command.
      const held = event.ctrlKey || event.metaKey || event.altKey;
      if (held || editor.keyPressed(letterOf(event) ?? event.key, event.shiftKey)) event.preventDefault();
      return;
    }
    const isEscape = event.key === 'Escape';
    if (isEscape && (this.scene?.pointer.cancel() || this.people.stop())) return event.preventDefault();
    const closed = isEscape && this.toasts.clear();
    if (this.commands.press(event) || this.step(event) || closed) event.preventDefault();
  }
}
