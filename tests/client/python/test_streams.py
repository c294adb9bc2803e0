# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
import threading
import time

import latticed
import numpy as np
import pytest

import definition
from server_process import ServerProcess

RAW = latticed.View(encoding="raw", segments=2)


def test_an_edit_is_waited_for(scene):
    with scene.deform(RAW) as stream:
        first = stream.latest
        edit = stream.move(stream.lattice.indices, (1, 2, 3))
        update = stream.wait(edit, timeout=60)
        result = stream.result(edit)

    assert (first.revision, update.revision, update.applied_sequence) == (0, 1, 1)
    assert (result.sequence, result.revision) == (1, 1)
    assert result.timings.apply_us > 0 and update.timings.evaluate_us > 0
    np.testing.assert_allclose(
        update.points - first.points, np.broadcast_to([1, 2, 3], first.points.shape), atol=1e-5
    )


def test_iteration_ends_after_the_last_edit(scene):
    with scene.deform(RAW) as stream:
        for _ in range(5):
            stream.move([0], (1, 0, 0))
        stream.finish()
        revisions = [update.revision for update in stream]

        assert revisions == sorted(set(revisions)) and revisions[-1] == 5
        with pytest.raises(RuntimeError, match="no more edits"):
            stream.move([0], (1, 0, 0))


def test_an_update_tells_which_chunks_came(client, random):
    n = 90
    x, y = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n))
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).reshape(-1, 1)
    faces = corner + np.array([0, 1, n + 1, n])
    sheet = client.upload_arrays(np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3), faces)

    with client.create_scene(sheet, size=(9, 9, 4), delete_on_exit=True) as scene, scene.deform(
        RAW
    ) as stream:
        before = stream.latest
        after = stream.wait(stream.move(stream.lattice.indices[0, 0, 0], (0, 0, 1)), timeout=60)

    changed = after.changed_since(before)
    assert 0 < len(changed) < after.topology.chunks
    moved = np.abs(after.points - before.points).max(axis=(1, 2)) > 0
    for chunk in range(after.topology.chunks):
        assert moved[after.topology.patches_of(chunk)].any() == (chunk in changed)
        assert (after.chunk_revisions[chunk] == 1) == (chunk in changed)


def test_a_refusal_is_raised_by_wait_and_result_and_the_stream_goes_on(scene):
    with scene.deform(RAW) as stream:
        bad = stream.move([9999], (1, 0, 0))
        good = stream.move([0], (1, 0, 0))

        for ask in (stream.wait, stream.result):
            with pytest.raises(latticed.LatticedError) as caught:
                ask(bad, timeout=60)
            assert caught.value.reason == "OUT_OF_RANGE"
        assert stream.wait(good, timeout=60).applied_sequence == good
        with pytest.raises(ValueError, match="edit 3 was never sent"):
            stream.wait(3)


def test_a_refusal_that_nobody_asked_about_is_raised_at_the_end(scene):
    with pytest.raises(latticed.LatticedError) as caught:
        with scene.deform(RAW) as stream:
            stream.move([9999], (1, 0, 0))

    assert caught.value.reason == "OUT_OF_RANGE"


def test_the_view_can_be_changed_on_the_way(scene):
    with scene.deform(RAW) as stream:
        before = stream.latest
        stream.set_view(latticed.View(encoding="quantised", segments=3, normals="none"))
        update = stream.next_update(timeout=60)
        while update.view.segments != 3:
            update = stream.next_update(timeout=60)

    assert update.points.shape == (scene.patches, 10, 3) and update.normals is None
    assert update.changed_since(before) == list(range(update.topology.chunks))


def test_a_paused_stream_has_no_updates_until_it_goes_on(scene):
    with scene.deform(RAW) as stream:
        stream.pause()
        edit = stream.move([0], (1, 0, 0))
        assert stream.result(edit, timeout=60).revision == 1
        with pytest.raises(TimeoutError, match="within 0.1 seconds"):
            stream.wait(edit, timeout=0.1)
        stream.pause(False)
        assert stream.wait(edit, timeout=60).revision == 1


def test_a_watcher_sees_what_others_do(client, scene):
    with client.scene(scene.id).watch(RAW) as stream:
        assert stream.next_update(timeout=60).revision == 0
        with pytest.raises(TimeoutError):
            stream.next_update(timeout=0.05)
        scene.move(scene.lattice().indices, (1, 0, 0))
        update = stream.next_update(timeout=60)
        stream.set_view(latticed.View(encoding="raw", segments=1))

        assert update.revision == 1
        assert stream.next_update(timeout=60).points.shape == (scene.patches, 3, 3)
        np.testing.assert_array_equal(stream.lattice.control_points, scene.lattice().control_points)


def test_closing_lets_those_who_wait_go(scene):
    stream = scene.watch(RAW)
    stream.next_update(timeout=60)
    got = []
    waiter = threading.Thread(target=lambda: got.append(stream.next_update()))
    waiter.start()

    stream.close()
    waiter.join(timeout=60)

    assert got == [None]


def test_an_edit_of_a_stream_that_was_closed_is_cancelled(scene):
    with scene.deform(RAW) as stream:
        stream.pause()
        edit = stream.move([0], (1, 0, 0))
        stream.close()
        with pytest.raises(latticed.LatticedError) as caught:
            stream.wait(edit)
        with pytest.raises(RuntimeError, match="no more edits"):
            stream.move([0], (1, 0, 0))

    assert caught.value.code.name == "CANCELLED"


def test_a_closed_client_ends_its_streams(server, scene):
    client = latticed.connect(server.address)
    with client.scene(scene.id).watch(RAW) as stream:
        stream.next_update(timeout=60)
        client.close()

        with pytest.raises(ValueError, match="[Cc]hannel"):
            stream.next_update(timeout=60)


def test_an_idle_stream_lives_by_heartbeats():
    with ServerProcess("--heartbeat-interval", "100ms") as server, latticed.connect(server.address) as client:
        scene = client.create_scene(client.upload_arrays(definition.BOX_POSITIONS, definition.BOX_FACES))
        with scene.watch(RAW) as watch, scene.deform(RAW) as deform:
            assert watch.next_update(timeout=60).revision == deform.next_update(timeout=60).revision == 0
            time.sleep(1)  # a watcher silent for three heartbeats would be paused
            scene.move([0], (1, 0, 0))

            assert watch.next_update(timeout=60).revision == deform.next_update(timeout=60).revision == 1
            assert watch.reconnections == deform.reconnections == 0


def test_a_stream_of_no_scene_is_an_error_at_once(client, scene):
    gone = client.create_scene(scene.info.mesh)
    gone.delete()

    for begin in (gone.deform, gone.watch):
        with pytest.raises(latticed.LatticedError) as caught:
            begin(RAW)
        assert caught.value.reason == "NOT_FOUND"


def test_an_editor_can_go_on_in_another_stream(scene):
    with scene.deform(RAW, editor_id="editor-of-two-streams") as stream:
        stream.wait(stream.move([0], (1, 0, 0)), timeout=60)
    with scene.deform(RAW, editor_id="editor-of-two-streams") as stream:
        edit = stream.undo()
        stream.wait(edit, timeout=60)

    assert edit == 2
    assert scene.lattice().revision == 2
