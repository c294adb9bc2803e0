# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Points of the surface, named by their place in the source mesh."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional, Tuple

import numpy as np
import numpy.typing as npt

from latticed.v1 import surface_pb2


@dataclass(frozen=True)
class SurfacePoint:
    """A point of the surface. Scene.pick returns one, and drag takes them."""

    face: int  # of the source mesh
    corners: Tuple[int, int, int]  # three of that face, numbered as in Provenance
    barycentrics: Tuple[float, float, float]  # in the triangle of those corners
    position: Optional[npt.NDArray[np.float64]] = None  # deformed, world units; None: not known
    normal: Optional[npt.NDArray[np.float64]] = None  # unit, deformed; None: undefined or not known

    @classmethod
    def from_proto(cls, point: Any) -> SurfacePoint:
        """Converts a latticed.v1.SurfacePoint."""

        def array(name: str) -> Optional[npt.NDArray[np.float64]]:
            v = getattr(point, name)
            return np.array([v.x, v.y, v.z]) if point.HasField(name) else None

        a, b, c = point.corners
        x, y, z = point.barycentrics
        return cls(point.face, (a, b, c), (x, y, z), array("position"), array("normal"))

    def to_proto(self) -> surface_pb2.SurfacePoint:
        return surface_pb2.SurfacePoint(face=self.face, corners=self.corners, barycentrics=self.barycentrics)
