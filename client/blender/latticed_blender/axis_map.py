# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""One axis of Blender's lattice as one axis of a B-spline lattice, exactly.

Blender adds to a point at x, counted in lattice points from the first one on, the displacement

    D(x) = sum over k of weight_k(x - floor(x)) d[floor(x) + k]     k = -1, 0, 1, 2

of its lattice points, where an index outside of 0 … count - 1 is the nearest of them: so beyond the
lattice D goes over into that of its end within one spacing. The four kinds of weights are

    KEY_LINEAR        a polygon: degree 1
    KEY_BSPLINE       uniform cubic B-splines: knots at the integers, without multiple ones at the ends
    KEY_CATMULL_ROM, KEY_CARDINAL
                      cubic Hermite splines, tangents tension * (d[i + 1] - d[i - 1]), 1/2 and 0.71: on
                      double knots, with the control points d[i] ± tangent / 3

all of them piecewise polynomials, hence B-splines. These reproduce linear functions with control points at
their Greville abscissae, so that x + D(x) has the control points abscissa + displacement.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, List, Tuple

import numpy as np
import numpy.typing as npt

TENSIONS = {"KEY_CATMULL_ROM": 0.5, "KEY_CARDINAL": 0.71}
INTERPOLATIONS = ("KEY_LINEAR", "KEY_BSPLINE", *TENSIONS)

Row = npt.NDArray[np.float64]


@dataclass(frozen=True)
class AxisMap:
    """degree   1 or 3
    knots    in lattice points: 0 is the first, count - 1 the last
    weights  (m, count): displacements of the m control points = weights @ those of the lattice points
    """

    degree: int
    knots: npt.NDArray[np.float64]
    weights: npt.NDArray[np.float64]

    @property
    def domain(self) -> Tuple[float, float]:
        return (float(self.knots[self.degree]), float(self.knots[-1 - self.degree]))


def map_axis(interpolation: str, count: int, low: float, high: float) -> AxisMap:
    """An axis of `count` lattice points for a mesh from `low` to `high`, which its domain covers.

    ValueError for an interpolation that Blender does not have."""
    if interpolation not in INTERPOLATIONS:
        raise ValueError(f"no lattice interpolation is called {interpolation!r}")
    # Past a whole spacing D is constant: one knot box reaches to the mesh's end, with room to spare.
    begin = math.floor(min(low, -1.0)) - 1.0 if low < 0 else None
    end = math.ceil(max(high, float(count))) + 1.0 if high > count - 1 else None
    if count == 1:  # the same displacement everywhere
        first, last = math.floor(low) - 1.0, math.ceil(high) + 1.0
        return AxisMap(1, np.array([first, first, last, last]), np.ones((2, 1)))
    if interpolation == "KEY_LINEAR":
        return _linear(count, begin, end)
    if interpolation == "KEY_BSPLINE":
        return _b_spline(count, begin, end)
    return _hermite(count, TENSIONS[interpolation], begin, end)


def _of(index: int, count: int) -> Row:
    """The displacement of one lattice point, or of the nearest where there is none of that index."""
    row = np.zeros(count)
    row[min(max(index, 0), count - 1)] = 1.0
    return row


def _map(degree: int, knots: List[float], rows: List[Row]) -> AxisMap:
    assert len(knots) == len(rows) + degree + 1
    return AxisMap(degree, np.array(knots), np.array(rows))


def _linear(count: int, begin: Any, end: Any) -> AxisMap:
    inner = [float(k) for k in range(count)]
    lower, upper = [0.0] if begin is None else [begin] * 2, [inner[-1]] if end is None else [end] * 2
    first, last = 0 if begin is None else -1, count if end is None else count + 1
    return _map(1, lower + inner + upper, [_of(i, count) for i in range(first, last)])


def _b_spline(count: int, begin: Any, end: Any) -> AxisMap:
    """Where a function has another displacement than the end's, its knots are integers, -1 or above."""
    last = count - 1.0
    lower = [-3.0, -2.0, -1.0] if begin is None else [begin] * 4 + [-1.0]
    upper = [last + 1, last + 2, last + 3] if end is None else [last + 1] + [end] * 4
    knots = lower + [float(k) for k in range(count)] + upper
    first = -1 if begin is None else -3
    return _map(3, knots, [_of(first + i, count) for i in range(len(knots) - 4)])


def _hermite(count: int, tension: float, begin: Any, end: Any) -> AxisMap:
    first, last = 0 if begin is None else -1, count - 1 if end is None else count
    ends = (float(first) if begin is None else begin, float(last) if end is None else end)

    def beside(index: int, side: int) -> Row:
        """The control point before (-1) or after (1) the knot of a lattice point."""
        tangent = tension * (_of(index + 1, count) - _of(index - 1, count))
        return _of(index, count) + side / 3.0 * tangent

    knots, rows = [ends[0]] * 4, [_of(first, count)]
    if begin is not None:
        rows.append(_of(first, count))
    for index in range(first, last + 1):
        inside = (begin is not None or index > first) and (end is not None or index < last)
        if inside:
            knots += [float(index)] * 2
        if begin is not None or index > first:
            rows.append(beside(index, -1))
        if end is not None or index < last:
            rows.append(beside(index, 1))
    if end is not None:
        rows.append(_of(last, count))
    return _map(3, knots + [ends[1]] * 4, rows + [_of(last, count)])
