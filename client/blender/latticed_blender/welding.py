# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Which points of a surface's patches are one vertex. It does not use Blender.

Points are one where the mesh is connected: on a vertex or an edge of it, or inside one of its faces. Vertices of the mesh
at one place stay apart. No seam can tear, because LatticeMap's frame contains the whole mesh.

Knots beside a vertex cut off slivers. Corners of patches whose distance at rest is at most 2^-22 of the mesh's diagonal
are one too, as in files that the server exports, and a patch that has such a corner twice is left out.
"""
from __future__ import annotations

from typing import Any, NamedTuple, Sequence, Tuple

import numpy as np
import numpy.typing as npt
from latticed import PatchPattern, Provenance

from .source_mesh import SourceMesh

_SHORTEST = 2.0**-22
_WHOLE = 4096  # over which all weights of a pattern with a tolerance are integers

Numbers = npt.NDArray[np.int64]


class Welding(NamedTuple):
    """points  (vertices,): a point of the surface for each vertex
    vertex  (points,): the vertex of each point; -1 for points that only left out triangles have
    kept    (triangles,): False for triangles that are left out
    """

    points: Numbers
    vertex: Numbers
    kept: npt.NDArray[np.bool_]


def weld(mesh: SourceMesh, source: Provenance, patterns: Sequence[PatchPattern]) -> Welding:
    """Names each point of a patch by the patch's corners and its weights in them: at rest the sides of a patch are
    straight, so two corners name the side between them."""
    whole_weight = source.topology.segments or _WHOLE
    corners = _corners(mesh, source)
    whole = (corners != np.roll(corners, 1, axis=1)).all(axis=1)
    counts = [len(pattern) for pattern in patterns]
    kept_points = np.repeat(whole, counts)
    weights = np.concatenate([pattern.weights for pattern in patterns])[kept_points]
    weights = np.rint(weights * whole_weight).astype(np.int64)
    names, shares = _canonical(np.repeat(corners, counts, axis=0)[kept_points], weights)
    # A point on a side has a name in columns 1 and 2, a corner in column 2 alone; one inside a patch is its patch's.
    side = (names[:, 1] + 1) * (corners.max() + 1) + names[:, 2]
    keys = side * (whole_weight + 1) + shares[:, 1]
    inside = (weights > 0).all(axis=1)
    keys[inside] = -1 - np.arange(inside.sum())
    _, first, vertex_of_kept = np.unique(keys, return_index=True, return_inverse=True)
    vertex = np.full(len(kept_points), -1)
    vertex[kept_points] = vertex_of_kept.reshape(-1)
    kept = np.repeat(whole, [len(pattern.triangles) for pattern in patterns])
    return Welding(np.flatnonzero(kept_points)[first], vertex, kept)


def _corners(mesh: SourceMesh, source: Provenance) -> Numbers:
    """(patches, 3): equal numbers for corners of patches that are one."""
    vertices = mesh.corners[source.corners]
    # The server computes the barycentrics of a point on an edge in the same way for both faces, so they are equal
    # to the last bit.
    shares = source.barycentrics
    names, shares = _canonical(np.broadcast_to(vertices[:, None], shares.shape), shares)
    face = np.where((shares > 0).all(axis=-1), source.faces[:, None], -1)
    rows = np.concatenate([names, shares, face[..., None]], axis=-1).reshape(-1, 7)
    numbers = np.unique(rows, axis=0, return_inverse=True)[1].reshape(-1, 3)
    positions = mesh.positions.astype(float)
    rest = np.einsum("pck,pkx->pcx", source.barycentrics, positions[vertices])
    shortest = _SHORTEST * np.linalg.norm(np.ptp(positions, axis=0))
    short = np.linalg.norm(rest - np.roll(rest, 1, axis=1), axis=-1) <= shortest
    return _joined(numbers, np.stack([numbers[short], np.roll(numbers, 1, axis=1)[short]]))


def _joined(numbers: Numbers, pairs: Numbers) -> Numbers:
    """The numbers, of which those that pairs connect, (2, pairs), became the lowest of them."""
    lowest = np.arange(numbers.max() + 1)
    while (lowest[pairs[0]] != lowest[pairs[1]]).any():
        least = lowest[pairs].min(axis=0)
        for end in pairs:
            np.minimum.at(lowest, end, least)
    return np.asarray(lowest[numbers])


def _canonical(
    names: npt.NDArray[Any], shares: npt.NDArray[Any]
) -> Tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Points as sums of shares of three named points each: sorted by name, without names of zero shares."""
    names = np.where(shares > 0, names, -1)
    order = np.argsort(names, axis=-1, kind="stable")
    return np.take_along_axis(names, order, axis=-1), np.take_along_axis(shares, order, axis=-1)
