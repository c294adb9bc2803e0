# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Values of deformed points as functions of free control points, as scipy.optimize.minimize takes them.

    from latticed.scipy import Shape

    with scene.points(nodes) as points:
        shape = Shape(scene, points)
        best = minimize(shape.objective(lambda x: (((x - target) ** 2).sum(), 2 * (x - target))), shape.start, jac=True)

This module itself needs numpy alone.
"""
from __future__ import annotations

from typing import Any, Callable, Dict, Optional, Tuple

import numpy as np
import numpy.typing as npt

from latticed.points.point_set import PointSet
from latticed.points.values import FloatArray
from latticed.scene import Scene

# From deformed points, (n, 3), to a value and its derivative by them, (n, 3).
PointFunction = Callable[[FloatArray], Tuple[float, FloatArray]]


class Shape:
    """The deformed points of a set as a function of a vector x: the coordinates of the free control points.

    start       x of the scene's present lattice
    positions   of the points at the last x
    One thread at a time may use it. While it is used, nobody else edits the scene.
    """

    def __init__(
        self, scene: Scene, points: PointSet, free: Optional[npt.ArrayLike] = None, lattice: int = 0
    ) -> None:
        """
        free     indices of the control points that move (Lattice.indices), or a mask of the shape (nw, nv, nu); None: all
        lattice  which one has these control points, from 0, where the scene has several
        """
        self._edits, self._points, self._number = scene.edits_of(lattice), points, lattice
        self._lattice = scene.lattice(lattice)
        indices = self._lattice.indices
        chosen = indices if free is None else np.asarray(free)
        self._free: npt.NDArray[np.int64] = (indices[chosen] if chosen.dtype == bool else chosen).reshape(-1)
        self._control_points = self._lattice.control_points.reshape(-1, 3).copy()
        self.start: FloatArray = self._control_points[self._free].reshape(-1)
        self._at: Optional[bytes] = None
        self._revision = 0
        self.positions: FloatArray = np.empty((0, 3))

    def move(self, x: npt.ArrayLike) -> FloatArray:
        """Puts the free control points at x and returns the deformed points. The same x again calls no server."""
        flat: FloatArray = np.asarray(x, dtype=float).reshape(-1)
        if flat.tobytes() != self._at:
            self._control_points[self._free] = flat.reshape(-1, 3)
            result = self._edits.replace(self._control_points.reshape(self._lattice.control_points.shape))
            values = self._points.deform(revision=result.revision)
            self.positions, self._revision, self._at = values.positions, values.revision, flat.tobytes()
        return self.positions

    def pull_back(self, x: npt.ArrayLike, cotangents: npt.ArrayLike) -> FloatArray:
        """The derivative by x of a value whose derivative by the deformed points is `cotangents`, (n, 3)."""
        self.move(x)
        gradients = self._points.vjp(cotangents, revision=self._revision, lattice=self._number).gradients
        return gradients[self._free].reshape(-1)

    def objective(self, function: PointFunction) -> Callable[[FloatArray], Tuple[float, FloatArray]]:
        """A value with its gradient, for scipy.optimize.minimize(…, jac=True)."""

        def value_and_gradient(x: FloatArray) -> Tuple[float, FloatArray]:
            value, cotangents = function(self.move(x))
            return value, self.pull_back(x, cotangents)

        return value_and_gradient

    def constraint(self, function: PointFunction, kind: str = "eq") -> Dict[str, Any]:
        """function = 0, or with "ineq" function >= 0, as the methods SLSQP and trust-constr take it."""
        return {
            "type": kind,
            "fun": lambda x: function(self.move(x))[0],
            "jac": lambda x: self.pull_back(x, function(self.move(x))[1]),
        }
