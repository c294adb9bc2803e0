# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Several lattices of one scene: their displacements add, and each has edits of its own."""
import latticed
import numpy as np
import pytest

import definition
from latticed.scipy import Shape
from test_lattice_deform import frame


def around(low, high, degree, outside=latticed.Outside()):
    lattice = frame(degree)
    lattice.origin, lattice.edges = low, np.diag(high - low)
    lattice.control_points = lattice.rest()
    lattice.outside = outside
    return lattice


@pytest.fixture
def two(client, box, random):
    """The box in a lattice around it, and in one around a part of it, which fades out."""
    low, high = definition.BOX_POSITIONS.min(axis=0), definition.BOX_POSITIONS.max(axis=0)
    size = high - low
    lattices = [
        around(low - 0.1 * size, high + 0.1 * size, (2, 2, 2)),
        around(low + 0.2 * size, high - 0.4 * size, (3, 1, 2), latticed.Outside.falloff(0.4)),
    ]
    for lattice in lattices:
        lattice.control_points = lattice.control_points + random.normal(
            scale=0.02, size=lattice.control_points.shape
        )
    with client.create_scene(box, lattices, delete_on_exit=True) as made:
        yield made


def deformed(lattices, points):
    return points + sum(lattice.deform(points) - points for lattice in lattices)


def test_displacements_add(two, random):
    low, high = definition.BOX_POSITIONS.min(axis=0), definition.BOX_POSITIONS.max(axis=0)
    points = random.uniform(low, high, size=(300, 3))
    lattices = [two.lattice(), two.lattice(1)]
    assert lattices[1].outside.mode == "falloff"
    np.testing.assert_allclose(two.evaluate(points).positions, deformed(lattices, points), atol=1e-12)


def test_turned_lattices_add_too(client, box, random):
    low, high = definition.BOX_POSITIONS.min(axis=0), definition.BOX_POSITIONS.max(axis=0)
    size = high - low
    whole = around(low - 0.1 * size, high + 0.1 * size, (2, 2, 2))
    turned = around(low - size, high + size, (1, 2, 3))
    cosine, sine = np.cos(0.3), np.sin(0.3)
    turned.edges = turned.edges @ np.array([[cosine, sine, 0], [-sine, cosine, 0], [0, 0, 1]])
    turned.origin = (low + high) / 2 - turned.edges.sum(axis=0) / 2
    turned.control_points = turned.rest()
    lattices = [whole, turned]
    for lattice in lattices:
        lattice.control_points = lattice.control_points + random.normal(
            scale=0.02, size=lattice.control_points.shape
        )
    points = random.uniform(low, high, size=(300, 3))
    with client.create_scene(box, lattices, delete_on_exit=True) as scene:
        np.testing.assert_allclose(scene.evaluate(points).positions, deformed(lattices, points), atol=1e-12)
        assert scene.measure("volume").volume > 0
        full = scene.measure("volume").volume
        scene.set_weights(np.zeros(len(definition.BOX_POSITIONS)))
        assert scene.measure("volume").volume == pytest.approx(np.prod(high - low), rel=1e-12)
        scene.undo()
        assert scene.measure("volume").volume == pytest.approx(full, rel=1e-14)
        update = scene.get_update(latticed.View(tolerance=1e-3))
        assert 0 < update.certified_error <= 1e-3


def test_each_has_its_own_edits(two):
    first, second = two.lattice(), two.lattice(1)
    index = second.indices[1, 1, 1]
    result = two.edits_of(1).move(index, (0.01, 0, 0))
    np.testing.assert_allclose(result.largest_move, 0.01, atol=1e-12)
    moved = two.lattice(1).control_points - second.control_points
    np.testing.assert_allclose(moved[1, 1, 1], (0.01, 0, 0), atol=1e-12)
    assert np.array_equal(two.lattice().control_points, first.control_points)
    with pytest.raises(latticed.LatticedError) as refused:
        two.undo()  # of the first
    assert refused.value.reason == "NOTHING_TO_UNDO"
    two.edits_of(1).undo()
    assert np.array_equal(two.lattice(1).control_points, second.control_points)


def test_a_stream_follows_both(two):
    with two.deform(latticed.View(segments=2, encoding="raw")) as stream:
        before = stream.lattice
        edit = stream.edits_of(1).move(two.lattice(1).indices[1, 1, 1], (0.05, 0, 0))
        update = stream.wait(edit)
        assert update.revision == 1
        assert stream.lattice.revision == 1
        assert np.array_equal(stream.lattice.control_points, before.control_points)
        stream.wait(stream.move(before.indices[-1], (0, 0, 0.1)))
        assert not np.array_equal(stream.lattice.control_points, before.control_points)


def test_derivatives_are_by_one_of_them(two, random):
    shape = two.lattice(1).control_points.shape
    gradient = two.measure("volume", with_gradient=True, lattice=1).volume_gradient
    assert gradient.shape == (two.lattice(1).control_points.size // 3, 3)

    low, high = definition.BOX_POSITIONS.min(axis=0), definition.BOX_POSITIONS.max(axis=0)
    with two.points(random.uniform(low, high, size=(50, 3))) as points:
        tangents, cotangents = random.normal(size=shape), random.normal(size=(3, 50, 3))
        moved = points.jvp(tangents, lattice=1).positions
        pulled = points.vjp(cotangents, lattice=1).gradients
        assert pulled.shape == (3, tangents.size // 3, 3)
        forward = (moved * cotangents).sum(axis=(1, 2))
        np.testing.assert_allclose((pulled * tangents.reshape(-1, 3)).sum(axis=(1, 2)), forward, atol=1e-12)
        before = points.deform().positions
        two.edits_of(1).replace(two.lattice(1).control_points + tangents)
        np.testing.assert_allclose(points.deform().positions - before, moved, atol=1e-12)
        with pytest.raises(latticed.LatticedError, match="lattice: got 2"):
            points.vjp(cotangents, lattice=2)


def test_one_of_them_is_a_shape_of_scipy(two, random):
    low, high = definition.BOX_POSITIONS.min(axis=0), definition.BOX_POSITIONS.max(axis=0)
    first = two.lattice().control_points
    with two.points(random.uniform(low, high, size=(50, 3))) as points:
        shape = Shape(two, points, two.lattice(1).indices[1], lattice=1)
        value = shape.objective(lambda x: ((x**2).sum(), 2 * x))
        gradient = value(shape.start)[1]
        direction = random.normal(size=shape.start.shape)
        ends = [value(shape.start + step * direction)[0] for step in (1e-5, -1e-5)]
        assert abs((ends[0] - ends[1]) / 2e-5 - gradient @ direction) < 1e-7 * np.abs(gradient).sum()
    assert np.array_equal(two.lattice().control_points, first)


def test_one_is_added(client, box, two):
    lattices = [two.lattice(), two.lattice(1)]
    points = np.full((1, 3), 0.1) + definition.BOX_POSITIONS.min(axis=0)
    with client.create_scene(box, lattices[0], delete_on_exit=True) as scene:
        assert scene.add_lattice(lattices[1]).structure_id == 2
        np.testing.assert_allclose(
            scene.evaluate(points).positions, two.evaluate(points).positions, atol=1e-14
        )
        scene.edits_of(1).undo()
        np.testing.assert_allclose(scene.evaluate(points).positions, lattices[0].deform(points), atol=1e-12)
        assert numbers(scene) == [0]


def numbers(scene):
    return [lattice.index for lattice in scene.refresh().lattices]


def test_one_is_removed_and_given_back(two):
    points = definition.BOX_POSITIONS.min(axis=0) + np.array([[0.1, 0.1, 0.1], [0.3, 0.2, 0.25]])
    first, second, both = two.lattice(), two.lattice(1), two.evaluate(points).positions

    assert two.remove_lattice(0).structure_id == 2

    assert numbers(two) == [1]
    np.testing.assert_allclose(two.evaluate(points).positions, second.deform(points), atol=1e-12)
    with pytest.raises(latticed.LatticedError) as last:
        two.remove_lattice(1)
    assert last.value.reason == "LAST_LATTICE"
    with pytest.raises(latticed.LatticedError) as removed:
        two.move(0, (0, 0, 1))
    assert removed.value.reason == "LATTICE_REMOVED"
    two.edits_of(0).undo()
    assert np.array_equal(two.lattice().control_points, first.control_points)
    assert np.array_equal(two.evaluate(points).positions, both)
    two.remove_lattice(0)
    assert two.add_lattice(second).structure_id == 5
    assert numbers(two) == [0, 1]
    moved = points + 2 * (second.deform(points) - points)
    np.testing.assert_allclose(two.evaluate(points).positions, moved, atol=1e-12)


def test_a_stream_follows_the_first_that_is_left(two):
    second = two.lattice(1)
    with two.deform(latticed.View(segments=2, encoding="raw")) as stream:
        assert stream.lattice.control_points.shape == two.lattice().control_points.shape
        two.remove_lattice(0)
        while stream.latest.revision < 1:
            stream.next_update()
        assert np.array_equal(stream.lattice.control_points, second.control_points)
        stream.wait(stream.edits_of(1).move(second.indices[1, 1, 1], (0.05, 0, 0)))
        moved = stream.lattice.control_points - second.control_points
        np.testing.assert_allclose(moved[1, 1, 1], (0.05, 0, 0), atol=1e-12)


def test_each_keeps_its_strength(client, box, two):
    two.set_strength(0.75)
    two.edits_of(1).set_strength(0.25)
    points = definition.BOX_POSITIONS.min(axis=0) + np.array([[0.1, 0.1, 0.1], [0.3, 0.2, 0.25]])
    lattices = [two.lattice(), two.lattice(1)]
    assert [lattice.strength for lattice in lattices] == [0.75, 0.25]
    wanted = two.evaluate(points).positions
    with client.create_scene(box, lattices, delete_on_exit=True) as scene:
        np.testing.assert_allclose(scene.evaluate(points).positions, wanted, atol=1e-13)
    with client.create_scene(box, lattices[0], delete_on_exit=True) as scene:
        scene.add_lattice(lattices[1])
        np.testing.assert_allclose(scene.evaluate(points).positions, wanted, atol=1e-13)


def test_refusing_folds_is_of_the_scene(two):
    edits = two.edits_of(1)
    two.refuse_folds = True
    assert edits.refuse_folds
    edits.refuse_folds = False
    assert not two.refuse_folds


def test_bad_ones_are_refused(two, client, box):
    with pytest.raises(latticed.LatticedError, match="lattice: got 2"):
        two.edits_of(2).undo()
    with pytest.raises(latticed.LatticedError, match="lattice: got 5"):
        two.lattice(5)
    ending = two.lattice(1)
    ending.outside = latticed.Outside()
    with pytest.raises(latticed.LatticedError, match="ends inside the mesh"):
        client.create_scene(box, [two.lattice(), ending])
    with pytest.raises(latticed.LatticedError, match="ends inside the mesh"):
        two.add_lattice(ending)
