# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Where a deformation folds."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Tuple

import numpy as np
import numpy.typing as npt

from latticed.v1 import fold_pb2


@dataclass(frozen=True)
class FoldedBox:
    """A knot box that folds (folded), or for which neither is proved."""

    folded: bool
    # Its number on each axis, from 0, among knot intervals that are not empty. Outside the first lattice: -1.
    box: Tuple[int, int, int]
    rest_point: npt.NDArray[np.float64]  # world units, before the deformation
    determinant: float  # det J there: 0 or below where the box is folded

    @classmethod
    def from_proto(cls, place: Any) -> FoldedBox:
        """Converts a latticed.v1.FoldedBox."""
        box, at = place.box, place.rest_point
        folded = place.state == fold_pb2.FOLD_STATE_FOLDED
        return cls(folded, (box.u, box.v, box.w), np.array([at.x, at.y, at.z]), place.determinant)


@dataclass(frozen=True)
class FoldReport:
    """Where the deformation turns space inside out: det J <= 0, J = d deformed / d rest. det J is 1 at rest.

    certified is a proof that det J > 0 everywhere in the scope. It does not exclude that distant parts of the
    surface pass through each other.
    """

    certified: bool
    revision: int  # examined
    structure_id: int  # of that revision
    boxes: int  # knot boxes in the scope
    folded: int  # of them
    undecided: int  # of them
    places: Tuple[
        FoldedBox, ...
    ]  # folded boxes, then undecided ones: the first 1,024, or 256 of an EditResult

    @classmethod
    def from_proto(cls, report: Any) -> FoldReport:
        """Converts a latticed.v1.FoldReport."""
        return cls(
            report.certified,
            report.revision,
            report.structure_id,
            report.boxes,
            report.folded,
            report.undecided,
            tuple(FoldedBox.from_proto(place) for place in report.places),
        )
