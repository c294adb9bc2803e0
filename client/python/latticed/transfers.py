# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Rpcs that stream to the client. All are made again after a broken connection."""
from __future__ import annotations

import hashlib
import os
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, Callable, Iterator, List, Union

from latticed.choices import choose
from latticed.connection import Connection
from latticed.errors import LatticedError
from latticed.exported import Exported
from latticed.patches.plan import PatchPlan
from latticed.patches.plan_reader import read_plan
from latticed.progress_bar import ProgressFunction
from latticed.provenance import Provenance
from latticed.retries import with_retries
from latticed.surface import Surface
from latticed.topology import Topology
from latticed.update import Update
from latticed.v1 import mesh_pb2, patches_pb2, scene_pb2, surface_pb2
from latticed.view import NORMALS

EXPORT_FORMATS = {
    "ply": surface_pb2.EXPORT_FORMAT_PLY,
    "obj": surface_pb2.EXPORT_FORMAT_OBJ,
    "stl": surface_pb2.EXPORT_FORMAT_STL,
    "glb": surface_pb2.EXPORT_FORMAT_GLB,
    "drc": surface_pb2.EXPORT_FORMAT_DRC,
    "nets": surface_pb2.EXPORT_FORMAT_CONTROL_NETS,
    "usda": surface_pb2.EXPORT_FORMAT_USD,
}


def get_update(connection: Connection, request: scene_pb2.GetUpdateRequest) -> Update:
    """Fetches one complete update."""

    def attempt() -> Update:
        surface = Surface()
        call = connection.scenes.GetUpdate(request, metadata=connection.metadata(request.scene))
        try:
            updates = [update for update in map(surface.apply, call) if update is not None]
        finally:
            call.cancel()
        if not updates:
            raise LatticedError.data_loss("the server sent no complete update")
        return updates[-1]

    return with_retries(connection.reachability, attempt)


def get_provenance(connection: Connection, scene: str, topology: Topology) -> Provenance:
    """Fetches all parts of GetTopology."""
    request = surface_pb2.GetTopologyRequest(scene=scene, topology_id=topology.id)

    def attempt() -> List[Any]:
        return list(connection.scenes.GetTopology(request, metadata=connection.metadata(scene)))

    return Provenance.from_parts(topology, with_retries(connection.reachability, attempt))


def get_patch_plan(connection: Connection, scene: str, topology_id: str, normals: str) -> PatchPlan:
    """Fetches all parts of GetPatchPlan."""
    request = patches_pb2.GetPatchPlanRequest(
        scene=scene, topology_id=topology_id, normals=choose("normals", normals, NORMALS)
    )

    def attempt() -> PatchPlan:
        return read_plan(connection.scenes.GetPatchPlan(request, metadata=connection.metadata(scene)))

    return with_retries(connection.reachability, attempt)


def export(
    connection: Connection,
    request: surface_pb2.ExportRequest,
    open_file: Callable[[], BinaryIO],
    progress: ProgressFunction,
) -> Exported:
    """Writes the bytes to a file, which each attempt opens anew."""

    def attempt() -> Exported:
        header, done = surface_pb2.ExportHeader(), 0
        with open_file() as file:
            for part in connection.scenes.Export(request, metadata=connection.metadata(request.scene)):
                if part.HasField("header"):
                    header = part.header
                file.write(part.data)
                done += len(part.data)
                progress(done, header.bytes)
        if done != header.bytes:
            raise LatticedError.data_loss(f"an export of {header.bytes} bytes ended after {done}")
        return Exported(header.revision, header.certified_error)

    return with_retries(connection.reachability, attempt)


def download(connection: Connection, mesh: str, file: BinaryIO, progress: ProgressFunction) -> None:
    """Writes the uploaded bytes; after a break it continues at the next byte. DATA_LOSS if their SHA-256 is
    not the mesh's id."""
    total, done, digest = 0, 0, hashlib.sha256()

    def attempt() -> None:
        nonlocal total, done
        request = mesh_pb2.DownloadMeshRequest(mesh=mesh, offset=done)
        for part in connection.meshes.DownloadMesh(request, metadata=connection.metadata()):
            if part.HasField("header"):
                total = part.header.total_bytes
            file.write(part.data)
            digest.update(part.data)
            done += len(part.data)
            progress(done, total)

    with_retries(connection.reachability, attempt)
    if done != total or digest.hexdigest() != mesh:
        raise LatticedError.data_loss(f"a download of {total} bytes ended after {done}, or with others")


@contextmanager
def whole_file(path: Union[str, "os.PathLike[str]"]) -> Iterator[Path]:
    """A temporary path to write to. The end of the block moves it to `path`; an exception deletes it."""
    part = Path(f"{os.fspath(path)}.part")
    try:
        yield part
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)
