# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Uploads the bytes of a mesh."""
from __future__ import annotations

import hashlib
from typing import Any, Iterator, Union

import grpc

from latticed.connection import Connection
from latticed.errors import LatticedError
from latticed.progress_bar import ProgressFunction
from latticed.retries import with_retries
from latticed.v1 import mesh_pb2

Bytes = Union[bytes, memoryview]

PART_BYTES = 768 * 1024  # the most data bytes that one message may hold

SUFFIXES = {
    ".obj": mesh_pb2.MESH_FORMAT_OBJ,
    ".ply": mesh_pb2.MESH_FORMAT_PLY,
    ".stl": mesh_pb2.MESH_FORMAT_STL,
    ".glb": mesh_pb2.MESH_FORMAT_GLB,
    ".drc": mesh_pb2.MESH_FORMAT_DRACO,
}


def upload(
    connection: Connection, header: mesh_pb2.MeshHeader, data: Bytes, progress: ProgressFunction
) -> Any:
    """Sends the mesh unless the server has it. Returns its latticed.v1.Mesh."""
    header.total_bytes = len(data)
    header.sha256 = hashlib.sha256(data).hexdigest()
    # A Mesh does not hold its RawLayout, so a client cannot see whether the layouts are the same.
    if header.format != mesh_pb2.MESH_FORMAT_RAW:
        present = _find(connection, header)
        if present is not None:
            progress(len(data), len(data))
            return present
    metadata = connection.metadata()
    return with_retries(
        connection.reachability,
        lambda: connection.meshes.UploadMesh(_parts(header, data, progress), metadata=metadata),
    )


def _find(connection: Connection, header: mesh_pb2.MeshHeader) -> Any:
    try:
        mesh = connection.call(connection.meshes.GetMesh, mesh_pb2.GetMeshRequest(mesh=header.sha256))
    except LatticedError as error:
        if error.code == grpc.StatusCode.NOT_FOUND:
            return None
        raise
    return mesh if mesh.format == header.format else None


def _parts(
    header: mesh_pb2.MeshHeader, data: Bytes, progress: ProgressFunction
) -> Iterator[mesh_pb2.UploadMeshRequest]:
    yield mesh_pb2.UploadMeshRequest(header=header)
    for begin in range(0, len(data), PART_BYTES):
        part = bytes(data[begin : begin + PART_BYTES])
        yield mesh_pb2.UploadMeshRequest(data=part)
        progress(begin + len(part), len(data))
