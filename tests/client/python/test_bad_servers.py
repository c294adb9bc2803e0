# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Servers that send less than they announced, or fail the first calls."""
import hashlib
from concurrent.futures import ThreadPoolExecutor

import grpc
import latticed
import pytest
from latticed import retries
from latticed.google_rpc import Status
from latticed.v1 import event_pb2, mesh_pb2, mesh_pb2_grpc, scene_pb2, scene_pb2_grpc, surface_pb2

import definition


class Scenes(scene_pb2_grpc.SceneServiceServicer):
    def GetUpdate(self, request, context):
        return iter(())

    def Deform(self, requests, context):
        if next(requests).watch.scene != ENDED:
            return
        gone = Status(code=grpc.StatusCode.NOT_FOUND.value[0], message="it is gone")
        yield event_pb2.SceneEvent(goaway=event_pb2.Goaway(status=gone))
        for _ in requests:  # until the client half-closes
            pass
        context.abort(grpc.StatusCode.CANCELLED, "replaced by a proxy")

    def Export(self, request, context):
        yield surface_pb2.ExportResponse(header=surface_pb2.ExportHeader(bytes=5))
        yield surface_pb2.ExportResponse(data=b"1234")

    def GetTopology(self, request, context):
        yield surface_pb2.TopologyPart(patch_count=2, faces=[0])


MESH = b"0123456789"
ENDED = "scene-that-has-ended"


class Meshes(mesh_pb2_grpc.MeshServiceServicer):
    def __init__(self):
        self.uploads, self.offsets = [], []

    def DownloadMesh(self, request, context):
        self.offsets.append(request.offset)
        yield mesh_pb2.DownloadMeshResponse(header=mesh_pb2.MeshHeader(total_bytes=len(MESH)))
        yield mesh_pb2.DownloadMeshResponse(data=MESH[request.offset : request.offset + 4])
        if request.offset + 4 < len(MESH):
            code = grpc.StatusCode.UNKNOWN if request.offset else grpc.StatusCode.CANCELLED
            context.abort(code, "cut by a proxy")

    def UploadMesh(self, requests, context):
        first = next(requests)
        self.uploads.append(sum(len(request.data) for request in requests))
        if len(self.uploads) < 3:
            context.abort(grpc.StatusCode.UNAVAILABLE, "not yet")
        return mesh_pb2.Mesh(id=first.header.sha256)


@pytest.fixture
def meshes():
    return Meshes()


@pytest.fixture
def bad_client(meshes):
    server = grpc.server(ThreadPoolExecutor())
    scene_pb2_grpc.add_SceneServiceServicer_to_server(Scenes(), server)
    mesh_pb2_grpc.add_MeshServiceServicer_to_server(meshes, server)
    port = server.add_insecure_port("127.0.0.1:0")
    server.start()
    with latticed.connect(f"127.0.0.1:{port}") as client:
        yield client
    server.stop(None)


@pytest.mark.parametrize(
    "ask, text",
    [
        (lambda bad, good: bad.get_update(), "no complete update"),
        (lambda bad, good: bad.deform(), "before its first update"),
        (lambda bad, good: bad.export_bytes("ply"), "5 bytes ended after 4"),
        (lambda bad, good: bad.provenance(good.get_update()), "less than the whole topology"),
    ],
)
def test_less_than_was_promised_is_data_loss(bad_client, scene, ask, text):
    bad = latticed.Scene(bad_client._connection, scene_pb2.Scene(id=scene.id))

    with pytest.raises(latticed.LatticedError, match=text) as caught:
        ask(bad, scene)

    assert caught.value.code == grpc.StatusCode.DATA_LOSS


def test_the_error_of_a_goaway_counts_where_a_proxy_replaces_the_streams(bad_client):
    ended = latticed.Scene(bad_client._connection, scene_pb2.Scene(id=ENDED))

    with pytest.raises(latticed.LatticedError, match="it is gone") as caught:
        ended.deform()

    assert caught.value.code == grpc.StatusCode.NOT_FOUND


def test_a_download_goes_on_where_it_was(bad_client, meshes, tmp_path, monkeypatch):
    monkeypatch.setattr(retries, "_FIRST_PAUSE", 0.01)
    mesh = latticed.Mesh(bad_client._connection, mesh_pb2.Mesh(id=hashlib.sha256(MESH).hexdigest()))

    mesh.download(tmp_path / "mesh.obj")

    assert (tmp_path / "mesh.obj").read_bytes() == MESH
    assert meshes.offsets == [0, 4, 8]


def test_a_download_of_other_bytes_is_data_loss(bad_client, tmp_path, monkeypatch):
    monkeypatch.setattr(retries, "_FIRST_PAUSE", 0.01)
    mesh = latticed.Mesh(bad_client._connection, mesh_pb2.Mesh(id=hashlib.sha256(b"others").hexdigest()))

    with pytest.raises(latticed.LatticedError, match="or with others"):
        mesh.download(tmp_path / "mesh.obj")
    assert list(tmp_path.iterdir()) == []


def test_an_upload_is_made_again_from_its_begin(bad_client, meshes, monkeypatch):
    monkeypatch.setattr(retries, "_FIRST_PAUSE", 0.01)

    bad_client.upload_arrays(definition.BOX_POSITIONS, definition.BOX_FACES, progress=False)

    assert meshes.uploads == [8 * 24 + 24 * 4] * 3
