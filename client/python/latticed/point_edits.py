# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The edits that move control points, for whatever applies edits."""
from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Generic, Sequence, TypeVar, Union

import numpy.typing as npt

from latticed import edits
from latticed.surface_point import SurfacePoint
from latticed.v1 import edit_pb2

Applied = TypeVar("Applied")


class PointEdits(ABC, Generic[Applied]):
    """One edit a call; apply says what comes of it."""

    @abstractmethod
    def apply(self, changes: Sequence[edit_pb2.Edit]) -> Applied:
        """Applies several of latticed.edits at once."""

    def set_points(self, points: npt.ArrayLike, positions: npt.ArrayLike) -> Applied:
        """Puts control points at positions, shape (points, 3), world units."""
        return self.apply([edits.set_points(points, positions)])

    def move(self, points: npt.ArrayLike, offset: npt.ArrayLike) -> Applied:
        """Moves control points by one offset: x, y, z, world units."""
        return self.apply([edits.move(points, offset)])

    def transform(self, points: npt.ArrayLike, matrix: npt.ArrayLike) -> Applied:
        """Transforms control points by an affine 4 x 4 matrix that acts on columns (x, y, z, 1)."""
        return self.apply([edits.transform(points, matrix)])

    def replace(self, control_points: npt.ArrayLike) -> Applied:
        """Puts all control points at positions: shape (nw, nv, nu, 3), world units."""
        return self.apply([edits.replace(control_points)])

    def drag(self, points: Union[SurfacePoint, Sequence[SurfacePoint]], targets: npt.ArrayLike) -> Applied:
        """Moves control points as little as takes points of the surface, those of Scene.pick for instance, to
        targets, shape (points, 3), world units."""
        return self.apply([edits.drag(points, targets)])
