# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
import subprocess
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

import grpc
import latticed
import pytest

from server_process import ServerProcess


def test_the_server_says_what_it_is(client):
    info = client.server_info()

    assert info.version and info.limits.max_part_bytes == 768 * 1024


def test_no_server_is_unavailable():
    with latticed.connect("127.0.0.1:1", retry_for=0) as client, pytest.raises(
        latticed.LatticedError
    ) as caught:
        client.server_info()

    assert caught.value.code == grpc.StatusCode.UNAVAILABLE
    assert (caught.value.reason, caught.value.request_id) == ("", "")


def test_an_error_names_kind_and_id(client):
    with pytest.raises(latticed.LatticedError) as caught:
        client.scene("no-such-scene")

    error = caught.value
    assert (error.code, error.reason) == (grpc.StatusCode.NOT_FOUND, "NOT_FOUND")
    assert error.metadata == {"kind": "scene", "id": "no-such-scene"}
    assert str(error) == f"no scene with id 'no-such-scene' (NOT_FOUND, request {error.request_id})"


class Recorder(grpc.GenericRpcHandler):
    """A server that implements no call. It records the name and metadata of each call."""

    def __init__(self):
        self.calls = []

    def service(self, call):
        self.calls.append((call.method.rsplit("/", 1)[1], dict(call.invocation_metadata)))

    @contextmanager
    def served(self):
        """Gives the server's address. The server stops at the end of the block."""
        server = grpc.server(ThreadPoolExecutor(), handlers=[self])
        port = server.add_insecure_port("127.0.0.1:0")
        server.start()
        yield f"127.0.0.1:{port}"
        server.stop(None)


def test_every_call_about_a_scene_names_it_for_routing(scene):
    recorder = Recorder()

    with recorder.served() as address, latticed.connect(address, token="secret") as client:
        elsewhere = latticed.Scene(client._connection, scene.info)
        asks = [
            lambda: client.create_scene(scene.info.mesh, scene_id=scene.id),
            lambda: client.scene(scene.id),
            elsewhere.refresh,
            elsewhere.lattice,
            elsewhere.get_update,
            lambda: elsewhere.provenance(scene.get_update()),
            elsewhere.deform,
            elsewhere.watch,
            lambda: elsewhere.evaluate([[0, 0, 0]]),
            lambda: elsewhere.export_bytes("ply"),
            lambda: elsewhere.move([0], (1, 0, 0)),
            elsewhere.delete,
        ]
        for ask in asks:
            with pytest.raises(latticed.LatticedError) as caught:
                ask()
            assert caught.value.code == grpc.StatusCode.UNIMPLEMENTED

    assert len(recorder.calls) == len(asks)
    for method, metadata in recorder.calls:
        assert metadata.get("latticed-scene") == scene.id, method
        assert metadata.get("authorization") == "Bearer secret", method


def test_scenes_are_listed_and_the_same_request_is_the_same_scene(client, box):
    first = client.create_scene(box, scene_id="scene-of-python", labels={"from": "python"}, idle_ttl=60)
    again = client.create_scene(box, scene_id="scene-of-python", labels={"from": "python"}, idle_ttl=60)

    assert (first.id, first.labels) == ("scene-of-python", {"from": "python"})
    assert first.info.idle_ttl.seconds == 60
    assert again.info.create_time == first.info.create_time
    assert [scene.id for scene in client.scenes("from=python")] == ["scene-of-python"]
    first.delete()
    assert client.scenes("from=python") == []


def test_scene_ids_have_128_random_bits_and_scenes_stay_unless_told(client, box):
    with client.create_scene(box) as first, client.create_scene(box) as second:
        pass

    assert len(first.id) == len(second.id) == 32 and first.id != second.id
    assert client.scene(first.id).id == first.id
    with client.create_scene(box, delete_on_exit=True) as third:
        pass
    with pytest.raises(latticed.LatticedError):
        client.scene(third.id)


def test_address_and_token_of_the_environment(monkeypatch):
    recorder = Recorder()
    with recorder.served() as address:
        monkeypatch.setenv("LATTICED_SERVER", address)
        monkeypatch.setenv("LATTICED_TOKEN", "editor")
        for token in (None, "reader"):
            with latticed.connect(token=token) as client, pytest.raises(latticed.LatticedError):
                client.server_info()

    tokens = [metadata["authorization"] for _, metadata in recorder.calls]
    assert tokens == ["Bearer editor", "Bearer reader"]


def test_tls_with_a_root_of_ones_own(tmp_path):
    certificate, key = tmp_path / "cert.pem", tmp_path / "key.pem"
    subject = ["-subj", "/CN=localhost", "-addext", "subjectAltName=IP:127.0.0.1"]
    request = "openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 1".split()
    subprocess.run([*request, *subject, "-keyout", key, "-out", certificate], check=True, capture_output=True)

    with ServerProcess("--tls-cert", certificate, "--tls-key", key) as server:
        for root in (certificate, certificate.read_bytes()):
            with latticed.connect(server.address, tls_ca=root) as client:
                assert client.server_info().version
        with latticed.connect(server.address, retry_for=0) as client, pytest.raises(latticed.LatticedError):
            client.server_info()
