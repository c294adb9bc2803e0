# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Evaluates patches as patches.proto says: the reference for programs that do so faster.

    N, s      whole numbers: integer_points.py
    l         (2 N - 65535 s) / (131070 s), from -1/2 to 1/2 across the point's span
    position  origin + R(box, l) in a knot box: box_polynomials.py; with weights X + w (R - X), X the point at rest
              lower + (l + 1/2) (upper - lower) on each axis of the outside box
    normal    direction of h_0 (J_1 x J_2) + h_1 (J_2 x J_0) + h_2 (J_0 x J_1), with J_a the derivative of R by l_a and
              h_a = width_a (step_a . n), n the rest normal, step_a the change of the world position at rest per unit
              of axis a; the opposite in a left-handed frame. Direction of n where it is zero, and outside
"""
from __future__ import annotations

from typing import Any, Optional, Type, Union

import numpy as np
import numpy.typing as npt

from latticed.lattice import Lattice
from latticed.outside import continued
from latticed.patches.box_table import BoxTable
from latticed.patches.integer_points import IntegerPoints, for_positions, in_own_spans
from latticed.patches.pattern_rule import make_pattern
from latticed.patches.plan import PatchPlan
from latticed.patches.surface import PatchSurface

Integers = npt.NDArray[np.int64]
Precision = Union[Type[np.float32], Type[np.float64]]

_BLOCK = 65536  # points whose coefficients are gathered at once: 50 MB of a cubic lattice


class PatchEvaluator:
    """Makes the surface of one lattice. Immutable; any number of threads may use it.

        plan = scene.patch_plan(update.topology.id, update.view.normals)
        surface = PatchEvaluator(plan, update.lattice).surface(update.edge_bytes, tolerance=0.001)

    Places are whole numbers, 65535 to a span. So each coordinate of a point differs from the exact surface by at most
    the sum over axes of |J_a| / 131070: half a unit of a grid of 16 bits around the surface, if knot boxes are not
    larger than the surface. Single precision adds 1e-6 of the surface's diagonal; dtype=numpy.float64 does not.
    """

    def __init__(self, plan: PatchPlan, lattice: Lattice, dtype: Precision = np.float32) -> None:
        """LatticedError DATA_LOSS if the plan is that of another lattice's knots."""
        self._plan = plan
        self._revision = lattice.revision
        self._dtype = dtype
        lattice = continued(lattice, plan.seams.identity_points)
        self._boxes = BoxTable(plan, lattice, dtype)
        attached = plan.seams.attached(lattice)
        self._attached_vertices = np.zeros(len(plan.places), dtype=bool)
        self._attached_vertices[plan.seams.vertices] = attached[plan.seams.vertex_seams]
        self._attached_edges = np.zeros(len(plan.edge_vertices), dtype=bool)
        self._attached_edges[plan.seams.edges] = attached[plan.seams.edge_seams]

    def surface(self, edge_bytes: npt.ArrayLike, tolerance: npt.ArrayLike) -> PatchSurface:
        """Triangles within `tolerance`, world units, of the exact surface, both ways, in addition to the error of
        positions, unless an edge would need more than 32 segments. See PatchPlan.levels."""
        return self.at_levels(self._plan.levels(edge_bytes, tolerance))

    def at_levels(self, levels: npt.ArrayLike) -> PatchSurface:
        """The surface whose edges have 2^level segments; levels (edges,), 0 to 5."""
        plan, codes = self._plan, self._plan.codes(levels)
        patterns = [make_pattern(code) for code in codes.tolist()]
        firsts = np.concatenate([[0], np.cumsum([len(pattern) for pattern in patterns], dtype=np.int64)])
        points = np.empty((int(firsts[-1]), 3), dtype=self._dtype)
        normals = None if plan.normals == "none" else np.empty_like(points)
        for code in np.unique(codes).tolist():
            pattern = make_pattern(code)
            every = np.flatnonzero(codes == code)
            for begin in range(0, len(every), max(1, _BLOCK // len(pattern))):
                patches = every[begin : begin + max(1, _BLOCK // len(pattern))]
                places = (firsts[patches][:, None] + np.arange(len(pattern))).reshape(-1)
                own = in_own_spans(plan, patches, pattern)
                shared = for_positions(
                    own, plan, patches, pattern, self._attached_vertices, self._attached_edges
                )
                points[places] = self._positions(shared)
                if normals is not None:
                    slopes = (
                        None if plan.slopes is None else np.repeat(plan.slopes[patches], len(pattern), axis=0)
                    )
                    normals[places] = self._normals(own, self._rest_normals(patches, pattern.weights), slopes)
        return PatchSurface(self._revision, plan.origin, points, normals, patterns, firsts)

    def _positions(self, points: IntegerPoints) -> npt.NDArray[Any]:
        local, inside = points.local(self._dtype), ~points.outside
        relative = np.empty_like(local)
        weight = None if points.weights is None else points.weight(self._dtype)[inside]
        relative[inside] = self._boxes.positions(points.spans[inside], local[inside], weight)
        if self._plan.outside_box is not None:
            lower, upper = self._plan.outside_box
            centre = ((lower + upper) / 2 - self._plan.origin).astype(self._dtype)
            relative[points.outside] = centre + local[points.outside] * (upper - lower).astype(self._dtype)
        return relative

    def _normals(
        self, points: IntegerPoints, rest: npt.NDArray[np.float64], slopes: Optional[npt.NDArray[np.float64]]
    ) -> npt.NDArray[Any]:
        normals, inside = rest.astype(self._dtype), ~points.outside
        local = points.local(self._dtype)[inside]
        weight = None if points.weights is None else points.weight(self._dtype)[inside]
        slope = None if slopes is None else slopes[inside].astype(self._dtype)
        carried = self._boxes.normals(points.spans[inside], local, rest[inside], weight, slope)
        has_direction = (carried != 0).any(axis=1, keepdims=True)
        normals[inside] = np.where(has_direction, carried, normals[inside])
        # Scaled first, because the squares of a tiny normal would underflow.
        normals /= np.maximum(np.abs(normals).max(axis=1, keepdims=True), np.finfo(self._dtype).tiny)
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        return np.asarray(normals / np.where(lengths > 0, lengths, self._dtype(1)))

    def _rest_normals(self, patches: Integers, weights: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """(points, 3): the patch's own with facet, the sum of i_k n_k / s over its corners with smooth."""
        plan = self._plan
        if plan.normals == "facet":
            return np.repeat(plan.rest_normals[plan.patch_normals[patches]], len(weights), axis=0)
        corners = plan.rest_normals[plan.patch_normals[patches]]
        return np.einsum("qk,pkx->pqx", weights, corners).reshape(-1, 3)
