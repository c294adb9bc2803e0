# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The layout of a view's patches. It is the same for every update until knots or segments change."""
from __future__ import annotations

import functools
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from latticed.pattern import PatchPattern


class Topology:
    """Patches that all have the points and triangles of one pattern, or with a tolerance each its own.

    id        depends only on mesh, knots, frame and segments; the same for all views with a tolerance
    patches   the number of patches
    segments  subdivisions of a patch's edge, s; 0 with a tolerance
    weights   (q, 3) with q = (s + 1)(s + 2) / 2: barycentrics of a patch's points in its three corners
    pattern   (s squared, 3): triangles of a patch, counter-clockwise from outside
    uniform   both as one; None with a tolerance, when weights and pattern are empty: see Update.patterns
    """

    def __init__(self, topology: Any) -> None:
        self.id = str(topology.topology_id)
        self.patches = int(topology.patch_count)
        self.segments = int(topology.segments)
        pattern = PatchPattern(topology.pattern.points, topology.pattern.triangles, self.segments or 1)
        self.uniform: Optional[PatchPattern] = pattern if self.segments else None
        self.weights = pattern.weights
        self.pattern = pattern.triangles
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
        """The triangles of the whole surface, (triangles, 3): indices into update.points.reshape(-1, 3). Empty
        with a tolerance: see Update.triangles."""
        first = np.arange(self.patches, dtype=np.uint32) * np.uint32(len(self.weights))
        return (first[:, None, None] + self.pattern).reshape(-1, 3)
