// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The surface of a watcher: takes SceneEvents, returns complete updates. An update replaces only the
// chunks it holds, and only when it has ended.
import type { Chunks__Output } from './generated/latticed/v1/Chunks.js';
import type { Quantisation__Output } from './generated/latticed/v1/Quantisation.js';
import type { SceneEvent__Output } from './generated/latticed/v1/SceneEvent.js';
import type { Topology__Output } from './generated/latticed/v1/Topology.js';
import type { UpdateEnd__Output } from './generated/latticed/v1/UpdateEnd.js';
import type { DracoPoints, Points } from './draco_points.js';

type Triple = readonly [number, number, number];
interface HeldChunk extends Points {
  origin: Triple;
}

export interface Update {
  end: UpdateEnd__Output;
  chunks: number;  // how many the update held
  bytes: number;   // of chunk data
}

export class Surface {
  controlPoints: number[] = [];  // x y z of each, u fastest, after the newest reported edit
  size: Triple = [0, 0, 0];      // of the lattice: control points of u, v, w
  structureId = 0;
  topology: Topology__Output | undefined;
  private number = 0;            // of the lattice in the scene
  private announced = new Map<string, Topology__Output>();
  private grid: Quantisation__Output | undefined;
  private begun = new Map<number, HeldChunk>();
  private begunTopology = '';
  private begunBytes = 0;
  private held: HeldChunk[] = [];

  constructor(private readonly draco: DracoPoints) {}

  /** Takes one event; returns an update if the event completes it. */
  async take(event: SceneEvent__Output): Promise<Update | undefined> {
    if (event.latticeState?.lattice && event.latticeState.index === (event.latticeState.indexes[0] ?? 0)) {  // of several, the first
      const { controlPoints, size } = event.latticeState.lattice;
      this.controlPoints = [...controlPoints];
      this.size = [size?.u ?? 0, size?.v ?? 0, size?.w ?? 0];
      this.structureId = event.latticeState.structureId;
      this.number = event.latticeState.index;
    } else if (event.latticeDelta?.structureId === this.structureId && event.latticeDelta.lattice === this.number) {  // otherwise a latticeState follows
      const { indices, positions } = event.latticeDelta;
      indices.forEach((index, i) => this.controlPoints.splice(3 * index, 3, ...positions.slice(3 * i, 3 * i + 3)));
    } else if (event.topology) {
      this.announced.set(event.topology.topologyId, event.topology);
    } else if (event.quantisation) {
      this.grid = event.quantisation;
    } else if (event.updateBegin) {
      this.begun.clear();
      this.begunTopology = '';
      this.begunBytes = 0;
    } else if (event.chunks) {
      await this.decode(event.chunks);
    } else if (event.updateEnd) {
      return this.complete(event.updateEnd);
    }
    return undefined;
  }

  /** The smallest and largest world coordinates of all points. */
  bounds(): { low: number[]; high: number[] } {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (const { positions, origin } of this.held) {
      for (let i = 0; i < positions.length; ++i) {
        const axis = i % 3;
        const value = origin[axis as 0 | 1 | 2] + (positions[i] as number);
        low[axis] = Math.min(low[axis] as number, value);
        high[axis] = Math.max(high[axis] as number, value);
      }
    }
    return { low, high };
  }

  get points(): number {
    return this.held.reduce((sum, chunk) => sum + chunk.positions.length / 3, 0);
  }

  private async decode({ topologyId, chunks }: Chunks__Output): Promise<void> {
    const { grid } = this, topology = this.announced.get(topologyId);
    if (!grid || !topology) throw new Error('chunks came before their topology and quantisation');
    const { x, y, z } = grid.origin ?? { x: 0, y: 0, z: 0 };
    const perPatch = topology.pointCount / topology.patchCount;
    const points = topology.chunkRuns.flatMap((run) => Array<number>(run.chunkCount).fill(run.patchesPerChunk * perPatch));
    const decoded = await this.draco.decode(chunks.map(({ index, data }) => ({ data, points: points[index] ?? 0 })), grid);
    chunks.forEach(({ index, data }, i) => {
      this.begun.set(index, { ...decoded[i]!, origin: [x, y, z] });
      this.begunBytes += data.length;
    });
    this.begunTopology = topologyId;
  }

  private complete(end: UpdateEnd__Output): Update {
    const topology = this.announced.get(this.begunTopology);
    if (topology && topology.topologyId !== this.topology?.topologyId) {
      this.topology = topology;
      this.held = [];
    }
    for (const [index, chunk] of this.begun) this.held[index] = chunk;
    return { end, chunks: this.begun.size, bytes: this.begunBytes };
  }
}
