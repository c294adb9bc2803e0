# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The layout of a view's points and triangles. It is the same for every update until knots or segments
change."""
from __future__ import annotations

import functools
from typing import Any

import numpy as np
import numpy.typing as npt


class Topology:
    """Patches that all have the points and triangles of one pattern.

    id        depends only on mesh, knots, frame and segments
    patches   the number of patches
    segments  subdivisions of a patch's edge, s
    weights   (q, 3) with q = (s + 1)(s + 2) / 2: barycentrics of a patch's points in its three corners
    pattern   (s squared, 3): triangles of a patch, counter-clockwise from outside
    """

    def __init__(self, topology: Any) -> None:
        self.id = str(topology.topology_id)
        self.patches = int(topology.patch_count)
        self.segments = int(topology.segments)
        self.weights = np.array(topology.pattern.points, dtype=float).reshape(-1, 3) / self.segments
        self.pattern = np.array(topology.pattern.triangles, dtype=np.uint32).reshape(-1, 3)
        sizes = [run.patches_per_chunk for run in topology.chunk_runs for _ in range(run.chunk_count)]
        self._begins = np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)])

    @property
    def chunks(self) -> int:
        """The number of chunks, the runs of patches that are sent together."""
        return len(self._begins) - 1

    def patches_of(self, chunk: int) -> slice:
        """The patches of a chunk: update.points[topology.patches_of(chunk)]."""
        return slice(int(self._begins[chunk]), int(self._begins[chunk + 1]))

    @functools.cached_property
    def triangles(self) -> npt.NDArray[np.uint32]:
        """The triangles of the whole surface, (triangles, 3): indices into update.points.reshape(-1, 3)."""
        first = np.arange(self.patches, dtype=np.uint32) * np.uint32(len(self.weights))
        return (first[:, None, None] + self.pattern).reshape(-1, 3)
