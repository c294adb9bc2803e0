# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
import random
import socket
import threading
import time

import grpc
import latticed
import numpy as np
import pytest
from latticed.v1 import server_pb2, server_pb2_grpc

import definition
from cutting_proxy import CuttingProxy
from server_process import ServerProcess

RAW = latticed.View(encoding="raw", segments=2)


@pytest.fixture
def proxy(server):
    made = CuttingProxy(server.port)
    yield made
    made.close()


@pytest.fixture
def remote(proxy, scene):
    """The scene, reached through the proxy."""
    with latticed.connect(proxy.address) as client:
        yield client.scene(scene.id)


def test_edits_of_a_broken_stream_count_once(proxy, remote, scene):
    with remote.deform(RAW) as stream:
        for i in range(40):
            last = stream.move([0], (1, 0, 0))
            if i % 10 == 5:
                proxy.cut()
        update = stream.wait(last, timeout=60)

    assert stream.reconnections >= 1
    assert update.revision == 40
    lattice = scene.lattice()
    assert lattice.revision == 40
    assert lattice.control_points[0, 0, 0, 0] - lattice.rest()[0, 0, 0, 0] == pytest.approx(40)


def test_edits_whose_answers_are_lost_count_once_too(proxy, remote, scene):
    with remote.deform(RAW) as stream:
        proxy.lose_answers()
        first, second = (stream.move(stream.lattice.indices, (1, 0, 0)) for _ in range(2))
        scene.get_update(RAW, min_revision=2)
        proxy.cut()

        update = stream.wait(first, timeout=60)
        assert (update.revision, update.applied_sequence) == (2, second)
        assert stream.result(second, timeout=60).revision == 2
        with pytest.raises(latticed.LatticedError, match="lost with its connection"):
            stream.result(first, timeout=60)
        assert stream.wait(stream.move([0], (1, 0, 0)), timeout=60).revision == 3


@pytest.mark.parametrize("how", ["silence", "lose_answers"])
def test_a_connection_that_vanishes_without_a_word_is_noticed(proxy, remote, how):
    with remote.deform(RAW) as stream:
        getattr(proxy, how)()
        cut = time.monotonic()
        update = stream.wait(stream.move([0], (1, 0, 0)), timeout=60)

        pause = time.monotonic() - cut
        print(f"the editor went on after {pause:.1f} s")  # 1.6 to 1.8 are expected
        assert pause < 30 and update.revision == 1 and stream.reconnections == 1


def test_a_slow_line_that_is_busy_with_large_updates_is_not_taken_for_a_cut_one(server, client):
    side = np.linspace(0, 1, 41)
    grid = np.stack(np.meshgrid(side, side, [0.0]), axis=-1).reshape(-1, 3)
    corner = np.arange(41 * 41).reshape(41, 41)
    faces = np.stack([corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]], axis=-1)
    mesh = client.upload_arrays(grid, faces.reshape(-1, 4))
    line = CuttingProxy(server.port, rate=200_000)
    with client.create_scene(mesh, delete_on_exit=True) as scene, latticed.connect(line.address) as distant:
        with distant.scene(scene.id).deform(latticed.View(encoding="raw", segments=4)) as stream:
            assert stream.latest.bytes > 800_000  # four seconds
            stream.wait(stream.move(stream.lattice.indices, (0, 0, 1)), timeout=60)

            assert stream.reconnections == 0
    line.close()


def test_pings_without_a_call_are_answered(server):
    line = CuttingProxy(server.port)
    hasty = [
        ("grpc.keepalive_time_ms", 600),
        ("grpc.keepalive_permit_without_calls", 1),
        ("grpc.http2.max_pings_without_data", 0),
    ]
    with grpc.insecure_channel(line.address, options=hasty) as channel:
        info = server_pb2_grpc.ServerServiceStub(channel).GetServerInfo
        info(server_pb2.GetServerInfoRequest())
        channel.subscribe(lambda state: None)  # gRPC then sees the answers at once
        before = line.requests
        while line.requests < before + 6:
            time.sleep(0.1)
        info(server_pb2.GetServerInfoRequest())

        assert line.connections == 1
    line.close()


def test_pings_in_place_of_heartbeats_are_answered():
    with ServerProcess("--heartbeat-interval", "10m") as server:
        line = CuttingProxy(server.port)
        with latticed.connect(line.address) as client:
            mesh = client.upload_arrays(definition.BOX_POSITIONS, definition.BOX_FACES)
            with client.create_scene(mesh).watch(RAW) as stream:
                before = line.requests
                while line.requests < before + 8:
                    time.sleep(0.1)

                assert stream.reconnections == 0 and line.connections == 2  # one is for other calls
        line.close()


def test_a_watcher_goes_on_with_what_it_has(proxy, remote, scene):
    with remote.watch(RAW) as stream:
        before = stream.next_update(timeout=60)
        proxy.cut()
        scene.move(scene.lattice().indices[-1], (1, 0, 0))
        update = stream.next_update(timeout=60)
        while update.revision < 1:
            update = stream.next_update(timeout=60)

    np.testing.assert_allclose(update.points, scene.get_update(RAW).points)
    assert np.abs(update.points - before.points).max() > 0.1


@pytest.mark.parametrize("kind", ["watch", "deform"])
def test_view_and_pause_outlive_a_cut(proxy, remote, scene, kind):
    with getattr(remote, kind)(RAW) as stream:
        stream.set_view(latticed.View(encoding="raw", segments=1))
        while stream.latest.view.segments != 1:
            stream.next_update(timeout=60)
        stream.pause()
        proxy.cut()
        with pytest.raises(TimeoutError):
            for _ in range(20):  # an update may have begun before the new stream was told to pause
                scene.move([0], (1, 0, 0))
                stream.next_update(timeout=0.5)
        stream.pause(False)
        newest = scene.refresh().revision
        while stream.latest.revision < newest:
            stream.next_update(timeout=60)

        assert stream.latest.view.segments == 1 and stream.reconnections >= 1


def free_port():
    """A free port that the system gives to nobody, so that a restarted server can use it again."""
    while True:
        port = random.randrange(20_000, 30_000)
        with socket.socket() as taken:
            try:
                taken.bind(("127.0.0.1", port))
            except OSError:
                continue
        return port


def test_a_drag_goes_on_after_a_kill_and_can_be_undone(tmp_path, caplog):
    port, edits, undone = free_port(), 200, 120
    folder = ("--data-dir", tmp_path / "data")
    servers = [ServerProcess(*folder, port=port)]
    restarted = went_on = 0.0

    def restart():
        nonlocal restarted
        time.sleep(0.5)
        restarted = time.monotonic()
        servers.append(ServerProcess(*folder, port=port))

    restarter = threading.Thread(target=restart)
    with latticed.connect(servers[0].address) as client:
        mesh = client.upload_arrays(definition.BOX_POSITIONS, definition.BOX_FACES)
        scene = client.create_scene(mesh, size=(4, 4, 4))
        rest = scene.lattice().control_points
        with scene.deform(RAW) as stream:
            for number in range(1, edits + 1):
                sequence = stream.move([number % 64], (1, 0, 0))
                if number == 100:
                    servers[0].kill()
                    restarter.start()
                if number > 24:
                    stream.wait(sequence - 24, timeout=60)
                if number - 24 == 101:  # the first that only the new server can have answered
                    went_on = time.monotonic()
            stream.wait(sequence, timeout=60)
            restarter.join()
            pause = went_on - restarted
            print(f"the editor went on {1000 * pause:.0f} ms after the restart")
            assert 0 < pause < 15 and stream.reconnections >= 1
            assert_moved(scene, rest, edits, revision=edits)

            for _ in range(undone):
                sequence = stream.undo()
            stream.wait(sequence, timeout=60)
            assert_moved(scene, rest, edits - undone, revision=edits + undone)
    servers[1].stop()
    said = [record.message.split(" ", 2)[2] for record in caplog.records]
    assert said == ["unreachable, trying for 30 s …", "answers again"]


def assert_moved(scene, rest, edits, revision):
    """Asserts that the first `edits` moves count, each once: move n moves point n modulo 64 by 1 along x."""
    lattice = scene.lattice()
    expected = rest.reshape(-1, 3).copy()
    for number in range(1, edits + 1):
        expected[number % 64, 0] += 1
    assert lattice.revision == revision
    np.testing.assert_allclose(lattice.control_points.reshape(-1, 3), expected, atol=1e-12)


def test_a_stream_whose_server_is_gone_ends_unavailable(caplog):
    with ServerProcess() as server:
        with latticed.connect(server.address, retry_for=0.5) as client:
            mesh = client.upload_arrays(definition.BOX_POSITIONS, definition.BOX_FACES)
            stream = client.create_scene(mesh).watch(RAW)
            stream.next_update(timeout=60)
            server.stop()

            with pytest.raises(latticed.LatticedError) as caught:
                stream.next_update(timeout=120)
            assert caught.value.code.name == "UNAVAILABLE"
    waits = f"server {server.address} unreachable, trying for 0.5 s …"
    assert [record.message for record in caplog.records] == [waits]


def test_a_scene_of_a_list_that_is_asleep_can_be_edited(tmp_path):
    folder = ("--data-dir", tmp_path / "data")
    server = ServerProcess(*folder)
    with latticed.connect(server.address) as client:
        mesh = client.upload_arrays(definition.BOX_POSITIONS, definition.BOX_FACES)
        made = client.create_scene(mesh, size=(4, 4, 4))
        made.insert_knot("u", 0.25)
    server.kill()
    server = ServerProcess(*folder)
    with latticed.connect(server.address) as client:
        [scene] = client.scenes()
        assert repr(scene) == f"<Scene {made.id}: asleep>"
        assert scene.move([0], (1, 0, 0)).revision == 2
        [scene] = client.scenes()
        assert scene.patches > 0 and scene.info.revision == 2
    server.kill()
