# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The whole surface at one revision."""
from __future__ import annotations

import functools
from typing import Any, List, Optional, Sequence

import numpy as np
import numpy.typing as npt

from latticed.chunk import Chunk, decode_together
from latticed.lattice import Lattice
from latticed.pattern import PatchPattern
from latticed.topology import Topology
from latticed.view import View


class Update:
    """A complete update. It never changes.

    revision, head_revision  of this surface, and the scene's newest when it was sent
    applied_sequence         the last edit of this stream's editor that it holds; 0: none
    view                     the requested view, with every field filled in
    timings                  times on the server: latticed.v1.UpdateTimings, microseconds
    topology                 points and triangles of a patch, and the patches of each chunk
    certified_error          with a tolerance: the largest distance, both ways, between the exact surface and
                             the triangles, rounding included, in world units; it covers positions, not normals.
                             Else 0

    lattice                  the lattice at this revision; newer if the server skipped it: lattice.revision; None if
                             the stream has sent none. Of several lattices the first one, and with the encoding
                             "patches" their sum, which is one lattice

    Points are decoded at the first use, so a skipped update costs no decoding. With the encoding "patches" there are
    none: PatchEvaluator makes them from lattice and edge_bytes. What needs points then raises ValueError.
    """

    def __init__(
        self,
        end: Any,
        view: View,
        topology: Topology,
        chunks: Sequence[Chunk],
        lattice: Optional[Lattice] = None,
        bounds: bytes = b"",
    ) -> None:
        self.revision = int(end.revision)
        self.head_revision = int(end.head_revision)
        self.applied_sequence = int(end.applied_sequence)
        self.full_detail = bool(end.full_detail)
        self.timings = end.timings
        self.certified_error = float(end.certified_error)
        self.view = view
        self.topology = topology
        self.lattice = lattice
        self._chunks = chunks
        self._bounds = bounds

    def __repr__(self) -> str:
        return f"<Update: revision {self.revision}, {self.topology.patches} patches>"

    @property
    def final(self) -> bool:
        """Whether it was the scene's newest revision, in all the detail that the view asks for."""
        return self.revision == self.head_revision and self.full_detail

    @property
    def bytes(self) -> int:
        """The bytes of all chunks, as they were sent."""
        return len(self._bounds) + sum(len(chunk.data) for chunk in self._chunks)

    @functools.cached_property
    def edge_bytes(self) -> npt.NDArray[np.uint8]:
        """(edges,): with the encoding "patches", how much each edge of the plan bends: see PatchPlan.edge_bounds."""
        if self.view.encoding != "patches":
            raise ValueError(f"an update with the encoding {self.view.encoding!r} has no edge bytes")
        return np.frombuffer(self._bounds, np.uint8)

    @functools.cached_property
    def patterns(self) -> List[PatchPattern]:
        """The points and triangles of each patch."""
        self._check_points()
        return [pattern for chunk in self._chunks for pattern in chunk.patterns]

    @functools.cached_property
    def first_points(self) -> npt.NDArray[np.int64]:
        """(patches + 1,): patch p has the points first_points[p] to first_points[p + 1] of points.reshape(-1, 3)."""
        counts = [len(pattern) for pattern in self.patterns]
        return np.concatenate([[0], np.cumsum(counts, dtype=np.int64)])

    def points_of(self, chunk: int) -> npt.NDArray[np.float64]:
        """The points of one chunk's patches, (points, 3), world units."""
        self._check_points()
        held = self._chunks[chunk]
        return np.asarray(held.origin + held.decoded[0].astype(float))

    @functools.cached_property
    def points(self) -> npt.NDArray[np.float64]:
        """(patches, q, 3), world units; q points per patch, in the order of topology.weights. With a tolerance
        patches have different numbers of points: (points, 3), in the order of patterns."""
        return self._shaped([chunk.origin + chunk.decoded[0] for chunk in self._decoded_chunks()])

    @property
    def origin(self) -> npt.NDArray[np.float64]:
        """The origin of relative_points, x, y, z."""
        return self._chunks[0].origin

    @property
    def step(self) -> float:
        """The quantisation step in world units. Points are exact to half a step on each axis. 0 for raw."""
        return max(chunk.step for chunk in self._chunks)

    @functools.cached_property
    def relative_points(self) -> npt.NDArray[np.float32]:
        """points - origin in single precision, for graphics with large world coordinates."""
        parts = [chunk.decoded[0] + (chunk.origin - self.origin) for chunk in self._decoded_chunks()]
        return self._shaped(parts).astype(np.float32)

    @functools.cached_property
    def normals(self) -> npt.NDArray[np.float32] | None:
        """In the shape of points, unit vectors; None if the view has none."""
        parts = [chunk.decoded[1] for chunk in self._decoded_chunks()]
        return None if any(part is None for part in parts) else self._shaped(parts)

    @functools.cached_property
    def triangles(self) -> npt.NDArray[np.uint32]:
        """(triangles, 3): indices into points.reshape(-1, 3), counter-clockwise from outside."""
        if self.topology.uniform is not None:
            return self.topology.triangles
        firsts = self.first_points.astype(np.uint32)
        return np.concatenate([first + p.triangles for first, p in zip(firsts, self.patterns)])

    @property
    def chunk_revisions(self) -> npt.NDArray[np.int64]:
        """For each chunk, the revision at which its bytes last changed."""
        return np.array([chunk.revision for chunk in self._chunks])

    def changed_since(self, earlier: Update) -> List[int]:
        """The chunks received after an earlier update of the same stream; all if the topology has changed."""
        if earlier.topology.id != self.topology.id:
            return list(range(self.topology.chunks))
        return [i for i, chunk in enumerate(self._chunks) if chunk is not earlier._chunks[i]]

    def _decoded_chunks(self) -> Sequence[Chunk]:
        self._check_points()
        decode_together(self._chunks)
        return self._chunks

    def _check_points(self) -> None:
        if self.view.encoding == "patches":
            raise ValueError("an update with the encoding 'patches' has no points: PatchEvaluator makes them")

    def _shaped(self, parts: List[Any]) -> npt.NDArray[Any]:
        points = np.concatenate(parts)
        return points if self.topology.uniform is None else points.reshape(self.topology.patches, -1, 3)
