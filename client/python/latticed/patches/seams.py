# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Where patches inside and outside the frame meet."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, List

import numpy as np
import numpy.typing as npt

from latticed.errors import LatticedError
from latticed.lattice import Lattice

Integers = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class PatchSeams:
    """ranges           (seams, 3, 2): a seam's first and last control point on each axis of the lattice
    vertices         the vertices on a seam, ascending; vertex_seams the seam of each
    outside_places   (vertices on a seam, 3): where they lie in the outside box
    edges            the edges on a seam, ascending; edge_seams the seam of each
    identity_points  (control points, 3): where the lattice leaves the mesh as it is, world units
    """

    ranges: Integers
    vertices: Integers
    vertex_seams: Integers
    outside_places: Integers
    edges: Integers
    edge_seams: Integers
    identity_points: npt.NDArray[np.float64]

    def attached(self, lattice: Lattice) -> npt.NDArray[np.bool_]:
        """(seams,): whether all of a seam's control points are at their identity points, compared exactly."""
        if not len(self.ranges):
            return np.zeros(0, dtype=bool)
        shape = lattice.control_points.shape
        if (
            self.identity_points.size != lattice.control_points.size
            or (self.ranges.max(axis=(0, 2)) >= np.array(lattice.size)).any()
        ):
            raise LatticedError.data_loss("the seams of a patch plan are those of another lattice")
        moved = (lattice.control_points != self.identity_points.reshape(shape)).any(axis=-1)
        return np.array(
            [not moved[k : n + 1, j : m + 1, i : l + 1].any() for (i, l), (j, m), (k, n) in self.ranges]
        )

    @classmethod
    def from_parts(cls, parts: List[Any]) -> PatchSeams:
        """Joins the latticed.v1.PatchSeams messages of a plan. DATA_LOSS if their arrays contradict each other."""

        def joined(name: str, *shape: int) -> Integers:
            numbers = [np.array(getattr(part, name), dtype=np.int64) for part in parts]
            flat = np.concatenate([np.zeros(0, dtype=np.int64), *numbers])
            if len(flat) % int(np.prod(shape)):
                raise LatticedError.data_loss("the seams of a patch plan are incomplete")
            return np.asarray(flat.reshape(-1, *shape))

        points = [np.array(part.identity_points, dtype=float) for part in parts]
        seams = cls(
            joined("ranges", 3, 2),
            joined("vertices"),
            joined("vertex_seams"),
            joined("outside_places", 3),
            joined("edges"),
            joined("edge_seams"),
            np.concatenate([np.zeros(0), *points]).reshape(-1, 3),
        )
        same = len(seams.vertices) == len(seams.vertex_seams) == len(seams.outside_places)
        named = np.concatenate([seams.vertex_seams, seams.edge_seams])
        ascending = (np.diff(seams.vertices) > 0).all() and (np.diff(seams.edges) > 0).all()
        if not same or len(seams.edges) != len(seams.edge_seams) or not ascending:
            raise LatticedError.data_loss("the seams of a patch plan contradict each other")
        if named.size and named.max() >= len(seams.ranges):
            raise LatticedError.data_loss("a patch plan names a seam that it does not hold")
        return seams
