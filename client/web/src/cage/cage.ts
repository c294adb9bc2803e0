// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The lattice as a person sees and grabs it: grid lines, control points with their states, and rings around points that
// others have selected. Edits write positions in place. Only another grid or other hidden points rebuild anything.
import { BufferAttribute, BufferGeometry, Color, DynamicDrawUsage, Group, LineSegments, Points } from 'three';
import type { Selection } from '../edit/selection';
import { gridLines } from '../lattice/index_sets';
import type { Lattice } from '../lattice/lattice';
import type { Presence } from '../session/scene_session';
import { discMaterial, lineMaterial } from './cage_materials';
import { DARK_CAGE, DIAMETERS, type CageStyle, type PointState } from './cage_style';

const CROWD = 4096; // with more control points than this, discs are drawn smaller, since they would hide one another
const CROWDED = 0.6;

export class Cage {
  /** Positions inside are relative to the origin of the lattice's frame, since the GPU has float32 only. */
  readonly object = new Group();
  private readonly discs = [discMaterial(false), discMaterial(true)];
  private readonly wires = [lineMaterial(false), lineMaterial(true)];
  private geometry = new BufferGeometry();
  private grid = new BufferGeometry();
  private colours = stateBytes(DARK_CAGE);
  private linesHidden = -1; // how many points were hidden when the lines were made
  private hovered: number | undefined;
  private others: readonly Presence[] = [];
  private held: ReadonlySet<number> = new Set();

  constructor(private lattice: Lattice, private readonly selection: Selection) {
    this.setStyle(DARK_CAGE);
    this.setLattice(lattice);
  }

  /** Takes another lattice: other counts, another frame. */
  setLattice(lattice: Lattice): void {
    this.lattice = lattice;
    this.hovered = undefined;
    this.linesHidden = -1;
    this.geometry.dispose();
    this.grid.dispose();
    this.object.clear();
    this.object.position.set(...lattice.frame.origin);
    this.geometry = new BufferGeometry();
    this.grid = new BufferGeometry();
    const position = dynamic(new Float32Array(3 * lattice.count), 3);
    const colour = dynamic(new Uint8Array(4 * lattice.count), 4, true);
    this.geometry.setAttribute('position', position);
    this.geometry.setAttribute('disc', colour);
    this.geometry.setAttribute('ring', dynamic(new Uint8Array(4 * lattice.count), 4, true));
    this.grid.setAttribute('position', position);
    this.grid.setAttribute('color', dynamic(new Uint8Array(3 * lattice.count), 3, true));
    this.addObjects();
    this.updatePoints();
    this.updateStates();
    this.updateRings();
  }

  /** Copies `lattice.points`: all points, or those of `indices`. */
  updatePoints(indices?: Uint32Array): void {
    const position = this.geometry.getAttribute('position') as BufferAttribute;
    const { points, frame } = this.lattice;
    const copy = (index: number): void => {
      for (let axis = 0; axis < 3; ++axis)
        position.array[3 * index + axis] = points[3 * index + axis] - frame.origin[axis];
    };
    if (indices === undefined) for (let i = 0; i < this.lattice.count; ++i) copy(i);
    else indices.forEach(copy);
    position.needsUpdate = true;
  }

  /** Repaints all points after a change of the selection or of the hidden points. */
  updateStates(): void {
    for (let i = 0; i < this.lattice.count; ++i) this.paint(i);
    const { hiddenCount } = this.selection;
    if (hiddenCount === this.linesHidden) return;
    this.linesHidden = hiddenCount;
    this.grid.setIndex(new BufferAttribute(gridLines(this.lattice.size, (i) => this.selection.isHidden(i)), 1));
  }

  /** Marks the point under the pointer, which a press would take. Returns whether it is another point. */
  hover(index: number | undefined): boolean {
    if (index === this.hovered) return false;
    const before = this.hovered;
    this.hovered = index;
    for (const changed of [before, index]) if (changed !== undefined) this.paint(changed);
    return true;
  }

  /** Marks the control points that no edit moves. */
  setHeld(held: ReadonlySet<number>): void {
    this.held = held;
    this.updateStates();
  }

  /** Shows what others have selected of this lattice. Returns whether that looks different than before. */
  setPresence(others: readonly Presence[]): boolean {
    this.others = others;
    return this.updateRings();
  }

  setStyle(style: CageStyle): void {
    this.colours = stateBytes(style);
    for (const material of this.discs) material.uniforms['rim'].value = style.rim;
    if (this.geometry.hasAttribute('disc')) this.updateStates();
  }

  setPixelRatio(ratio: number): void {
    for (const material of this.discs) material.uniforms['pixelRatio'].value = ratio;
  }

  /** Whether the parts behind the surface are shown, faintly. */
  setThrough(on: boolean): void {
    this.discs[1].visible = on;
    this.wires[1].visible = on;
  }

  dispose(): void {
    this.geometry.dispose();
    this.grid.dispose();
    for (const material of [...this.discs, ...this.wires]) material.dispose();
  }

  private addObjects(): void {
    const objects = [
      ...this.wires.map((material) => new LineSegments(this.grid, material)),
      ...this.discs.map((material) => new Points(this.geometry, material)),
    ];
    objects.forEach((object, order) => {
      object.frustumCulled = false; // positions change without new bounds
      object.renderOrder = 10 + order;
    });
    this.object.add(...objects);
  }

  private paint(index: number): void {
    const disc = this.geometry.getAttribute('disc') as BufferAttribute;
    const colour = this.grid.getAttribute('color') as BufferAttribute;
    const state = this.stateOf(index);
    const [r, g, b] = this.colours[state];
    const diameter = DIAMETERS[state] * (this.lattice.count > CROWD ? CROWDED : 1);
    (disc.array as Uint8Array).set([r, g, b, this.selection.isHidden(index) ? 0 : diameter], 4 * index);
    (colour.array as Uint8Array).set(state === 'hover' ? this.colours.plain : [r, g, b], 3 * index);
    disc.needsUpdate = true;
    colour.needsUpdate = true;
  }

  private stateOf(index: number): PointState {
    if (index === this.hovered) return 'hover';
    if (!this.selection.has(index)) return this.held.has(index) ? 'held' : 'plain';
    return index === this.selection.active ? 'active' : 'selected';
  }

  private updateRings(): boolean {
    const ring = this.geometry.getAttribute('ring') as BufferAttribute;
    const array = ring.array as Uint8Array;
    const before = array.slice();
    array.fill(0);
    for (const { colour, selected } of this.others) {
      const rgb = bytes(new Color(colour));
      for (const index of selected) if (index < this.lattice.count) array.set([...rgb, 255], 4 * index);
    }
    if (array.every((byte, i) => byte === before[i])) return false;
    ring.needsUpdate = true;
    return true;
  }
}

function dynamic(array: Float32Array | Uint8Array, size: number, normalized = false): BufferAttribute {
  const attribute = new BufferAttribute(array, size, normalized);
  attribute.setUsage(DynamicDrawUsage);
  return attribute;
}

function stateBytes({ colours }: CageStyle): Record<PointState, [number, number, number]> {
  const { plain, held, selected, active, hover } = colours;
  return { plain: bytes(plain), held: bytes(held), selected: bytes(selected), active: bytes(active), hover: bytes(hover) };
}

/** In the working colour space, which three expects of vertex colours. */
function bytes(colour: Color): [number, number, number] {
  return [colour.r * 255, colour.g * 255, colour.b * 255].map(Math.round) as [number, number, number];
}
