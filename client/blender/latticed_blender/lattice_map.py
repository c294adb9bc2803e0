# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Converts a lattice object of Blender to a latticed lattice with the same deformation at every mesh point.

Everything is in the mesh object's own space, as in Blender's lattice modifier, so moving both objects
together changes nothing. axis_map says how each interpolation is converted.
"""
from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Tuple

import latticed
import numpy as np
import numpy.typing as npt

from .axis_map import AxisMap, map_axis

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class BlenderLattice:
    """rest, deformed  (nw, nv, nu, 3): its points at rest, a grid along the axes, and as edited; own space
    interpolation   of u, v, w: "KEY_BSPLINE", …
    to_mesh         4 x 4 matrix for column vectors, from the lattice's own space to the mesh object's
    strength        how much of the deformation the mesh takes, 0 to 1
    """

    rest: FloatArray
    deformed: FloatArray
    interpolation: Tuple[str, str, str]
    to_mesh: FloatArray
    strength: float = 1.0

    @property
    def counts(self) -> Tuple[int, int, int]:
        nw, nv, nu = self.rest.shape[:3]
        return (nu, nv, nw)

    @property
    def first(self) -> FloatArray:
        """The first point at rest, x, y, z."""
        return self.rest[0, 0, 0]

    @property
    def spacing(self) -> FloatArray:
        """The distance between points on each axis; 1 on an axis of one point."""
        steps = self.rest[-1, -1, -1] - self.first
        return np.array([step / (n - 1) if n > 1 else 1.0 for step, n in zip(steps, self.counts)])

    def same(self, other: BlenderLattice) -> bool:
        same_points = np.array_equal(self.deformed, other.deformed)
        return self.same_structure(other) and same_points and self.strength == other.strength

    def same_structure(self, other: BlenderLattice) -> bool:
        """Whether the two differ at most in their control points and strength."""
        return (
            self.interpolation == other.interpolation
            and self.rest.shape == other.rest.shape
            and np.array_equal(self.rest, other.rest)
            and np.array_equal(self.to_mesh, other.to_mesh)
        )


class LatticeMap:
    """Maps Blender lattices of one structure to latticed's lattice, which covers one mesh.

    ValueError if the lattice or its object has no volume."""

    def __init__(self, grid: BlenderLattice, mesh_positions: npt.ArrayLike) -> None:
        self._linear = grid.to_mesh[:3, :3]
        if np.any(grid.spacing == 0) or abs(np.linalg.det(self._linear)) < np.finfo(np.float32).tiny:
            raise ValueError("the lattice is flat: its scale, or that of its points, is zero on an axis")
        local = np.linalg.solve(self._linear, (np.asarray(mesh_positions) - grid.to_mesh[:3, 3]).T).T
        places = (local - grid.first) / grid.spacing
        bounds = zip(grid.interpolation, grid.counts, places.min(axis=0), places.max(axis=0))
        self._axes: Tuple[AxisMap, ...] = tuple(map_axis(*of_axis) for of_axis in bounds)
        begin, end = np.array([axis.domain for axis in self._axes]).T
        origin = grid.to_mesh @ np.append(grid.first + begin * grid.spacing, 1.0)
        u, v, w = self._axes
        self._rest = latticed.Lattice(
            control_points=np.zeros((len(w.weights), len(v.weights), len(u.weights), 3)),
            degree=(u.degree, v.degree, w.degree),
            knots=(u.knots, v.knots, w.knots),
            origin=origin[:3],
            edges=np.diag((end - begin) * grid.spacing) @ self._linear.T,
        )
        self._rest.control_points = self._rest.rest()

    def control_points(self, grid: BlenderLattice) -> FloatArray:
        """latticed's control points, (nw, nv, nu, 3), for another state of the same lattice."""
        moved = (grid.deformed - grid.rest) @ self._linear.T
        u, v, w = (axis.weights for axis in self._axes)
        for weights, axis in ((u, 2), (v, 1), (w, 0)):
            moved = np.moveaxis(np.tensordot(weights, moved, (1, axis)), 0, axis)
        return self._rest.control_points + moved

    def lattice(self, grid: BlenderLattice) -> latticed.Lattice:
        """Like control_points, but with degrees, knots, frame and strength."""
        rest = self._rest
        points = self.control_points(grid)
        return dataclasses.replace(rest, control_points=points, strength=grid.strength)
