# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Makes the pattern of a patch from the levels of its edges, by the rule of PatchPattern in event.proto.

A point is three integers whose sum is WHOLE: its barycentrics times WHOLE. The weight of a side from p to q is

    sum over edges e of |d_e d_(e+1)| 4^level_e    d = q - p

and a side is split at its middle if its weight is above WHOLE squared. Both patches of a common edge split it alike,
because that depends on the edge's level alone.
"""
from __future__ import annotations

import functools
from typing import Any, Dict, List, Tuple

import numpy as np
import numpy.typing as npt

from latticed.pattern import PatchPattern

WHOLE = 4096
MOST_LEVEL = 5  # an edge has at most 2^5 segments

Point = Tuple[int, int, int]
Triangle = Tuple[Point, Point, Point]


def code_of(levels: npt.NDArray[Any]) -> npt.NDArray[np.int64]:
    """The code of the denser pattern with these levels of edges 0, 1, 2: (…, 3) to (…)."""
    numbers = np.asarray(levels, dtype=np.int64)
    return np.asarray(numbers[..., 0] + 8 * numbers[..., 1] + 64 * numbers[..., 2])


@functools.lru_cache(maxsize=None)
def make_pattern(code: int) -> PatchPattern:
    """The pattern with this code, whose bit 9 is clear, in the order of points and triangles that the server
    sends."""
    levels = (code & 7, code >> 3 & 7, code >> 6 & 7)
    if code >> 9 or max(levels) > MOST_LEVEL:
        raise ValueError(f"{code} is no code of the denser patterns, whose levels are 0 to {MOST_LEVEL}")
    triangles = _split([4**level for level in levels])
    points = np.array(sorted({point for triangle in triangles for point in triangle}), dtype=np.int64)
    common = int(np.gcd.reduce(points.reshape(-1)))  # a power of two, since the corners are among the points
    points = _in_rows(points // common, WHOLE // common, 2 ** max(levels))
    number = {tuple(point): index for index, point in enumerate((points * common).tolist())}
    ordered = [[number[corner] for corner in triangle] for triangle in _in_order(triangles)]
    return PatchPattern(points.reshape(-1), np.array(ordered).reshape(-1), WHOLE // common)


def _split(powers: List[int]) -> List[Triangle]:
    """The triangles of the pattern, in no particular order."""

    def weight(p: Point, q: Point) -> int:
        d = (q[0] - p[0], q[1] - p[1], q[2] - p[2])
        return sum(abs(d[e] * d[(e + 1) % 3]) * powers[e] for e in range(3))

    done: List[Triangle] = []
    waiting: List[Triangle] = [((WHOLE, 0, 0), (0, WHOLE, 0), (0, 0, WHOLE))]
    while waiting:
        corners = waiting.pop()
        split = [weight(corners[i], corners[(i + 1) % 3]) > WHOLE**2 for i in range(3)]
        if not any(split):
            done.append(corners)
            continue
        # The triangle is turned so that pq is the one side that is split, or the one that is not.
        first = split.index(sum(split) == 1) if sum(split) < 3 else 0
        p, q, r = (corners[(first + i) % 3] for i in range(3))
        pq, qr, rp = _middle(p, q), _middle(q, r), _middle(r, p)
        if sum(split) == 1:
            waiting += [(p, pq, r), (pq, q, r)]
        elif sum(split) == 3:
            waiting += [(p, pq, rp), (pq, q, qr), (rp, qr, r), (pq, qr, rp)]
        else:
            from_p, from_q = weight(p, qr), weight(q, rp)
            cut_from_p = from_p < from_q or (from_p == from_q and p > q)
            rest: List[Triangle] = [(p, q, qr), (p, qr, rp)] if cut_from_p else [(p, q, rp), (q, qr, rp)]
            waiting += [(rp, qr, r), *rest]
    return done


def _middle(p: Point, q: Point) -> Point:
    return ((p[0] + q[0]) // 2, (p[1] + q[1]) // 2, (p[2] + q[2]) // 2)


def _in_rows(points: npt.NDArray[np.int64], denominator: int, segments: int) -> npt.NDArray[np.int64]:
    """Sorts points by rows of ascending i_2. Even rows ascend by (i_1, i_2), odd rows descend."""
    rows = np.unique(points[:, 2] * segments // denominator, return_inverse=True)[1]
    sign = np.where(rows % 2 == 0, 1, -1)
    return points[np.lexsort([sign * points[:, 2], sign * points[:, 1], rows])]


def _in_order(triangles: List[Triangle]) -> List[Triangle]:
    """Turns each triangle to begin with its least corner by (i_2, i_1), and sorts them."""

    def place(point: Point) -> Point:
        return (point[2], point[1], point[0])

    turned: Dict[Triangle, Tuple[Point, Tuple[int, ...]]] = {}
    for triangle in triangles:
        first = min(range(3), key=lambda corner: place(triangle[corner]))
        p, q, r = (triangle[(first + i) % 3] for i in range(3))
        turned[(p, q, r)] = (place(p), tuple(-number for number in place(q)))
    return sorted(turned, key=lambda triangle: turned[triangle])
