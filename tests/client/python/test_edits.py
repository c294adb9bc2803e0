# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
import threading

import latticed
import numpy as np
import pytest
from latticed import edits

import definition


def test_each_edit_does_what_it_says(scene, random):
    lattice = scene.lattice()
    points = lattice.control_points.reshape(-1, 3)
    top, some = lattice.indices[-1], [3, 17, 40]
    mask = np.zeros(lattice.control_points.shape[:3], bool)
    mask[1, 2, 3] = True
    turn = np.array([[0, -1, 0, 2], [1, 0, 0, 3], [0, 0, 1, 4], [0, 0, 0, 1]], dtype=float)

    scene.move(top, (1, 2, 3))
    points[top.reshape(-1)] += [1, 2, 3]
    scene.set_points(some, [[1, 0, 0], [0, 1, 0], [0, 0, 1]])
    points[some] = np.eye(3)
    scene.set_points(mask, [[9, 9, 9]])
    points[lattice.indices[1, 2, 3]] = 9
    scene.transform(top, turn)
    points[top.reshape(-1)] = points[top.reshape(-1)] @ turn[:3, :3].T + turn[:3, 3]
    result = scene.apply([edits.move([0], (1, 0, 0)), edits.move([1], (0, 1, 0))])
    points[0] += [1, 0, 0]
    points[1] += [0, 1, 0]

    now = scene.lattice()
    assert result.sequence == result.revision == now.revision == 5
    np.testing.assert_allclose(now.control_points, lattice.control_points, atol=1e-12)


def test_a_parent_lattice_carries_control_points_in_a_gesture(scene):
    rest = scene.lattice().control_points
    parent = scene.lattice().resized((3, 3, 3), degree=(2, 2, 2))
    parent.control_points += np.random.default_rng(3).uniform(-1, 1, parent.control_points.shape)

    with scene.gesture() as drag:
        drag.carry(parent)
        drag.carry(parent)  # from the gesture's begin, so it counts once

    expected = parent.deform(rest.reshape(-1, 3)).reshape(rest.shape)
    np.testing.assert_allclose(scene.lattice().control_points, expected, atol=1e-12)
    scene.undo()
    np.testing.assert_array_equal(scene.lattice().control_points, rest)
    with pytest.raises(ValueError, match="no control points are named"):
        scene.carry(parent, [])


def test_undo_redo_and_reset(scene):
    rest = scene.lattice().control_points
    scene.move([0], (1, 0, 0))
    moved = scene.lattice().control_points

    scene.undo()
    np.testing.assert_array_equal(scene.lattice().control_points, rest)
    scene.redo()
    np.testing.assert_array_equal(scene.lattice().control_points, moved)
    scene.reset()
    np.testing.assert_allclose(scene.lattice().control_points, rest, atol=1e-12)
    scene.undo(whose="scene")
    np.testing.assert_array_equal(scene.lattice().control_points, moved)


def deformed(scene, random):
    """Moves all control points. Returns the lattice, points of the box, and where they are now."""
    lattice = scene.lattice()
    lattice.control_points += random.normal(scale=0.2, size=lattice.control_points.shape)
    scene.replace(lattice.control_points)
    points = random.uniform([0, 0, 0], [2, 1, 3], size=(50, 3))
    before = scene.evaluate(points).positions
    return lattice, points, before


def test_a_knot_more_changes_the_lattice_and_not_the_shape(scene, random):
    _, points, before = deformed(scene, random)

    result = scene.insert_knot("w", 1.25)
    after = scene.lattice()

    assert (result.structure_id, after.structure_id, after.size) == (2, 2, (4, 3, 6))
    np.testing.assert_allclose(scene.evaluate(points).positions, before, atol=1e-12)
    np.testing.assert_allclose(definition.deform(after, points), before, atol=1e-12)
    scene.move(after.indices[-1], (1, 0, 0))  # an edit of the new structure is accepted


def test_the_lattice_is_replaced_keeps_the_shape_if_asked_and_comes_back(scene, random):
    lattice, points, before = deformed(scene, random)

    kept = scene.replace_lattice(lattice.resized((4, 5, 8), (3, 1, 2)), keep_shape=True)
    assert (kept.structure_id, scene.lattice().size, scene.lattice().degree) == (2, (4, 5, 8), (3, 1, 2))
    assert kept.drag_residual < 1e-12  # v: 2 segments became 4; w: 3 became 6
    np.testing.assert_allclose(scene.evaluate(points).positions, before, atol=1e-12)

    coarser = scene.replace_lattice(lattice.resized((3, 3, 3), (2, 2, 2)), keep_shape=True)
    moved = np.linalg.norm(scene.evaluate(points).positions - before, axis=1).max()
    assert 0.01 < moved <= 1.5 * coarser.drag_residual < 1
    rest = scene.replace_lattice(lattice.resized((2, 2, 2), (1, 1, 1)))
    np.testing.assert_allclose(scene.evaluate(points).positions, points, atol=1e-12)

    for _ in range(3):
        scene.undo()
    np.testing.assert_array_equal(scene.lattice().control_points, lattice.control_points)
    assert scene.lattice().structure_id == rest.structure_id + 3


def test_a_gesture_is_one_step_and_does_not_drift(scene):
    rest = scene.lattice()

    with scene.gesture() as drag:
        for share in np.linspace(0.1, 1, 10):
            drag.move(rest.indices[-1], (share, 0, 0))

    moved = scene.lattice().control_points - rest.control_points
    np.testing.assert_allclose(moved[-1], np.broadcast_to([1, 0, 0], (3, 4, 3)), atol=1e-12)
    scene.undo()
    np.testing.assert_array_equal(scene.lattice().control_points, rest.control_points)
    with pytest.raises(latticed.LatticedError) as caught:
        scene.undo()
    assert caught.value.reason == "NOTHING_TO_UNDO"


def test_a_gesture_left_by_an_exception_is_cancelled(scene):
    rest = scene.lattice()

    with pytest.raises(KeyError), scene.gesture() as drag:
        drag.move(rest.indices[-1], (1, 0, 0))
        raise KeyError

    np.testing.assert_array_equal(scene.lattice().control_points, rest.control_points)


@pytest.mark.parametrize(
    "edit, text",
    [
        (lambda scene: scene.set_points([0, 1], [[0, 0, 0]]), "2 control points need as many positions"),
        (lambda scene: scene.move([0.5], (1, 0, 0)), "integers or by a mask"),
        (lambda scene: scene.move([0], (1, 0)), r"x, y and z are needed, not the shape \(2,\)"),
        (lambda scene: scene.transform([0], np.eye(3)), r"shape \(4, 4\)"),
        (lambda scene: scene.insert_knot("x", 1), "axis is one of u, v, w"),
        (lambda scene: scene.reset("zero"), "to is one of identity, initial"),
        (lambda scene: scene.undo("theirs"), "whose is one of mine, scene"),
    ],
)
def test_an_edit_that_makes_no_sense_is_a_value_error(scene, edit, text):
    with pytest.raises(ValueError, match=text):
        edit(scene)


@pytest.mark.parametrize(
    "edit, reason, field",
    [
        (lambda s: s.move([9999], (1, 0, 0)), "OUT_OF_RANGE", "edits[0].move_control_points.indices[0]"),
        (lambda s: s.apply([edits.move([0], (1, 0, 0))], expected_revision=7), "REVISION_CHANGED", ""),
    ],
)
def test_a_refused_edit_says_why_and_changes_nothing(scene, edit, reason, field):
    with pytest.raises(latticed.LatticedError) as caught:
        edit(scene)

    assert caught.value.reason == reason
    assert caught.value.field.startswith(field)
    assert caught.value.request_id and caught.value.request_id in str(caught.value)
    assert scene.refresh().revision == 0
    assert scene.move([0], (1, 0, 0)).revision == 1


def test_edits_for_another_structure_are_refused_until_the_lattice_is_fetched(client, scene):
    other = client.scene(scene.id)
    scene.insert_knot("u", 0.5)

    with pytest.raises(latticed.LatticedError) as caught:
        other.move([0], (1, 0, 0))
    other.lattice()

    assert caught.value.reason == "STRUCTURE_CHANGED"
    assert other.move([0], (1, 0, 0)).revision == 2


def test_edits_of_many_threads_all_count(scene):
    threads = [threading.Thread(target=scene.move, args=([0], (1, 0, 0))) for _ in range(8)]

    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()

    assert scene.lattice().revision == 8
