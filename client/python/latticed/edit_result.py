# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The server's answer to edits."""
from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any


@dataclass(frozen=True)
class EditResult:
    """Edits were applied: all of them, as one revision."""

    sequence: int  # of this editor, from 1
    revision: int  # the scene's after them
    structure_id: int  # the lattice's after them
    boxes_touched: int  # knot boxes whose shape they changed
    patches_touched: int  # patches in those boxes
    largest_move: float  # farthest that a control point went, world units
    timings: Any  # where the server's time went: latticed.v1.EditTimings, microseconds
    drag_residual: float = 0.0  # largest distance that a drag left to a target, world units

    @classmethod
    def from_proto(cls, result: Any) -> EditResult:
        """Converts a latticed.v1.EditResult that is not a refusal."""
        return cls(**{field.name: getattr(result, field.name) for field in fields(cls)})
