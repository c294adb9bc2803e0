# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Converts one axis of Blender's lattice to one axis of a B-spline lattice, exactly.

The coordinate x is 0 at the first lattice point and count - 1 at the last. Blender adds to a point at x

    D(x) = sum over k of weight_k(x - floor(x)) d[floor(x) + k]     k = -1, 0, 1, 2

where d[i] is the displacement of lattice point i. An index outside of 0 … count - 1 means the nearest
lattice point, so D is constant from one spacing beyond the lattice. The four kinds of weights are

    KEY_LINEAR        a polygon: degree 1
    KEY_BSPLINE       uniform cubic B-splines: knots at the integers, without multiple ones at the ends
    KEY_CATMULL_ROM, KEY_CARDINAL
                      cubic Hermite splines with tangents tension * (d[i + 1] - d[i - 1]), tension 1/2 and
                      0.71: double knots, and the control points d[i] ± tangent / 3

All are piecewise polynomials and therefore B-splines. The B-spline of the function x has its Greville
abscissae as control points, so x + D(x) has the control points abscissa + displacement.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Optional, Tuple

import numpy as np
import numpy.typing as npt

TENSIONS = {"KEY_CATMULL_ROM": 0.5, "KEY_CARDINAL": 0.71}
INTERPOLATIONS = ("KEY_LINEAR", "KEY_BSPLINE", *TENSIONS)

Row = npt.NDArray[np.float64]


@dataclass(frozen=True)
class AxisMap:
    """degree   1 or 3
    knots    as values of x
    weights  (m, count): displacements of the m control points = weights @ displacements of the lattice points
    """

    degree: int
    knots: npt.NDArray[np.float64]
    weights: npt.NDArray[np.float64]

    @property
    def domain(self) -> Tuple[float, float]:
        return (float(self.knots[self.degree]), float(self.knots[-1 - self.degree]))


def map_axis(interpolation: str, count: int, low: float, high: float) -> AxisMap:
    """Maps an axis of `count` lattice points. Its domain covers the mesh, which extends from `low` to `high`.

    ValueError for an interpolation that Blender does not have."""
    if interpolation not in INTERPOLATIONS:
        raise ValueError(f"no lattice interpolation is called {interpolation!r}")
    if count == 1:  # the same displacement everywhere
        first, last = math.floor(low) - 1.0, math.ceil(high) + 1.0
        return AxisMap(1, np.array([first, first, last, last]), np.ones((2, 1)))
    # If the mesh extends beyond the lattice, so does the domain. D is constant from one spacing beyond the
    # lattice, so a single knot box covers the rest of the mesh.
    begin = math.floor(min(low, -1.0)) - 1.0 if low < 0 else None
    end = math.ceil(max(high, float(count))) + 1.0 if high > count - 1 else None
    if interpolation == "KEY_LINEAR":
        return _linear(count, begin, end)
    if interpolation == "KEY_BSPLINE":
        return _b_spline(count, begin, end)
    return _hermite(count, TENSIONS[interpolation], begin, end)


def _of(index: int, count: int) -> Row:
    """The weights of lattice point `index`, or of the nearest lattice point if there is none."""
    row = np.zeros(count)
    row[min(max(index, 0), count - 1)] = 1.0
    return row


def _map(degree: int, knots: List[float], rows: List[Row]) -> AxisMap:
    assert len(knots) == len(rows) + degree + 1
    return AxisMap(degree, np.array(knots), np.array(rows))


def _linear(count: int, begin: Optional[float], end: Optional[float]) -> AxisMap:
    last = count - 1.0
    lower, upper = [0.0] if begin is None else [begin] * 2, [last] if end is None else [end] * 2
    first = 0 if begin is None else -1
    knots = lower + [float(k) for k in range(count)] + upper
    return _map(1, knots, [_of(first + i, count) for i in range(len(knots) - 2)])


def _b_spline(count: int, begin: Optional[float], end: Optional[float]) -> AxisMap:
    """Only basis functions of the two end points use knots before -1 or after count, which may be far apart."""
    last = count - 1.0
    lower = [-3.0, -2.0, -1.0] if begin is None else [begin] * 4 + [-1.0]
    upper = [last + 1, last + 2, last + 3] if end is None else [last + 1] + [end] * 4
    first = -1 if begin is None else -3
    knots = lower + [float(k) for k in range(count)] + upper
    return _map(3, knots, [_of(first + i, count) for i in range(len(knots) - 4)])


def _hermite(count: int, tension: float, begin: Optional[float], end: Optional[float]) -> AxisMap:
    first, last = 0 if begin is None else -1, count - 1 if end is None else count

    def beside(index: int, side: int) -> Row:
        """The control point before (-1) or after (1) the knot of a lattice point."""
        tangent = tension * (_of(index + 1, count) - _of(index - 1, count))
        return _of(index, count) + side / 3.0 * tangent

    knots = [float(first) if begin is None else begin] * 4
    rows = [_of(first, count)] * (1 if begin is None else 2)
    for index in range(first, last + 1):
        is_begin, is_end = begin is None and index == first, end is None and index == last
        if not (is_begin or is_end):
            knots += [float(index)] * 2
        if not is_begin:
            rows.append(beside(index, -1))
        if not is_end:
            rows.append(beside(index, 1))
    rows += [_of(last, count)] * (1 if end is None else 2)
    return _map(3, knots + [float(last) if end is None else end] * 4, rows)
