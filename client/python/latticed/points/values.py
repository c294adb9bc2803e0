# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""What point sets answer, as numpy arrays."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class PointValues:
    """Deformed points, or their velocities.

    positions     (n, 3), world units; (N, n, 3) of N directions
    normals       the same shape, of unit length, 0 0 0 where undefined; None if they were not asked for
    revision      the scene's revision that was evaluated
    structure_id  of that revision
    """

    positions: FloatArray
    normals: Optional[FloatArray]
    revision: int
    structure_id: int


@dataclass(frozen=True)
class PointGradients:
    """Derivatives by control points.

    gradients     (control points, 3) in the order of Lattice.control_points.reshape(-1, 3);
                  (N, control points, 3) of N directions
    revision      the scene's revision that was evaluated
    structure_id  of that revision
    """

    gradients: FloatArray
    revision: int
    structure_id: int
