// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The choices of a person: tools, behaviour of transforms, what is drawn, how the surface is sent.
import type { SoftSelection } from '../edit/falloff';
import type { Mirror } from '../edit/mirror';
import type { MotionKind } from '../edit/motion';
import type { Orientation, Pivot } from '../edit/pivot';
import type { MeshFormatName } from '../intake/mesh_file';
import type { ExportFormat } from '../intake/services';
import type { Light } from '../light/shading';
import type { StreamSettings } from '../session/scene_session';
import type { ExportGeometry } from '../wire/export_download';
import type { You } from './person';
import { Store } from './store';
import type { UpAxis } from './units';

/** The action of a press on the view: select and drag points, draw a box, pull the surface, or paint vertex weights. */
export type Tool = 'select' | 'box' | 'pull' | 'paint';

/** Paints weights towards `weight`, by the share `strength` in its middle, falling off smoothly to its radius in pixels. */
export interface Brush {
  readonly radius: number;
  readonly strength: number;
  readonly weight: number;
}

export type Colouring = 'plain' | 'boxes' | 'displacement' | 'difference' | 'texture';
/** How the shape is shown that the mesh would have if only its vertices moved. */
export type Compare = 'off' | 'split' | 'over';
export type Theme = 'system' | 'light' | 'dark';

export const DEFAULT_SETTINGS = {
  tool: 'select' as Tool,
  /** The handles at the selected points; none hides them. */
  gizmo: 'move' as MotionKind | 'none',
  orientation: 'world' as Orientation,
  pivot: 'median' as Pivot,
  soft: { enabled: false, radius: 0.5, falloff: 'smooth' } as SoftSelection,
  brush: { radius: 50, strength: 0.5, weight: 0 } as Brush,
  mirror: [false, false, false] as Mirror,
  /** Whether the server refuses edits that make a new fold. A drag then stops at its last good state. */
  refuseFolds: false,
  /** Whether a press adds a point to the selection or removes it, instead of replacing the selection. */
  toggling: false,
  /** Whether points behind the surface are shown and can be selected. */
  through: true,
  orthographic: false,
  cage: true,
  knotBoxes: false,
  surface: true,
  colouring: 'plain' as Colouring,
  /** Whether the surface has a shadow on the ground. */
  shadow: true,
  /** The light on the plain surface, or one of three materials. */
  light: 'studio' as Light,
  wireframe: false,
  patchEdges: false,
  ghost: false,
  compare: 'off' as Compare,
  /** The axis that is up in files of formats that do not say; the last choice. glTF's is y. */
  upAxes: { obj: 'y', ply: 'z', stl: 'z', drc: 'z' } as Record<Exclude<MeshFormatName, 'glb'>, UpAxis>,
  /** Where a split view is divided, 0 to 1 of its width. */
  divider: 0.5,
  /** How finely the surface is drawn: within some pixels of the exact one, or with the same segments everywhere. */
  detail: 'tolerance' as 'tolerance' | 'segments',
  /** The tolerance. */
  pixels: 0.5,
  view: { segments: 10, normals: 'smooth', encoding: 'patches', positionBits: 12, normalBits: 8 } as StreamSettings,
  /** The format in which a surface was exported last. */
  exportFormat: 'glb' as ExportFormat,
  exportGeometry: 'exact' as ExportGeometry,
  exportDetail: 'segments' as 'segments' | 'tolerance',
  /** Of an export by tolerance, as a part of the diagonal of the surface's bounds. */
  exportTolerance: 1e-4,
  theme: 'system' as Theme,
  /** The name and colour that others see. */
  you: { name: '', colour: 'random' } as You,
  /** Whether the side panel is open. */
  panel: true,
};

export type Settings = typeof DEFAULT_SETTINGS;

/** The settings that a browser remembers between visits: taste, nothing that depends on one mesh. */
const REMEMBERED = [
  'gizmo', 'orientation', 'pivot', 'refuseFolds', 'through', 'theme', 'light', 'shadow', 'upAxes', 'exportFormat', 'exportGeometry', 'exportDetail',
  'exportTolerance', 'you', 'detail', 'pixels',
] as const;
const STORAGE_KEY = 'latticed.settings';

export type SettingsStore = Store<Settings>;

/** Settings that are saved in `storage`. If it refuses, they last as long as the page. */
export function rememberedSettings(storage: Pick<Storage, 'getItem' | 'setItem'>): SettingsStore {
  const store = new Store<Settings>({ ...DEFAULT_SETTINGS, ...read(storage) });
  store.subscribe((settings) => {
    const kept = Object.fromEntries(REMEMBERED.map((key) => [key, settings[key]]));
    try {
      storage.setItem(STORAGE_KEY, JSON.stringify(kept));
    } catch {
      // Private windows refuse storage: the choice then lasts as long as the page.
    }
  });
  return store;
}

function read(storage: Pick<Storage, 'getItem'>): Partial<Settings> {
  try {
    const kept = JSON.parse(storage.getItem(STORAGE_KEY) ?? '{}') as Partial<Settings>;
    return Object.fromEntries(REMEMBERED.filter((key) => key in kept).map((key) => [key, kept[key]]));
  } catch {
    return {};
  }
}
