# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""A mesh of Blender as arrays: what the server gets of it, and what the result takes over. It does not use Blender."""
from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Optional

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True, eq=False)
class SourceMesh:
    """positions     (vertices, 3), the mesh object's space
    faces         (faces, k), or a list of sequences of any length
    crease_angle  smooth normals are split where faces meet at more than these degrees
    uvs           (corners, 2), of the active layer, face by face; None: there is none
    uv_name       that layer's name
    materials     (faces,): each face's index in the list of materials; None: all are 0
    smooth        (faces,): whether Blender shades the face smooth; None: all are
    weights       (vertices,): how much of the deformation each takes, 0 to 1; None: all of it
    """

    positions: npt.NDArray[np.float32]
    faces: Any
    crease_angle: float = 180.0
    uvs: Optional[npt.NDArray[np.float32]] = None
    uv_name: str = ""
    materials: Optional[npt.NDArray[np.int32]] = None
    smooth: Optional[npt.NDArray[np.bool_]] = None
    weights: Optional[npt.NDArray[np.float32]] = None

    @property
    def corners(self) -> npt.NDArray[np.int64]:
        """The vertex of each corner, face by face."""
        return np.concatenate(self.faces).astype(np.int64)

    def same(self, other: SourceMesh) -> bool:
        return len(self.faces) == len(other.faces) and all(
            _same(getattr(self, field.name), getattr(other, field.name)) for field in fields(self)
        )


def _same(ours: Any, theirs: Any) -> bool:
    if isinstance(ours, list) and isinstance(theirs, list):  # faces of any length
        return all(np.array_equal(a, b) for a, b in zip(ours, theirs))
    return type(ours) is type(theirs) and np.array_equal(ours, theirs)
