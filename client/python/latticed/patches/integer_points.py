# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Points of patches as whole numbers, before any rounding.

A point of a pattern is i_0, i_1, i_2 with the sum s, a power of two. On each axis let

    N = sum of i_k * (place of corner k - 65535 span)

which fits in 32 bits. A point that patches share has the same N / s in all of them.
"""
from __future__ import annotations

from typing import Any, NamedTuple, Optional

import numpy as np
import numpy.typing as npt

from latticed.patches.plan import UNITS, PatchPlan
from latticed.pattern import PatchPattern

Integers = npt.NDArray[np.int64]


class IntegerPoints(NamedTuple):
    """sums     (points, 3): N on each axis, int32
    whole    s, of all
    spans    (points, 3): the span on each axis; 0 in the outside box
    outside  (points,): whether it lies in the outside box, and not in a knot box
    weights  (points,): V = sum of i_k * (weight of corner k), int32; None if the plan is not weighted
    """

    sums: npt.NDArray[np.int32]
    whole: int
    spans: Integers
    outside: npt.NDArray[np.bool_]
    weights: Optional[npt.NDArray[np.int32]] = None

    def weight(self, dtype: Any) -> npt.NDArray[Any]:
        """(points, 1): w = V / (65535 s), 0 to 1, of a weighted plan."""
        assert self.weights is not None
        return self.weights.astype(dtype)[:, None] / dtype(UNITS * self.whole)

    def local(self, dtype: Any) -> npt.NDArray[Any]:
        """(points, 3): l = (2 N - 65535 s) / (131070 s), in this precision. A common factor of two in N and s does
        not change its bits."""
        return (2 * self.sums - UNITS * self.whole).astype(dtype) / dtype(2 * UNITS * self.whole)


def in_own_spans(plan: PatchPlan, patches: Integers, pattern: PatchPattern) -> IntegerPoints:
    """The points of these patches, which all have this pattern, patch after patch, each in its patch's own spans."""
    return IntegerPoints(
        _weighted(plan.corner_places[patches], pattern),
        pattern.denominator,
        np.repeat(plan.spans[patches], len(pattern), axis=0),
        np.repeat(patches >= plan.inside, len(pattern)),
        None
        if plan.weights is None
        else _weighted(plan.weights[plan.corners[patches]][..., None], pattern)[:, 0],
    )


def for_positions(
    own: IntegerPoints,
    plan: PatchPlan,
    patches: Integers,
    pattern: PatchPattern,
    attached_vertices: npt.NDArray[np.bool_],
    attached_edges: npt.NDArray[np.bool_],
) -> IntegerPoints:
    """The same points, as all patches see them that share them.

    Points with an attached seam are those of the outside box. A point with N = 0 and span > 0 counts as of the next
    lower span, with N = 65535 s.

    attached_vertices, attached_edges  whether each vertex and edge of the plan has an attached seam
    """
    vertices, edges = attached_vertices[plan.corners[patches]], attached_edges[plan.edges[patches]]
    attached = np.zeros((len(patches), len(pattern)), dtype=bool)
    for k in range(3):
        at_vertex = pattern.points[:, k] == pattern.denominator
        on_edge = pattern.points[:, (k + 2) % 3] == 0  # edge k joins corners k and k + 1
        attached |= (vertices[:, k, None] & at_vertex) | (edges[:, k, None] & on_edge)
    outside = own.outside | attached.reshape(-1)
    sums = np.where(outside[:, None], _weighted(plan.outside_corner_places[patches], pattern), own.sums)
    spans = np.where(outside[:, None], 0, own.spans)
    down = (sums == 0) & (spans > 0)
    return own._replace(
        sums=np.where(down, np.int32(UNITS * own.whole), sums), spans=spans - down, outside=outside
    )


def _weighted(places: Integers, pattern: PatchPattern) -> npt.NDArray[np.int32]:
    points = pattern.points.astype(np.int32)
    return np.einsum("qk,pka->pqa", points, places.astype(np.int32)).reshape(-1, places.shape[-1])
