# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The server's answer to edits."""
from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Optional

from latticed.folds import FoldReport


@dataclass(frozen=True)
class EditResult:
    """The result of a batch of edits that were all applied, as one revision."""

    sequence: int  # of this editor, from 1
    revision: int  # the scene's revision after the edits
    structure_id: int  # the lattice's structure after the edits
    boxes_touched: int  # knot boxes whose shape they changed
    patches_touched: int  # patches in those boxes
    largest_move: float  # the longest way of a control point, world units
    timings: Any  # times on the server: latticed.v1.EditTimings, microseconds
    drag_residual: float = 0.0  # largest distance that a drag left to a target, world units
    folds: Optional[FoldReport] = None  # near the surface; only of scenes with fold_watch

    @classmethod
    def from_proto(cls, result: Any) -> EditResult:
        """Converts a latticed.v1.EditResult that is not a refusal."""
        numbers = {field.name: getattr(result, field.name) for field in fields(cls)}
        numbers["folds"] = FoldReport.from_proto(result.folds) if result.HasField("folds") else None
        return cls(**numbers)
