# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""What a surface takes over from its mesh, and which of its points are one. It does not use Blender."""
from __future__ import annotations

import functools
import uuid
from typing import Any, Optional, Tuple

import numpy as np
import numpy.typing as npt
from latticed import Provenance

from .source_mesh import SourceMesh


class SurfaceLayout:
    """All of a surface that stays while its points move. Immutable.

    id         no other layout has it
    triangles  (triangles, 3): indices of the surface's points
    uvs        (points, 2): texture coordinates, interpolated in the mesh's triangles; None: the mesh has none
    uv_name    the name of their layer
    materials  (triangles,): index in the mesh's list of materials
    smooth     (triangles,): whether Blender shades the triangle smooth
    """

    def __init__(self, mesh: SourceMesh, provenance: Provenance) -> None:
        self.id = uuid.uuid4().hex
        self._corners, self._provenance = mesh.corners, provenance
        self.triangles = provenance.topology.triangles
        self.uv_name = mesh.uv_name
        self.uvs: Optional[npt.NDArray[np.float32]] = None
        if mesh.uvs is not None:
            self.uvs = provenance.interpolate(mesh.uvs).reshape(-1, 2).astype(np.float32)
        faces = np.repeat(provenance.faces, len(provenance.topology.pattern))
        self.materials = np.zeros(len(faces), np.int32) if mesh.materials is None else mesh.materials[faces]
        self.smooth = np.ones(len(faces), bool) if mesh.smooth is None else mesh.smooth[faces]

    @functools.cached_property
    def welded(self) -> Tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
        """The vertices of the welded surface: one point of each, and the vertex of every point.

        Points are one vertex where the mesh is connected: on a vertex or an edge of it, or inside one of its
        faces. Vertices of the mesh at one place stay apart. At rest the sides of a patch are straight, so two
        corners name the side between them. No seam can tear: LatticeMap's frame contains the whole mesh.
        """
        topology = self._provenance.topology
        weights = np.rint(topology.weights * topology.segments)  # integers, so that equal ones are equal
        corners = self._patch_corners()
        shape = (len(corners), len(weights), 3)
        names, shares = _canonical(np.broadcast_to(corners[:, None], shape), np.broadcast_to(weights, shape))
        inside = (weights > 0).all(axis=1)
        patch = np.where(inside, np.arange(len(corners))[:, None] + 1, 0)  # such a point is its patch's alone
        return _distinct(np.concatenate([names, shares, patch[..., None]], axis=-1).reshape(-1, 7))

    def _patch_corners(self) -> npt.NDArray[np.int64]:
        """(patches, 3): equal numbers for corners that are one point of the mesh. The server computes the
        barycentrics of a point on an edge in the same way for both faces, so they are equal to the last bit.
        """
        source = self._provenance
        vertices = np.broadcast_to(self._corners[source.corners][:, None], source.barycentrics.shape)
        names, shares = _canonical(vertices, source.barycentrics)
        face = np.where((shares > 0).all(axis=-1), source.faces[:, None] + 1, 0)
        rows = np.concatenate([names, shares, face[..., None]], axis=-1)
        return _distinct(rows.reshape(-1, 7))[1].reshape(-1, 3)


def _canonical(
    names: npt.NDArray[Any], shares: npt.NDArray[Any]
) -> Tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Points as sums of shares of three named points each: sorted by name, without names of zero shares."""
    names = np.where(shares > 0, names, -1)
    order = np.argsort(names, axis=-1, kind="stable")
    return np.take_along_axis(names, order, axis=-1), np.take_along_axis(shares, order, axis=-1)


def _distinct(rows: npt.NDArray[Any]) -> Tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """One index of each distinct row, and for every row the number of that index."""
    _, first, number = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return first, number.reshape(-1)
