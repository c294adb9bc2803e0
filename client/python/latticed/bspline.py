# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The B-spline volume at many points, in double precision.

R(u,v,w) = sum over i,j,k of control_points[k, j, i] N_i(u) N_j(v) N_k(w)    Cui & Feng 2014, formula (1)

The basis N follows de Boor's recurrence: Piegl & Tiller, The NURBS Book, A2.1 and A2.2.
"""
from __future__ import annotations

from typing import Sequence, Tuple

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IndexArray = npt.NDArray[np.int64]


def domain(knots: FloatArray, degree: int) -> Tuple[float, float]:
    """The smallest and the largest parameter of an axis, both included."""
    return float(knots[degree]), float(knots[len(knots) - degree - 1])


def basis(knots: FloatArray, degree: int, parameters: FloatArray) -> Tuple[IndexArray, FloatArray]:
    """The degree + 1 basis functions that may differ from 0 at each parameter of the domain.

    parameters  (n,)
    returns     (n,): the index of the first function; (n, degree + 1): the values, which sum to 1

    A parameter on a knot belongs to the interval below it, and the domain's begin to the first interval.
    """
    first = np.searchsorted(knots, knots[degree], side="right") - 1
    span = np.maximum(np.searchsorted(knots, parameters, side="left") - 1, first)
    values = np.zeros((len(parameters), degree + 1))
    values[:, 0] = 1.0
    for p in range(1, degree + 1):
        saved = np.zeros(len(parameters))
        for r in range(p):
            right, left = knots[span + r + 1], knots[span + r + 1 - p]
            share = values[:, r] / (right - left)
            values[:, r] = saved + (right - parameters) * share
            saved = (parameters - left) * share
        values[:, p] = saved
    return span - degree, values


def volume(
    control_points: FloatArray,
    degree: Sequence[int],
    knots: Sequence[FloatArray],
    parameters: FloatArray,
) -> FloatArray:
    """R at parameters of the domain, (n, 3): u, v, w. Control points are shaped (nw, nv, nu, 3)."""
    (i, nu), (j, nv), (k, nw) = (basis(knots[a], degree[a], parameters[:, a]) for a in range(3))
    result = np.zeros((len(parameters), 3))
    for c in range(degree[2] + 1):
        for b in range(degree[1] + 1):
            weight_vw = nv[:, b] * nw[:, c]
            for a in range(degree[0] + 1):
                weight = nu[:, a] * weight_vw
                result += weight[:, None] * control_points[k + c, j + b, i + a]
    return result
