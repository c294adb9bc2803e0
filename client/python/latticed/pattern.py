# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The points and triangles of one patch."""
from __future__ import annotations

from typing import Any

import numpy as np

from latticed.errors import LatticedError


class PatchPattern:
    """Immutable. With a tolerance, patches have different patterns; else all have the topology's.

    weights      (q, 3): barycentrics of the patch's points in its three corners: points / denominator
    triangles    (t, 3): indices of these points, counter-clockwise from outside
    points       (q, 3): whole numbers whose sum is denominator
    denominator  segments of an edge; with a tolerance, a power of two
    """

    def __init__(self, points: Any, triangles: Any, denominator: int) -> None:
        if denominator < 1 or len(points) % 3 or len(triangles) % 3:
            raise LatticedError.data_loss("a pattern contradicts itself")
        self.points = np.array(points, dtype=np.int64).reshape(-1, 3)
        self.denominator = denominator
        self.weights = self.points / denominator
        self.triangles = np.array(triangles, dtype=np.uint32).reshape(-1, 3)
        if self.triangles.size and self.triangles.max() >= len(self.weights):
            raise LatticedError.data_loss("a pattern contradicts itself")

    def __len__(self) -> int:
        """The number of points."""
        return len(self.weights)
