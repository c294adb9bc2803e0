# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The deformation at single points, in double precision."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, List, Optional

import grpc
import numpy as np
import numpy.typing as npt

from latticed.connection import Connection
from latticed.errors import LatticedError
from latticed.v1 import surface_pb2

_MOST_POINTS = 4096  # of one call


@dataclass(frozen=True)
class Evaluation:
    """positions  (n, 3): deformed, world units
    jacobians  (n, 3, 3): jacobians[p, i, j] is d deformed i / d rest j
    normals    (n, 3): of the deformed facet, 0 0 0 where undefined; None for points of the world
    revision   the scene's revision at which all points were evaluated
    """

    positions: npt.NDArray[np.float64]
    jacobians: npt.NDArray[np.float64]
    normals: Optional[npt.NDArray[np.float64]]
    revision: int


def evaluate_world(connection: Connection, scene: str, points: npt.ArrayLike) -> Evaluation:
    """Evaluates points of the undeformed world, (n, 3)."""
    flat = np.asarray(points, dtype=float).reshape(-1, 3)

    def request(begin: int, end: int) -> surface_pb2.EvaluatePointsRequest:
        positions = surface_pb2.WorldPoints(positions=flat[begin:end].reshape(-1))
        return surface_pb2.EvaluatePointsRequest(scene=scene, world_points=positions)

    return _evaluate(connection, scene, len(flat), request)


def evaluate_surface(
    connection: Connection,
    scene: str,
    faces: npt.ArrayLike,
    corners: npt.ArrayLike,
    barycentrics: npt.ArrayLike,
) -> Evaluation:
    """Evaluates points of the surface by their place in the source mesh: faces (n,), corners and barycentrics
    (n, 3)."""
    face, corner = np.asarray(faces).reshape(-1), np.asarray(corners).reshape(-1, 3)
    weights = np.asarray(barycentrics, dtype=float).reshape(-1, 3)
    if not len(face) == len(corner) == len(weights):
        raise ValueError(f"{len(face)} faces, {len(corner)} times corners, {len(weights)} times barycentrics")

    def request(begin: int, end: int) -> surface_pb2.EvaluatePointsRequest:
        places = zip(face[begin:end], corner[begin:end], weights[begin:end])
        points = [surface_pb2.SurfacePoint(face=f, corners=c, barycentrics=b) for f, c, b in places]
        surface = surface_pb2.SurfacePoints(points=points)
        return surface_pb2.EvaluatePointsRequest(scene=scene, surface_points=surface)

    return _evaluate(connection, scene, len(face), request)


def _evaluate(
    connection: Connection, scene: str, count: int, request: Callable[[int, int], Any]
) -> Evaluation:
    method = connection.scenes.EvaluatePoints
    answers: List[Any] = [
        connection.call(method, request(begin, min(begin + _MOST_POINTS, count)), scene)
        for begin in range(0, max(1, count), _MOST_POINTS)
    ]
    if len({answer.revision for answer in answers}) != 1:
        raise LatticedError(
            grpc.StatusCode.ABORTED,
            f"the scene was edited while its points were asked for, {_MOST_POINTS} at a time",
            "REVISION_CHANGED",
        )

    def joined(name: str) -> npt.NDArray[np.float64]:
        return np.concatenate([np.array(getattr(answer, name), dtype=float) for answer in answers])

    normals = joined("normals").reshape(-1, 3)
    return Evaluation(
        joined("positions").reshape(-1, 3),
        joined("jacobians").reshape(-1, 3, 3).transpose(0, 2, 1),  # column-major on the wire
        normals if len(normals) else None,
        answers[0].revision,
    )
