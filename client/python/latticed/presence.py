# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The presence of editors at a scene."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional, Tuple

from latticed.camera import Camera
from latticed.v1 import event_pb2


@dataclass(frozen=True)
class Presence:
    """An editor as others see it. A stream's show() sends it; `others` has the presence of other editors."""

    name: str = ""  # for people, at most 64 characters
    colour: int = 0  # 0xRRGGBB
    selected: Tuple[int, ...] = ()  # indices of control points, at most 1,024
    camera: Optional[Camera] = None  # None: not shown
    following: str = ""  # the editor_id of the editor whose camera this one shows; empty: nobody's
    lattice: int = 0  # of `selected`, where the scene has several

    @classmethod
    def from_proto(cls, presence: Any) -> Presence:
        """Converts a latticed.v1.Presence of an editor who is present."""
        camera = Camera.from_proto(presence.camera) if presence.HasField("camera") else None
        selected = tuple(presence.selected_indices)
        return cls(presence.name, presence.colour, selected, camera, presence.following, presence.lattice)

    def to_proto(self) -> event_pb2.Presence:
        camera = None if self.camera is None else self.camera.to_proto()
        return event_pb2.Presence(
            name=self.name,
            colour=self.colour,
            selected_indices=self.selected,
            camera=camera,
            following=self.following,
            lattice=self.lattice,
        )
