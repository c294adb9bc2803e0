# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Converts numpy arrays to a mesh file of the format RAW (RawLayout in mesh.proto)."""
from __future__ import annotations

import itertools
from typing import Any, List, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

from latticed.v1 import mesh_pb2

# Vertex indices: an array (faces, corners per face), or one sequence per face.
Faces = Union[npt.ArrayLike, Sequence[Sequence[int]]]


def _corners(faces: Faces) -> Tuple[int, npt.NDArray[np.uint32], npt.NDArray[np.uint32] | None]:
    """Returns corners per face, or 0 if faces differ; all corners, flat; the faces' sizes, if they differ."""
    if isinstance(faces, np.ndarray) and faces.ndim == 2:
        return faces.shape[1], _numbers("faces", faces).reshape(-1), None
    rows: Any = faces
    sizes = np.array([len(row) for row in rows], dtype="<u4")
    corners = _numbers("faces", list(itertools.chain.from_iterable(rows)))
    if sizes.size and (sizes == sizes[0]).all():
        return int(sizes[0]), corners, None
    return 0, corners, sizes


def _numbers(name: str, values: npt.ArrayLike) -> npt.NDArray[np.uint32]:
    """Checks and converts indices of vertices or groups."""
    numbers = np.asarray(values)
    if numbers.size and not np.issubdtype(numbers.dtype, np.integer):
        raise ValueError(f"{name} hold integers, not {numbers.dtype}")
    if numbers.size and not (0 <= numbers.min() and numbers.max() < 2**32):
        raise ValueError(f"{name} hold numbers of 0 or more, below 2^32")
    return numbers.astype("<u4")


def _attribute(
    name: str, values: npt.ArrayLike, width: int, vertices: int, corners: int
) -> Tuple[mesh_pb2.AttributeDomain, npt.NDArray[np.float32]]:
    """The attribute's domain (AttributeDomain) and its values."""
    array = np.asarray(values, dtype="<f4")
    if array.ndim not in (2, 3) or array.shape[-1] != width:
        raise ValueError(
            f"{name} have the shape (vertices, {width}) or (corners, {width}), not {array.shape}"
        )
    count = array.size // width
    if array.ndim == 2 and count == vertices:
        return mesh_pb2.ATTRIBUTE_DOMAIN_VERTEX, array
    if count == corners:
        return mesh_pb2.ATTRIBUTE_DOMAIN_CORNER, array
    raise ValueError(f"{count} {name} for {vertices} vertices and {corners} corners")


def raw_mesh(
    positions: npt.ArrayLike,
    faces: Faces,
    normals: npt.ArrayLike | None,
    uvs: npt.ArrayLike | None,
    face_groups: npt.ArrayLike | None,
    group_names: Sequence[str],
    weights: npt.ArrayLike | None = None,
) -> Tuple[mesh_pb2.RawLayout, bytes]:
    """Returns layout and bytes. Client.upload_arrays describes the arguments. ValueError for wrong shapes."""
    points = np.asarray(positions)
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(f"positions have the shape (vertices, 3), not {points.shape}")
    single = points.dtype == np.float32
    face_size, corners, sizes = _corners(faces)
    layout = mesh_pb2.RawLayout(
        vertex_count=len(points),
        face_count=len(corners) // max(1, face_size) if sizes is None else len(sizes),
        corner_count=len(corners),
        face_size=face_size,
        position_type=mesh_pb2.SCALAR_TYPE_FLOAT32 if single else mesh_pb2.SCALAR_TYPE_FLOAT64,
        group_names=list(group_names),
    )
    arrays: List[npt.NDArray[np.generic]] = [points.astype("<f4" if single else "<f8")]
    if sizes is not None:
        arrays.append(sizes)
    arrays.append(corners)
    if normals is not None:
        layout.normals, array = _attribute("normals", normals, 3, len(points), len(corners))
        arrays.append(array)
    if uvs is not None:
        layout.uvs, array = _attribute("uvs", uvs, 2, len(points), len(corners))
        arrays.append(array)
    if (face_groups is not None) != bool(group_names):
        raise ValueError("face_groups and group_names belong together")
    if face_groups is not None:
        groups = _numbers("face_groups", face_groups)
        if groups.shape != (layout.face_count,):
            raise ValueError(f"face_groups have the shape ({layout.face_count},), not {groups.shape}")
        arrays.append(groups)
    if weights is not None:
        of_vertices = np.asarray(weights, dtype="<f4")
        if of_vertices.shape != (len(points),):
            raise ValueError(f"weights have the shape ({len(points)},), not {of_vertices.shape}")
        layout.weights = True
        arrays.append(of_vertices)
    return layout, b"".join(array.tobytes() for array in arrays)
