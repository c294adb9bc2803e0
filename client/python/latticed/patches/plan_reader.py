# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Reads the messages of GetPatchPlan."""
from __future__ import annotations

from typing import Any, Iterable, List, Optional

import numpy as np
import numpy.typing as npt

from latticed.chunk import octahedral_normals
from latticed.errors import LatticedError
from latticed.patches.byte_planes import BytePlanes, Integers, differences_summed, numbered
from latticed.patches.plan import UNITS, PatchPlan
from latticed.patches.seams import PatchSeams
from latticed.v1 import view_pb2

_NORMALS = {
    view_pb2.NORMAL_MODE_NONE: "none",
    view_pb2.NORMAL_MODE_FACET: "facet",
    view_pb2.NORMAL_MODE_SMOOTH: "smooth",
}
_NORMALS_PER_PATCH = {"none": 0, "facet": 1, "smooth": 3}
_MOST_PATCHES = 4096  # of a run
_NORMAL_BITS = 16  # of the octahedral map
_SMOOTH_UNIT = 32767.0


def read_plan(parts: Iterable[Any]) -> PatchPlan:
    """Converts the latticed.v1.PatchPlanPart messages of a plan: the header, then runs, then seams.

    LatticedError DATA_LOSS if they contradict each other.
    """
    reader: Optional[PlanReader] = None
    for part in parts:
        kind = part.WhichOneof("part")
        if (reader is None) != (kind == "header"):
            raise LatticedError.data_loss("a patch plan has one header, before all else")
        if reader is None:
            reader = PlanReader(part.header)
        elif kind == "run":
            reader.take_run(part.run)
        elif kind == "seams":
            reader.seams.append(part.seams)
    if reader is None:
        raise LatticedError.data_loss("a patch plan has no header")
    return reader.finish()


class PlanReader:
    """The runs so far."""

    def __init__(self, header: Any) -> None:
        if header.normals not in _NORMALS:
            raise LatticedError.data_loss(f"a patch plan has normals {header.normals}, which do not exist")
        self.header = header
        self.normals = _NORMALS[header.normals]
        self.seams: List[Any] = []
        self._patches = self._vertices = self._rests = 0
        self._corners: List[Integers] = []
        self._places: List[Integers] = []
        self._patch_normals: List[Integers] = []
        self._rest_normals: List[npt.NDArray[np.float64]] = []
        self._weights: List[Integers] = []
        self._slopes: List[npt.NDArray[np.float64]] = []

    def take_run(self, run: Any) -> None:
        inside = self.header.patch_count - self.header.patches_outside
        end = run.first_patch + run.patches
        if run.first_patch != self._patches or not 0 < run.patches <= _MOST_PATCHES:
            raise LatticedError.data_loss("a run of patches does not begin where the one before ends")
        if end > self.header.patch_count or run.first_patch < inside < end:
            raise LatticedError.data_loss(
                "a run of patches goes past the patches that the plan's header names"
            )
        per_patch = _NORMALS_PER_PATCH[self.normals]
        numbers_of_normal = 2 if self.normals == "facet" else 3
        size = 4 * (3 * run.patches + 3 * run.new_vertices + per_patch * run.patches)
        slopes = run.patches if self.header.weighted and self.normals != "none" else 0
        weights = run.new_vertices if self.header.weighted else 0
        size += 2 * numbers_of_normal * run.new_normals + 2 * weights + 12 * slopes
        arrays = BytePlanes(run.data, size)
        corners = numbered(arrays.take(3 * run.patches, 4), self._vertices, run.new_vertices, "vertices")
        self._corners.append(corners.reshape(-1, 3))
        differences = arrays.take(3 * run.new_vertices, 4).reshape(3, -1)
        self._places.append(differences_summed(differences).T)
        used = numbered(arrays.take(per_patch * run.patches, 4), self._rests, run.new_normals, "normals")
        self._patch_normals.append(used)
        rest = arrays.take(numbers_of_normal * run.new_normals, 2).reshape(numbers_of_normal, -1)
        self._rest_normals.append(self._rest(rest))
        self._weights.append(arrays.take(weights, 2))
        bits = arrays.take(3 * slopes, 4).astype(np.uint32).view(np.float32)
        self._slopes.append(bits.reshape(3, -1).T.astype(float))
        self._patches = end
        self._vertices += run.new_vertices
        self._rests += run.new_normals

    def _rest(self, numbers: Integers) -> npt.NDArray[np.float64]:
        if self.normals == "facet":
            return octahedral_normals(numbers[0], numbers[1], _NORMAL_BITS)
        return np.asarray(numbers.T.astype(np.uint16).view(np.int16) / _SMOOTH_UNIT)

    def finish(self) -> PatchPlan:
        header = self.header
        if (self._patches, self._vertices, self._rests) != (
            header.patch_count,
            header.vertex_count,
            header.normal_count,
        ):
            raise LatticedError.data_loss(
                f"a plan of {header.patch_count} patches ended after {self._patches} patches"
            )
        corners = np.concatenate([np.zeros((0, 3), dtype=np.int64), *self._corners])
        shape = (-1, 3) if self.normals == "smooth" else (-1,)
        has_slopes = header.weighted and self.normals != "none"
        plan = PatchPlan(
            topology_id=str(header.topology_id),
            normals=self.normals,
            inside=int(header.patch_count - header.patches_outside),
            corners=corners,
            places=np.concatenate([np.zeros((0, 3), dtype=np.int64), *self._places]),
            patch_normals=np.concatenate([np.zeros(0, dtype=np.int64), *self._patch_normals]).reshape(shape),
            rest_normals=np.concatenate([np.zeros((0, 3)), *self._rest_normals]),
            seams=PatchSeams.from_parts(self.seams),
            origin=_vector(header.origin),
            outside_box=self._outside_box(),
            curvature_unit=float(header.curvature_unit),
            weights=np.concatenate(self._weights) if header.weighted and self._weights else None,
            slopes=np.concatenate(self._slopes) if has_slopes and self._slopes else None,
        )
        self._check(plan)
        return plan

    def _outside_box(self) -> Optional[npt.NDArray[np.float64]]:
        header = self.header
        if not header.patches_outside:
            return None
        box = np.stack([_vector(header.outside_lower), _vector(header.outside_upper)])
        if not (box[0] < box[1]).all():
            raise LatticedError.data_loss("the outside box of a patch plan is empty")
        return box

    def _check(self, plan: PatchPlan) -> None:
        if len(plan.edge_vertices) != self.header.edge_count:
            raise LatticedError.data_loss(
                f"a plan has {len(plan.edge_vertices)} edges instead of {self.header.edge_count}"
            )
        if plan.slopes is not None and not np.isfinite(plan.slopes).all():
            raise LatticedError.data_loss("a weight of a patch plan has no finite slope")
        if not (plan.curvature_unit > 0 and np.isfinite(plan.curvature_unit)):
            raise LatticedError.data_loss("the curvature unit of a patch plan is not above 0")
        used_inside = np.unique(plan.corners[: plan.inside])
        used_outside = np.unique(plan.corners[plan.inside :])
        shared = np.intersect1d(used_inside, used_outside)
        shared_edges = np.intersect1d(plan.edges[: plan.inside], plan.edges[plan.inside :])
        if not (
            np.array_equal(shared, plan.seams.vertices) and np.array_equal(shared_edges, plan.seams.edges)
        ):
            raise LatticedError.data_loss("the seams of a patch plan are not those of its patches")
        only_outside = np.setdiff1d(used_outside, used_inside)
        in_box = [plan.places[only_outside], plan.seams.outside_places]
        within = [plan.places[plan.corners[: plan.inside]] - UNITS * plan.spans[: plan.inside, None]]
        if any(((part < 0) | (part > UNITS)).any() for part in in_box + within):
            raise LatticedError.data_loss("a vertex of a patch plan lies outside of its patch's box")


def _vector(xyz: Any) -> npt.NDArray[np.float64]:
    return np.array([xyz.x, xyz.y, xyz.z])
