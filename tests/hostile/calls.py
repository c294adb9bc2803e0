# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Calls of an attacker with a token, over a hand-written connection (http2.py)."""
import threading
import time

from http2 import END_STREAM, message
from latticed.v1 import lattice_pb2, mesh_pb2, scene_pb2, surface_pb2

PART_BYTES = 768 << 10
PATIENCE_S = 60
BUSY = (8, 14)  # RESOURCE_EXHAUSTED, UNAVAILABLE: the server is still busy with the attack
TRIES = 50


class Refused(Exception):
    def __init__(self, status, words):
        super().__init__(f"status {status}: {words}")
        self.status = status


def words_of(connection, stream):
    return connection.trailers.get(stream, {}).get(b"grpc-message", b"").decode(errors="replace")


def finish(connection, stream, reply=None):
    status = connection.ending(stream, PATIENCE_S)
    data = connection.data.pop(stream, b"")
    if status != 0:
        raise Refused(status, words_of(connection, stream))
    return reply.FromString(bytes(data[5:])) if reply else None


def unary(connection, method, request, reply=None):
    stream = connection.begin(method)
    connection.send_data(stream, message(request.SerializeToString()))
    return finish(connection, stream, reply)


def upload(connection, kind, data, layout=None):
    """Uploads a mesh in one stream. Returns it."""
    header = mesh_pb2.MeshHeader(format=kind, total_bytes=len(data))
    if layout:
        header.raw_layout.vertex_count, header.raw_layout.face_count, header.raw_layout.corner_count = layout
        header.raw_layout.face_size, header.raw_layout.position_type = 4, mesh_pb2.SCALAR_TYPE_FLOAT32
    stream = connection.begin("MeshService/UploadMesh")
    parts = [mesh_pb2.UploadMeshRequest(header=header)]
    parts += [
        mesh_pb2.UploadMeshRequest(data=data[at : at + PART_BYTES]) for at in range(0, len(data), PART_BYTES)
    ]
    for part in parts:
        connection.send_data(stream, message(part.SerializeToString()), 0)
        if stream in connection.ended:
            break
    else:
        connection.send_data(stream, b"", END_STREAM)
    return finish(connection, stream, mesh_pb2.Mesh)


def create_scene(connection, scene, mesh, size=None, segments=0):
    request = scene_pb2.CreateSceneRequest(scene_id=scene, mesh=mesh)
    if size:
        axes = lattice_pb2.LatticeAxes(u=size, v=size, w=size)
        degree = lattice_pb2.LatticeAxes(u=2, v=2, w=2)
        request.lattices.add().fit.CopyFrom(lattice_pb2.LatticeFit(size=axes, degree=degree))
    request.default_view.segments = segments
    return unary(connection, "SceneService/CreateScene", request, scene_pb2.Scene)


def delete(connection, scenes=(), meshes=()):
    """Deletes them; what is not there is no error."""
    requests = [("SceneService/DeleteScene", scene_pb2.DeleteSceneRequest(scene=scene)) for scene in scenes]
    requests += [("MeshService/DeleteMesh", mesh_pb2.DeleteMeshRequest(mesh=mesh)) for mesh in meshes]
    for method, request in requests:
        for _ in range(TRIES):
            try:
                unary(connection, method, request)
                break
            except Refused as error:
                if error.status not in BUSY:
                    break
                time.sleep(0.1)


def export_request(scene, segments=0, kind=surface_pb2.EXPORT_FORMAT_PLY):
    request = surface_pb2.ExportRequest(scene=scene, format=kind)
    request.view.segments = segments
    return message(request.SerializeToString())


def beside(count, work):
    """Runs work(0) … work(count - 1) in threads, and raises what one of them raised."""
    errors = []

    def run(number):
        try:
            work(number)
        except Exception as error:  # noqa: BLE001
            errors.append(error)

    threads = [threading.Thread(target=run, args=(number,)) for number in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if errors:
        raise errors[0]
