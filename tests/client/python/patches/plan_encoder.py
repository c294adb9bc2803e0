# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Writes the patch plan of a sheet by the text of patches.proto, as literally as possible."""
import zlib

import numpy as np
from latticed.v1 import common_pb2, patches_pb2, view_pb2

import definition

UNITS = 65535
CURVATURE_UNIT = 2.0**-20


def places_in_frame(sheet):
    """(vertices, 3): 65535 span + round(65535 times the fraction of the span)."""
    places = np.zeros(sheet.shares.shape, dtype=np.int64)
    for axis, breaks in enumerate(sheet.breaks):
        shares = np.clip(sheet.shares[:, axis], 0, 1)
        spans = np.clip(np.searchsorted(breaks, shares, side="right") - 1, 0, len(breaks) - 2)
        fractions = (shares - breaks[spans]) / np.diff(breaks)[spans]
        places[:, axis] = UNITS * spans + np.rint(UNITS * fractions)
    return places


def outside_box(sheet):
    used = sheet.at_rest[sheet.inside :].reshape(-1, 3)
    return used.min(axis=0), used.max(axis=0)


def places_outside(sheet):
    low, high = outside_box(sheet)
    return np.rint(UNITS * (sheet.world - low) / (high - low)).astype(np.int64)


def edges_by_first_use(corners):
    """The edges of each patch, and the vertices of each edge."""
    numbers = {}
    patches = [
        [numbers.setdefault(frozenset((patch[e], patch[(e + 1) % 3])), len(numbers)) for e in range(3)]
        for patch in corners.tolist()
    ]
    return np.array(patches), list(numbers)


def _planes(numbers, width):
    flat = np.asarray(numbers, dtype=np.int64).reshape(-1)
    return b"".join((flat >> (8 * byte) & 255).astype(np.uint8).tobytes() for byte in range(width))


def _by_first_use(items, begin):
    """Codes of items that are numbered by first use, and how many are new. `begin` items came before."""
    codes, known = [], begin
    for item in items:
        codes.append(known - item if item < known else 0)
        known += item == known
    return codes, known - begin


def _differences(numbers):
    d = np.diff(np.concatenate([[0], numbers]))
    return np.where(d >= 0, 2 * d, -2 * d - 1)


def _octahedral(normals):
    """s and t of 16 bits."""
    x, y, z = (normals / np.abs(normals).sum(axis=1, keepdims=True)).T
    y, z = np.where(x < 0, np.copysign(1 - np.abs(z), y), y), np.where(
        x < 0, np.copysign(1 - np.abs(y), z), z
    )
    return [np.rint((c + 1) / 2 * 65534).astype(np.int64) for c in (y, z)]


def _control_points_of(lattice, shares):
    """The first and last control point of each axis that moves any of these points of the frame."""
    ranges = []
    for axis in range(3):
        knots, degree = lattice.knots[axis], lattice.degree[axis]
        begin, end = knots[degree], knots[len(knots) - degree - 1]
        at = begin + np.clip(shares[:, axis], 0, 1) * (end - begin)
        moving = definition.basis(knots, degree, at).any(axis=0)
        ranges += [np.flatnonzero(moving).min(), np.flatnonzero(moving).max()]
    return tuple(int(number) for number in ranges)


def _seams(sheet):
    inside, outside = sheet.corners[: sheet.inside], sheet.corners[sheet.inside :]
    vertices = np.intersect1d(inside, outside).tolist()
    of_patch, ends = edges_by_first_use(sheet.corners)
    edges = np.intersect1d(of_patch[: sheet.inside], of_patch[sheet.inside :]).tolist()
    numbers = {}

    def seam(shares):
        return numbers.setdefault(_control_points_of(sheet.lattice, shares), len(numbers))

    vertex_seams = [seam(sheet.shares[[vertex]]) for vertex in vertices]
    edge_seams = []
    for edge in edges:
        a, b = sheet.shares[sorted(ends[edge])]
        edge_seams.append(seam(a + np.linspace(0, 1, 7)[:, None] * (b - a)))
    flat = [number for ranges in numbers for number in ranges]
    places = places_outside(sheet)[vertices].reshape(-1)
    named = dict(vertices=vertices, vertex_seams=vertex_seams, edges=edges, edge_seams=edge_seams)
    return patches_pb2.PatchSeams(ranges=flat, outside_places=places, **named)


def _runs(sheet, random):
    """The first and last patch of runs of 1 to 40 patches."""
    begin = 0
    while begin < len(sheet.corners):
        limit = sheet.inside if begin < sheet.inside else len(sheet.corners)
        end = min(begin + int(random.integers(1, 40)), limit)
        yield begin, end
        begin = end


def plan_parts(sheet, normals, random):
    """The messages of the plan; normals are "none", "facet" or "smooth"."""
    mode = view_pb2.NormalMode.Value(f"NORMAL_MODE_{normals.upper()}")
    header = patches_pb2.PatchPlanHeader(
        topology_id="sheet",
        normals=mode,
        patch_count=len(sheet.corners),
        patches_outside=len(sheet.corners) - sheet.inside,
        vertex_count=len(sheet.world),
        edge_count=len(edges_by_first_use(sheet.corners)[1]),
        normal_count={"none": 0, "facet": len(sheet.corners), "smooth": len(sheet.world)}[normals],
        origin=_vec3(sheet.world.mean(axis=0)),
        curvature_unit=CURVATURE_UNIT,
    )
    if sheet.inside < len(sheet.corners):
        low, high = outside_box(sheet)
        header.outside_lower.CopyFrom(_vec3(low))
        header.outside_upper.CopyFrom(_vec3(high))
    yield patches_pb2.PatchPlanPart(header=header)
    used_inside = np.isin(np.arange(len(sheet.world)), sheet.corners[: sheet.inside])
    outside = places_outside(sheet) if sheet.inside < len(sheet.corners) else 0
    places = np.where(used_inside[:, None], places_in_frame(sheet), outside)
    known = 0
    for begin, end in _runs(sheet, random):
        corners, new = _by_first_use(sheet.corners[begin:end].reshape(-1).tolist(), known)
        data = _planes(corners, 4)
        data += _planes([_differences(axis) for axis in places[known : known + new].T], 4)
        new_normals = {"none": 0, "facet": end - begin, "smooth": new}[normals]
        if normals == "facet":
            data += _planes(np.zeros(end - begin), 4) + _planes(
                _octahedral(sheet.facet_normals()[begin:end]), 2
            )
        elif normals == "smooth":
            rest = np.rint(32767 * sheet.vertex_normals()[known : known + new]).astype(np.int64)
            data += _planes(corners, 4) + _planes(rest.T & 0xFFFF, 2)
        run = dict(first_patch=begin, patches=end - begin, new_vertices=new, new_normals=new_normals)
        yield patches_pb2.PatchPlanPart(run=patches_pb2.PatchRun(data=zlib.compress(data), **run))
        known += new
    if sheet.inside < len(sheet.corners):
        seams = _seams(sheet)
        identity = sheet.lattice.rest().reshape(-1)
        yield patches_pb2.PatchPlanPart(seams=seams)
        yield patches_pb2.PatchPlanPart(seams=patches_pb2.PatchSeams(identity_points=identity))


def _vec3(xyz):
    return common_pb2.Vec3(x=xyz[0], y=xyz[1], z=xyz[2])
