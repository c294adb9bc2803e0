# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Points and triangles that PatchEvaluator has made."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, List, Optional

import numpy as np
import numpy.typing as npt

from latticed.pattern import PatchPattern


@dataclass(frozen=True, eq=False, repr=False)
class PatchSurface:
    """The surface of one lattice, in the form of an Update with a tolerance.

    revision         of the lattice
    origin           (3,): of relative_points, world units
    relative_points  (points, 3): points - origin, as evaluated: in single precision unless double was asked for.
                     Points come patch after patch, in the order of each patch's pattern
    normals          in the shape of points: unit vectors, 0 0 0 where undefined; None if the plan has none
    patterns         of each patch
    first_points     (patches + 1,): patch p has the points first_points[p] to first_points[p + 1]
    """

    revision: int
    origin: npt.NDArray[np.float64]
    relative_points: npt.NDArray[Any]
    normals: Optional[npt.NDArray[Any]]
    patterns: List[PatchPattern]
    first_points: npt.NDArray[np.int64]

    def __repr__(self) -> str:
        return f"<PatchSurface: revision {self.revision}, {len(self.relative_points)} points>"

    @property
    def points(self) -> npt.NDArray[np.float64]:
        """(points, 3), world units."""
        return np.asarray(self.origin + self.relative_points.astype(float))

    @property
    def triangles(self) -> npt.NDArray[np.uint32]:
        """(triangles, 3): indices into points, counter-clockwise from outside."""
        firsts = self.first_points.astype(np.uint32)
        parts = [first + pattern.triangles for first, pattern in zip(firsts, self.patterns)]
        return np.concatenate([np.zeros((0, 3), dtype=np.uint32), *parts])
