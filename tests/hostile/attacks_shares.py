# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Row 4: what one caller can take of what all share. Each ends with what the attacker could not take."""
import time

import meshes
from attack import CLOSED, TIDY_SOURCE, attack
from calls import Refused, beside, create_scene, delete, export_request, unary, upload
from http2 import message
from latticed.v1 import mesh_pb2, scene_pb2

WRITE_TIMEOUT = ("--write-timeout", "3s")
MOST_UPLOADS = 64
SCENE = "a-scene-of-mallory"


def grid_scene(target, side, **options):
    """Makes a scene of a grid. Returns a function that deletes it."""
    connection = target.connect()
    layout, data = meshes.raw_grid(side)
    mesh = upload(connection, mesh_pb2.MESH_FORMAT_RAW, data, layout).id
    create_scene(connection, SCENE, mesh, **options)
    connection.close()
    return lambda: delete(target.connect(TIDY_SOURCE), [SCENE], [mesh])


def hold(target, connections):
    """Keeps connections open, and takes what comes, until the end of the attack."""
    for _ in target.until_end():
        for connection in connections:
            connection.hear(0.01)


@attack("4a", quick={"direct": 1}, leaves_traces=True)
def announced_uploads(target, seen):
    """Uploads of 1 GiB, else of less, of which 8 kB come."""
    connection = target.connect()
    for size in (1 << 30, 100 << 20, 10 << 20, 1 << 20):
        for number in range(MOST_UPLOADS):
            header = mesh_pb2.MeshHeader(format=mesh_pb2.MESH_FORMAT_OBJ, total_bytes=size)
            try:
                request = mesh_pb2.BeginUploadRequest(header=header)
                begun = unary(connection, "MeshService/BeginUpload", request, mesh_pb2.BeginUploadResponse)
                part = mesh_pb2.AppendUploadRequest(upload_id=begun.upload_id, data=bytes(8000))
                unary(connection, "MeshService/AppendUpload", part)
                seen.count(f"of {size >> 20} MiB")
            except Refused as error:
                seen.count_status(error.status)
                break
    hold(target, [connection])


@attack("4b", seconds=8, options=WRITE_TIMEOUT)
def exports_that_nobody_reads(target, seen):
    tidy = grid_scene(target, 60)
    connections = [target.connect(window=0) for _ in range(8)]
    streams = [connection.begin("SceneService/Export") for connection in connections]
    for connection, stream in zip(connections, streams):
        connection.send_data(stream, export_request(SCENE, 8))
    hold(target, connections)
    ended = sum(stream in connection.ended for connection, stream in zip(connections, streams))
    going_on = target.calls_going_on("Export")
    seen.count("exports", len(streams))
    seen.count("seen to end", ended)  # the proxy still holds what its client does not take
    seen.expect(going_on == 0, f"{going_on} unread exports go on after {target.seconds} s")
    for connection in connections:
        connection.close()
    tidy()


@attack("4c")
def watches(target, seen):
    """1,020 watches of the honest client's scene, which nobody reads."""
    request = scene_pb2.WatchRequest(scene=target.scene, max_unacked_updates=0)
    connections = [target.connect(f"127.0.1.{1 + number // 4}", window=0) for number in range(12)]
    for connection in connections:
        for _ in range(85):
            stream = connection.begin("SceneService/Watch")
            connection.send_data(stream, message(request.SerializeToString()))
    hold(target, connections)
    seen.count("watches", 12 * 85)
    seen.count("refused", sum(len(connection.ended) for connection in connections))


@attack("4d", options=WRITE_TIMEOUT)
def unread_replies(target, seen):
    """104 lattices of 32³ points, 0.8 MB each."""
    tidy = grid_scene(target, 10, size=32)
    request = message(scene_pb2.GetLatticeRequest(scene=SCENE).SerializeToString())
    connections = [target.connect(window=0) for _ in range(2)]
    for connection in connections:
        for _ in range(52):
            connection.send_data(connection.begin("SceneService/GetLattice"), request)
    hold(target, connections)
    seen.count("replies", 2 * 52)
    seen.count("seen to end", sum(len(connection.ended) for connection in connections))
    for connection in connections:
        connection.close()
    tidy()


@attack("4f", quick={"direct": 1}, options=["--max-scenes", "400"])
def tiny_scenes(target, seen):
    triangle = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    mesh = upload(target.connect(), mesh_pb2.MESH_FORMAT_OBJ, triangle).id
    made = []

    def work(number):
        connection = target.connect()
        for _ in target.until_end():
            scene = f"tiny-{number}-{len(made):06}-{time.monotonic_ns()}"
            try:
                create_scene(connection, scene, mesh)
                made.append(scene)
                seen.count("scenes")
            except Refused as error:
                seen.count_status(error.status)
            except CLOSED:
                connection = target.connect_again(seen)

    beside(4, work)
    delete(target.connect(TIDY_SOURCE), made, [mesh])
