# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The polynomials of all knot boxes that a plan's points lie in, rounded once to the precision of an evaluation."""
from __future__ import annotations

from typing import Any, List

import numpy as np
import numpy.typing as npt

from latticed.errors import LatticedError
from latticed.lattice import Lattice
from latticed.patches.box_polynomials import BoxPolynomials, derivative, horner
from latticed.patches.plan import PatchPlan

Integers = npt.NDArray[np.int64]

# Corners of a patch that a point can have weights at: one, two or all of them.
_SUBSETS = ([0], [1], [2], [0, 1], [1, 2], [2, 0], [0, 1, 2])


class BoxTable:
    """Immutable. All points are given by their spans and local coordinates, (points, 3) each."""

    def __init__(self, plan: PatchPlan, lattice: Lattice, dtype: Any) -> None:
        """LatticedError DATA_LOSS if the plan is that of other knots."""
        polynomials = BoxPolynomials(lattice, plan.origin)
        self._dtype = dtype
        self._counts = tuple(polynomials.span_counts.tolist())
        spans = plan.spans[: plan.inside]
        if (spans >= polynomials.span_counts).any():
            raise LatticedError.data_loss("a patch plan names spans that the lattice does not have")
        at_zero = (plan.corner_places[: plan.inside] == 0) & (spans > 0)[:, None]
        used = np.concatenate([spans, *(spans - at_zero[:, corners].all(axis=1) for corners in _SUBSETS)])
        self._numbers = np.unique(np.ravel_multi_index(tuple(used.T), self._counts))
        boxes = np.stack(np.unravel_index(self._numbers, self._counts), axis=-1)
        coefficients = polynomials.coefficients(boxes)
        columns = [derivative(coefficients, axis) for axis in range(3)]
        # Common factors of J and h keep the direction of normals, and its squares in range.
        centres, steps = polynomials.at_rest(boxes)
        factors = [*columns, steps] if plan.weights is not None else columns
        largest = max(np.abs(factor).max(initial=0.0) for factor in factors)
        self._largest = largest or 1.0
        self._centres, self._steps = centres.astype(dtype), steps.astype(dtype)
        rest = steps * np.sign(np.linalg.det(lattice.edges))
        self._position: npt.NDArray[Any] = coefficients.astype(dtype)
        self._columns: List[npt.NDArray[Any]] = [(column / self._largest).astype(dtype) for column in columns]
        self._rest_steps = rest / (np.abs(rest).max(initial=0.0) or 1.0)

    def positions(self, spans: Integers, local: npt.NDArray[Any], weight: Any = None) -> npt.NDArray[Any]:
        """R - origin, (points, 3), world units. With weights (points, 1): X + w (R - X) - origin, X the point at rest."""
        rows = self._rows(spans)
        moved = horner(self._position[rows], local)
        if weight is None:
            return moved
        rest = self._rest(rows, local)
        return np.asarray(rest + weight * (moved - rest))

    def _rest(self, rows: Integers, local: npt.NDArray[Any]) -> npt.NDArray[Any]:
        rest, steps = self._centres[rows], self._steps[rows]
        for axis in range(3):
            rest = rest + local[:, axis, None] * steps[:, axis]
        return rest

    def normals(
        self,
        spans: Integers,
        local: npt.NDArray[Any],
        rest: npt.NDArray[np.float64],
        weight: Any = None,
        slope: Any = None,
    ) -> npt.NDArray[Any]:
        """The carried rest normals, (points, 3), of any length; 0 where they have no direction.

        h_0 (J_1 x J_2) + h_1 (J_2 x J_0) + h_2 (J_0 x J_1), but for a common factor above 0. With weights (points, 1) and their
        slopes (points, 3), J_a is e_a + w (J_a - e_a) + (R - X) (slope . e_a)."""
        rows = self._rows(spans)
        j = [horner(column[rows], local) for column in self._columns]
        if weight is not None:
            offset = horner(self._position[rows], local) - self._rest(rows, local)
            for axis in range(3):
                step = self._steps[rows][:, axis]
                rise = (slope * step).sum(axis=1, keepdims=True)
                unit = self._dtype(1 / self._largest)
                j[axis] = unit * step + weight * (j[axis] - unit * step) + unit * offset * rise
        h = np.einsum("pax,px->pa", self._rest_steps[rows], rest).astype(self._dtype)
        return np.asarray(
            h[:, :1] * np.cross(j[1], j[2])
            + h[:, 1:2] * np.cross(j[2], j[0])
            + h[:, 2:] * np.cross(j[0], j[1])
        )

    def _rows(self, spans: Integers) -> Integers:
        numbers = np.ravel_multi_index(tuple(spans.T), self._counts)
        return np.asarray(np.searchsorted(self._numbers, numbers))
