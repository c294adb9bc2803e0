# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Who is at a scene."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Tuple

from latticed.v1 import event_pb2


@dataclass(frozen=True)
class Presence:
    """What a stream shows of its editor with show(), and what others shows of other editors."""

    name: str = ""  # for people, at most 64 characters
    colour: int = 0  # 0xRRGGBB
    selected: Tuple[int, ...] = ()  # indices of control points, at most 1,024

    @classmethod
    def from_proto(cls, presence: Any) -> Presence:
        """Of a latticed.v1.Presence of somebody who is there."""
        return cls(presence.name, presence.colour, tuple(presence.selected_indices))

    def to_proto(self) -> event_pb2.Presence:
        return event_pb2.Presence(name=self.name, colour=self.colour, selected_indices=self.selected)
