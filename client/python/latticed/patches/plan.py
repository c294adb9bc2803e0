# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The plan of a scene's patches: what a client needs once to evaluate them by itself. See patches.proto."""
from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Optional, Tuple

import numpy as np
import numpy.typing as npt

from latticed.patches.pattern_rule import MOST_LEVEL, code_of
from latticed.patches.seams import PatchSeams

FloatArray = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

UNITS = 65535  # of a span: a vertex lies at one of the whole numbers from UNITS * span to UNITS * (span + 1)
_UNKNOWN = 255  # an edge byte: nothing is known of the edge's second derivatives


@dataclass(frozen=True, eq=False, repr=False)
class PatchPlan:
    """Scene.patch_plan makes it. It does not depend on control points. Arrays are in the order of patches, vertices
    and edges; vertices and edges are numbered in the order of their first use.

    topology_id     of the views that the plan is for
    normals         "none", "facet" or "smooth"
    inside          the number of patches inside the frame; those outside come after them
    corners         (patches, 3): the vertices of each patch
    places          (vertices, 3): where a vertex lies on the lattice's axes, 65535 to a span; of vertices that only
                    patches outside use, where it lies in the outside box, 65535 to a side
    patch_normals   (patches,) with facet, (patches, 3) with smooth, of its corners: which of rest_normals
    rest_normals    (normals, 3): at rest; facet: unit; smooth: up to 1 long
    seams           what patches inside and outside share
    origin          what positions in single precision are relative to, world units
    outside_box     (2, 3): its lowest and highest corner, world units; None if no patch is outside
    curvature_unit  what edge bounds are multiples of, world units
    weights         (vertices,): 0 to 65535, how much of the deformation each vertex takes; None if all take all of it
    slopes          (patches, 3): the gradient of the weight in the patch's source triangle, per world unit; None without
                    weights or without normals
    """

    topology_id: str
    normals: str
    inside: int
    corners: Integers
    places: Integers
    patch_normals: Integers
    rest_normals: FloatArray
    seams: PatchSeams
    origin: FloatArray
    outside_box: Optional[FloatArray]
    curvature_unit: float
    weights: Optional[Integers] = None
    slopes: Optional[FloatArray] = None

    def __repr__(self) -> str:
        return f"<PatchPlan: {len(self)} patches, {len(self) - self.inside} of them outside the frame>"

    def __len__(self) -> int:
        """The number of patches."""
        return len(self.corners)

    @property
    def edges(self) -> Integers:
        """(patches, 3): the edges of each patch. Edge e joins its corners e and (e + 1) modulo 3."""
        return self._edges[0]

    @property
    def edge_vertices(self) -> Integers:
        """(edges, 2): the vertices that an edge joins, the lower number first."""
        return self._edges[1]

    @functools.cached_property
    def _edges(self) -> Tuple[Integers, Integers]:
        ends = np.stack([self.corners, np.roll(self.corners, -1, axis=1)], axis=-1).reshape(-1, 2)
        names = ends.min(axis=1) * len(self.places) + ends.max(axis=1)
        _, first, edges = np.unique(names, return_index=True, return_inverse=True)
        by_first_use = np.argsort(first)
        number = np.empty(len(first), dtype=np.int64)
        number[by_first_use] = np.arange(len(first))
        return number[edges].reshape(-1, 3), np.sort(ends[first[by_first_use]], axis=1)

    @functools.cached_property
    def spans(self) -> Integers:
        """(patches, 3): the span of each patch on each axis; 0 outside the frame.

        If S is the sum of its corners' places, it is max(0, ceil(S / 196605) - 1)."""
        sums = self.places[self.corners].sum(axis=1)
        spans = np.maximum(0, -(-sums // (3 * UNITS)) - 1)
        spans[self.inside :] = 0
        return np.asarray(spans)

    @functools.cached_property
    def corner_places(self) -> Integers:
        """(patches, 3 corners, 3 axes): 0 to 65535, place - 65535 span; outside the frame, in the outside box."""
        places = self.places[self.corners] - UNITS * self.spans[:, None]
        places[self.inside :] = self.outside_corner_places[self.inside :]
        return np.asarray(places)

    @functools.cached_property
    def outside_corner_places(self) -> Integers:
        """(patches, 3 corners, 3 axes): 0 to 65535 in the outside box; 0 for corners that do not touch it."""
        places = np.zeros_like(self.places)
        touching = self.corners[self.inside :].reshape(-1)
        places[touching] = self.places[touching]
        places[self.seams.vertices] = self.seams.outside_places
        return np.asarray(places[self.corners])

    def edge_bounds(self, edge_bytes: npt.ArrayLike) -> FloatArray:
        """The bound E = curvature_unit 2^(b / 2) that each edge byte b says, world units; infinite for 255."""
        data = np.asarray(edge_bytes)
        if data.shape != (len(self.edge_vertices),):
            raise ValueError(
                f"{len(self.edge_vertices)} edges need one byte each, not the shape {data.shape}"
            )
        bounds = self.curvature_unit * 2.0 ** (data / 2)
        return np.asarray(np.where(data == _UNKNOWN, np.inf, bounds))

    def levels(self, edge_bytes: npt.ArrayLike, tolerance: npt.ArrayLike) -> Integers:
        """(edges,): the least level k with E <= 6 tolerance 4^k, and at most 5. An edge has 2^k segments.

        edge_bytes  (edges,): Update.edge_bytes
        tolerance   world units, above 0; one number, or one for each edge: then the least of its patches'
        """
        largest = np.asarray(tolerance, dtype=float)
        if not (largest > 0).all():
            raise ValueError(f"a tolerance is above 0, not {largest.min():g}")
        bounds = self.edge_bounds(edge_bytes)
        return np.asarray(sum((bounds > 6 * largest * 4**k).astype(np.int64) for k in range(MOST_LEVEL)))

    def codes(self, levels: npt.ArrayLike) -> Integers:
        """(patches,): the code of each patch's pattern, for the levels of edges."""
        return code_of(np.asarray(levels)[self.edges])
