# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The deformation in knot boxes, as polynomials of the local coordinates l_0, l_1, l_2, each from -1/2 to 1/2.

    R(box, l) - origin = sum over a, b, c of coefficients[box, a, b, c] l_0^a l_1^b l_2^c

Inside a span, a basis function of the lattice is one polynomial in l: parameter = centre of the span + l width. The
coefficients are computed in double from the control points relative to the origin, and rounded once.
"""
from __future__ import annotations

from typing import Any, List, Tuple

import numpy as np
import numpy.typing as npt

from latticed import bspline
from latticed.lattice import Lattice

FloatArray = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


class BoxPolynomials:
    """Immutable.

    span_counts  (3,): spans of each axis. Distinct knots of the domain cut an axis into spans
    """

    def __init__(self, lattice: Lattice, origin: FloatArray) -> None:
        self._points = lattice.control_points - origin
        self._axes = [_SpanBasis(knots, degree) for knots, degree in zip(lattice.knots, lattice.degree)]
        self.span_counts = np.array([len(axis.widths) for axis in self._axes])
        self._edges = lattice.edges
        self._corner = lattice.origin - origin

    def coefficients(self, spans: Integers) -> FloatArray:
        """(boxes, p_0 + 1, p_1 + 1, p_2 + 1, 3), in double, of the boxes with these spans, (boxes, 3)."""
        (i, nu), (j, nv), (k, nw) = (self._axes[axis].of(spans[:, axis]) for axis in range(3))
        nets = self._points[k[:, :, None, None], j[:, None, :, None], i[:, None, None, :]]
        # Relative to one of its control points, a box in which all are the same has derivatives of exactly 0.
        first = nets[:, 0, 0, 0]
        powers = np.einsum(
            "nkjix,nia,njb,nkc->nabcx", nets - first[:, None, None, None], nu, nv, nw, optimize=True
        )
        powers[:, 0, 0, 0] += first
        return np.asarray(powers)

    def at_rest(self, spans: Integers) -> Tuple[FloatArray, FloatArray]:
        """The lattice at rest in these boxes: X - origin = centre + sum of l_a e_a, with centre (boxes, 3) and e (boxes, 3, 3),
        e[:, a] the change along axis a. World units."""
        shares = [(axis.centres / axis.widths.sum())[spans[:, a]] for a, axis in enumerate(self._axes)]
        return self._corner + np.stack(shares, axis=-1) @ self._edges, self.rest_steps(spans)

    def rest_steps(self, spans: Integers) -> FloatArray:
        """(boxes, 3, 3): row a is width_a f_a, the width of the span in the domain, times the change of the world
        position at rest per unit of the domain's axis a."""
        shares = [axis.widths[spans[:, a]] / axis.widths.sum() for a, axis in enumerate(self._axes)]
        return np.asarray(np.stack(shares, axis=-1)[..., None] * self._edges)


class _SpanBasis:
    """The basis functions of one axis in each of its spans, as polynomials of l."""

    def __init__(self, knots: FloatArray, degree: int) -> None:
        begin, end = bspline.domain(knots, degree)
        breaks = np.unique(knots[(knots >= begin) & (knots <= end)])
        self.widths = np.diff(breaks)
        self.centres = (breaks[1:] + breaks[:-1]) / 2 - begin
        last = np.searchsorted(knots, breaks[:-1], side="right") - 1  # the knot that the span begins at
        self._first = last - degree
        pieces = [self._pieces(knots, degree, int(knot)) for knot in last]
        self._pieces_of = np.array(pieces)

    def of(self, spans: Integers) -> Tuple[Integers, FloatArray]:
        """The numbers of the functions, (n, degree + 1), and their coefficients, (n, functions, powers)."""
        numbers = self._first[spans][:, None] + np.arange(self._pieces_of.shape[1])
        return np.asarray(numbers), np.asarray(self._pieces_of[spans])

    @staticmethod
    def _pieces(knots: FloatArray, degree: int, last: int) -> FloatArray:
        """(functions, powers) by de Boor's recurrence: The NURBS Book, A2.2, with polynomials in place of numbers."""
        centre, width = (knots[last] + knots[last + 1]) / 2, knots[last + 1] - knots[last]
        values: List[FloatArray] = [np.array([1.0])]
        for p in range(1, degree + 1):
            raised = [np.zeros(p + 1) for _ in range(p + 1)]
            for r, value in enumerate(values):
                right, left = knots[last + r + 1], knots[last + r + 1 - p]
                share = value / (right - left)
                raised[r] += np.convolve(share, [right - centre, -width])
                raised[r + 1] += np.convolve(share, [centre - left, width])
            values = raised
        return np.array(values)


def derivative(coefficients: npt.NDArray[Any], axis: int) -> npt.NDArray[Any]:
    """The coefficients of the derivative by l_axis; those of `coefficients` are on axes 1 to 3."""
    moved = np.moveaxis(coefficients, axis + 1, 0)
    powers = np.arange(1, len(moved)).reshape(-1, *[1] * (moved.ndim - 1))
    return np.moveaxis(moved[1:] * powers, 0, axis + 1)


def horner(coefficients: npt.NDArray[Any], local: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The polynomials at local coordinates: coefficients (n, …, 3) and (n, 3) to (n, 3), in their precision.

    Every point has the same operations in the same order, so equal integers give equal bits.
    """
    value = coefficients
    for axis in (2, 1, 0):
        l = local[:, axis].reshape(-1, *[1] * (axis + 1))
        total = value[(slice(None),) * (axis + 1) + (-1,)]
        for power in range(value.shape[axis + 1] - 2, -1, -1):
            total = total * l + value[(slice(None),) * (axis + 1) + (power,)]
        value = total
    return value
