# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""How an editor looks at a scene."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional, Tuple

from latticed.lattice import vector
from latticed.v1 import event_pb2

Vector = Tuple[float, float, float]


@dataclass(frozen=True)
class Camera:
    """A camera that others may follow, in world units. It is perspective with `fov_y`, or orthographic with `height`."""

    position: Vector
    target: Vector  # in the middle of the picture; not the position
    up: Vector  # a direction of any length; not zero
    fov_y: Optional[float] = None  # vertical angle of view in degrees, 0.01 to 179
    height: Optional[float] = None  # of the picture, 1e-15 to 1e15

    @classmethod
    def from_proto(cls, camera: Any) -> Camera:
        """Converts a latticed.v1.Camera."""
        position, target, up = ((v.x, v.y, v.z) for v in (camera.position, camera.target, camera.up))
        fov_y = camera.fov_y if camera.HasField("fov_y") else None
        height = camera.height if camera.HasField("height") else None
        return cls(position, target, up, fov_y, height)

    def to_proto(self) -> event_pb2.Camera:
        """Raises ValueError unless exactly one of fov_y and height is given."""
        if (self.fov_y is None) == (self.height is None):
            raise ValueError("a camera needs either fov_y or height")
        position, target, up = (vector(v) for v in (self.position, self.target, self.up))
        return event_pb2.Camera(position=position, target=target, up=up, fov_y=self.fov_y, height=self.height)
