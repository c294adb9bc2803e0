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

from latticed.freedom import lattice_and_freedom
from latticed.points.point_set import PointSet
from latticed.points.values import FloatArray
from latticed.scene import Scene

# From deformed points, (n, 3), to a value and its derivative by them, (n, 3).
PointFunction = Callable[[FloatArray], Tuple[float, FloatArray]]


class Shape:
    """The deformed points of a set as a function of a vector x: the coordinates of the free control points.

    start       x of the scene's present lattice
    positions   of the points at the last x
    What the lattice's constraints hold or mirror is a part of the function: an edit puts control points where they allow, and
    the derivative by x follows that, exactly. A lattice that keeps its volume is refused, ValueError: see kept_volume.
    One thread at a time may use it. While it is used, nobody else edits the scene.
    """

    def __init__(
        self, scene: Scene, points: PointSet, free: Optional[npt.ArrayLike] = None, lattice: int = 0
    ) -> None:
        """
        free     indices of the control points that move (Lattice.indices), or a mask of the shape (nw, nv, nu); None: all
        lattice  which one has these control points, from 0, where the scene has several
        """
        self._scene, self._points, self._number = scene, points, lattice
        self._edits = scene.edits_of(lattice)
        read, self._freedom = lattice_and_freedom(scene, lattice)
        indices = read.indices
        chosen = indices if free is None else np.asarray(free)
        each = indices if chosen.dtype == bool else indices.reshape(-1)
        self._free: npt.NDArray[np.int64] = each[chosen].reshape(-1)
        self.start: FloatArray = read.control_points.reshape(-1, 3)[self._free].reshape(-1)
        self._at: Optional[bytes] = None
        self._revision = 0
        self.positions: FloatArray = np.empty((0, 3))
        self._measured_at: Optional[bytes] = None
        self._measured: Tuple[float, FloatArray] = (0.0, np.empty(0))

    def move(self, x: npt.ArrayLike) -> FloatArray:
        """Puts the free control points at x and returns the deformed points. The same x again calls no server."""
        flat: FloatArray = np.asarray(x, dtype=float).reshape(-1)
        if flat.tobytes() != self._at:
            result = self._edits.set_points(self._free, flat.reshape(-1, 3))
            values = self._points.deform(revision=result.revision)
            self.positions, self._revision, self._at = values.positions, values.revision, flat.tobytes()
        return self.positions

    def pull_back(self, x: npt.ArrayLike, cotangents: npt.ArrayLike) -> FloatArray:
        """The derivative by x of a value whose derivative by the deformed points is `cotangents`, (n, 3)."""
        self.move(x)
        gradients = self._points.vjp(cotangents, revision=self._revision, lattice=self._number).gradients
        return self._freedom.pull_back(gradients, self._free).reshape(-1)

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

    def kept_volume(self, volume: Optional[float] = None) -> Dict[str, Any]:
        """The constraint that the exact surface encloses a volume, in place of Constraints.keep_volume: as `constraint`,
        with the gradient of Scene.measure.

        volume  world units cubed; None: the present one. Of an open surface: LatticedError, reason OPEN_SURFACE
        """
        kept = self._scene.measure("volume").volume if volume is None else volume
        assert kept is not None

        def measured(x: npt.ArrayLike) -> Tuple[float, FloatArray]:
            self.move(x)
            if self._measured_at != self._at:
                got = self._scene.measure("volume", with_gradient=True, lattice=self._number)
                assert got.volume is not None and got.volume_gradient is not None
                gradient = self._freedom.pull_back(got.volume_gradient, self._free).reshape(-1)
                self._measured, self._measured_at = (got.volume, gradient), self._at
            return self._measured

        return {
            "type": "eq",
            "fun": lambda x: measured(x)[0] / kept - 1,
            "jac": lambda x: measured(x)[1] / kept,
        }
