# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The whole surface at one revision."""
from __future__ import annotations

import functools
from typing import Any, List, Sequence

import numpy as np
import numpy.typing as npt

from latticed.chunk import Chunk
from latticed.topology import Topology
from latticed.view import View


class Update:
    """A complete update: never partial, and never changed once it is here.

    revision, head_revision  of this surface, and the scene's newest when it was sent
    applied_sequence         the last edit of this stream's editor that it holds; 0: none
    view                     what was asked for, every field filled in
    timings                  where the server's time went: latticed.v1.UpdateTimings, microseconds
    topology                 points and triangles of a patch, and which patches are in which chunk

    Points are decoded on first use: a skipped update costs nothing.
    """

    def __init__(self, end: Any, view: View, topology: Topology, chunks: Sequence[Chunk]) -> None:
        self.revision = int(end.revision)
        self.head_revision = int(end.head_revision)
        self.applied_sequence = int(end.applied_sequence)
        self.full_detail = bool(end.full_detail)
        self.timings = end.timings
        self.view = view
        self.topology = topology
        self._chunks = chunks

    def __repr__(self) -> str:
        return f"<Update: revision {self.revision}, {self.topology.patches} patches>"

    @property
    def final(self) -> bool:
        """Whether it was the scene's newest state, in all the detail that the view asks for."""
        return self.revision == self.head_revision and self.full_detail

    @property
    def bytes(self) -> int:
        """The bytes of all chunks, as they were sent."""
        return sum(len(chunk.data) for chunk in self._chunks)

    @functools.cached_property
    def points(self) -> npt.NDArray[np.float64]:
        """(patches, q, 3), world units; q points a patch, in the order of topology.weights."""
        return self._shaped([chunk.origin + chunk.decoded[0].astype(float) for chunk in self._chunks])

    @property
    def origin(self) -> npt.NDArray[np.float64]:
        """The origin of relative_points, x, y, z."""
        return self._chunks[0].origin

    @property
    def step(self) -> float:
        """World units per integer: points are within half of it on each axis. 0 for raw, which has no grid."""
        return max(chunk.step for chunk in self._chunks)

    @functools.cached_property
    def relative_points(self) -> npt.NDArray[np.float32]:
        """points - origin in single precision: for graphics, where world coordinates are large."""
        parts = [chunk.decoded[0] + (chunk.origin - self.origin) for chunk in self._chunks]
        return self._shaped(parts).astype(np.float32)

    @functools.cached_property
    def normals(self) -> npt.NDArray[np.float32] | None:
        """(patches, q, 3), unit vectors; None where the view has none."""
        parts = [chunk.decoded[1] for chunk in self._chunks]
        return None if any(part is None for part in parts) else self._shaped(parts)

    @property
    def triangles(self) -> npt.NDArray[np.uint32]:
        """(triangles, 3): numbers of points in points.reshape(-1, 3), counter-clockwise from outside."""
        return self.topology.triangles

    @property
    def chunk_revisions(self) -> npt.NDArray[np.int64]:
        """For each chunk the revision at which its bytes last changed."""
        return np.array([chunk.revision for chunk in self._chunks])

    def changed_since(self, earlier: Update) -> List[int]:
        """The chunks that came since an earlier update of the same stream; all, under another topology."""
        if earlier.topology.id != self.topology.id:
            return list(range(self.topology.chunks))
        return [i for i, chunk in enumerate(self._chunks) if chunk is not earlier._chunks[i]]

    def _shaped(self, parts: List[Any]) -> npt.NDArray[Any]:
        return np.concatenate(parts).reshape(self.topology.patches, -1, 3)
