# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The calls of a scene that make point sets."""
from __future__ import annotations

from typing import Any, List, Optional

import numpy as np
import numpy.typing as npt

from latticed.connection import Connection
from latticed.points.point_set import PointSet, create, vectors
from latticed.v1 import points_pb2
from latticed.view import View

# A point of the surface as it is sent: points.proto, SurfacePointSource.
_SURFACE_POINT = np.dtype([("face", "<u4"), ("corners", "<u4", 3), ("barycentrics", "<f8", 3)])


class PointSetCalls:
    """A part of Scene."""

    _connection: Connection
    info: Any

    def points(self, points: npt.ArrayLike, normals: Optional[npt.ArrayLike] = None) -> PointSet:
        """Keeps points of the undeformed world, (n, 3), on the server: mesh nodes of a solver, for instance.

        normals  (n, 3), of any length; 0 0 0 where a point has none
        """
        data = [vectors(points, "points").reshape(-1, 3)]
        if normals is not None:
            data.append(vectors(normals, "normals").reshape(-1, 3))
            if len(data[1]) != len(data[0]):
                raise ValueError(f"{len(data[0])} points have {len(data[1])} normals")
        world = points_pb2.WorldPointSource(points=len(data[0]), with_normals=normals is not None)
        return create(self._connection, points_pb2.PointSetHeader(scene=self.info.id, world=world), data)

    def surface_points(
        self, faces: npt.ArrayLike, corners: npt.ArrayLike, barycentrics: npt.ArrayLike
    ) -> PointSet:
        """Keeps points of the surface, with the normals of its source triangles. Arguments as in evaluate_surface."""
        face = np.asarray(faces).reshape(-1)
        records = np.empty(len(face), dtype=_SURFACE_POINT)
        records["face"] = face
        records["corners"] = np.asarray(corners).reshape(-1, 3)
        records["barycentrics"] = np.asarray(barycentrics, dtype=float).reshape(-1, 3)
        surface = points_pb2.SurfacePointSource(points=len(records))
        header = points_pb2.PointSetHeader(scene=self.info.id, surface=surface)
        return create(self._connection, header, [records])

    def view_points(self, view: View) -> PointSet:
        """Keeps the points of a view's tessellation, patch after patch. Its segments and normals count; it has no
        tolerance. The points do not change with later edits of the knots."""
        header = points_pb2.PointSetHeader(scene=self.info.id, view=view.to_proto())
        return create(self._connection, header, [])

    def point_sets(self) -> List[PointSet]:
        """The sets of the scene, oldest first, whoever made them."""
        request = points_pb2.ListPointSetsRequest(scene=self.info.id)
        listed = self._connection.call(self._connection.points.ListPointSets, request, self.info.id)
        return [PointSet(self._connection, info) for info in listed.point_sets]
