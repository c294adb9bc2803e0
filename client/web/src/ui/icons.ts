// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Line icons on a 24 x 24 grid, as path data.
import { svg } from './dom';

const PATHS = {
  open: 'M3 7v11h18V9h-9L10 6H3z',
  sample: 'M12 3l8 4.5v9L12 21l-8-4.5v-9zM12 12l8-4.5M12 12v9M12 12L4 7.5',
  save: 'M12 4v10M8 10l4 4 4-4M4 19h16',
  load: 'M12 14V4M8 8l4-4 4 4M4 19h16',
  lattice: 'M4 4h16v16H4zM4 12h16M12 4v16',
  undo: 'M9 7L4 12l5 5M4 12h10a6 6 0 0 1 6 6v1',
  redo: 'M15 7l5 5-5 5M20 12H10a6 6 0 0 0-6 6v1',
  reset: 'M4 12a8 8 0 1 0 2.6-5.9M4 4v5h5',
  select: 'M6 3l12 9-6 1 3 7-2 1-3-7-4 4z',
  box: 'M4 8V4h4M16 4h4v4M20 16v4h-4M8 20H4v-4M10 12h4',
  paint: 'M4 20c2.500 0 4-1.500 4-3.500L16.500 6a1.700 1.700 0 0 1 2.500 2.300L10 18c-1 2-3 2.500-6 2z',
  pull: 'M8 12V6a1.5 1.5 0 0 1 3 0v5V4.5a1.5 1.5 0 0 1 3 0V11V6.500a1.5 1.5 0 0 1 3 0V15a6 6 0 0 1-11 3l-3-5c-.6-1.3 1-2.3 2-1z',
  compare: 'M12 3v18M4 6h5v12H4zM15 18c5 0 5-12 0-12',
  move: 'M12 3v18M3 12h18M9.5 5.500L12 3l2.5 2.500M9.5 18.500L12 21l2.5-2.500M5.5 9.500L3 12l2.5 2.500M18.5 9.500L21 12l-2.5 2.5',
  rotate: 'M20 12a8 8 0 1 1-2.6-5.900M20 3v5h-5',
  scale: 'M4 20l16-16M13 4h7v7M4 13v7h7',
  all: 'M4 4h16v16H4zM8 12l3 3 5-6',
  none: 'M4 4h16v16H4z',
  invert: 'M4 4h16v16H4zM4 20L20 4M20 8v12H8z',
  eye: 'M2 12s4-7 10-7 10 7 10 7-4 7-10 7S2 12 2 12zM12 9a3 3 0 1 0 .1 0',
  eyeOff:
    'M4 4l16 16M10 5.300A9 9 0 0 1 12 5c6 0 10 7 10 7a17 17 0 0 1-3 3.700M6 7.500A17 17 0 0 0 2 12s4 7 10 7a9 9 0 0 0 4-1',
  through: 'M12 4l8 4.500v7L12 20l-8-4.500v-7zM9 12a3 3 0 1 0 6 0a3 3 0 1 0-6 0',
  frame: 'M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5M12 9a3 3 0 1 0 .1 0',
  front: 'M4 8h12v12H4zM4 8l4-4h12v12l-4 4',
  side: 'M4 8h12v12H4zM16 8l4-4v12l-4 4z',
  top: 'M4 8h12v12H4zM4 8l4-4h12l-4 4z',
  ortho: 'M5 5h14v14H5zM9 9h6v6H9z',
  soft: 'M12 12m-2 0a2 2 0 1 0 4 0a2 2 0 1 0-4 0M12 12m-8 0a8 8 0 1 0 16 0a8 8 0 1 0-16 0',
  knot: 'M4 4h16v16H4zM12 4v16M9 12h6M12 9v6',
  share: 'M10 14a4 4 0 0 0 6 0l3-3a4 4 0 0 0-6-6l-1 1M14 10a4 4 0 0 0-6 0l-3 3a4 4 0 0 0 6 6l1-1',
  export: 'M14 3H6v18h12V7zM14 3v4h4M12 11v7M9 15l3 3 3-3',
  theme: 'M12 4a8 8 0 1 0 0 16zM12 4a8 8 0 0 1 0 16',
  panel: 'M4 5h16v14H4zM15 5v14',
  help: 'M12 3a9 9 0 1 0 .1 0M9.5 9.500a2.5 2.5 0 1 1 3.5 2.300c-.7.3-1 .8-1 1.700M12 16.800v.2',
  wire: 'M3 18L12 4l9 14zM7.5 11h9M12 18l-4.5-7M12 18l4.5-7',
  check: 'M5 13l4 4L19 7',
  extend: 'M5 3l9 7-5 1 2 5-2 1-2-5-2 2zM17 13v8M13 17h8',
  close: 'M6 6l12 12M18 6L6 18',
} as const;

export type IconName = keyof typeof PATHS;

export function icon(name: IconName): SVGElement {
  const path = svg('path', { d: PATHS[name] });
  return svg('svg', { viewBox: '0 0 24 24', class: 'icon', 'aria-hidden': 'true' }, path);
}
