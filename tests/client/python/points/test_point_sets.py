# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
import grpc
import latticed
import numpy as np
import pytest


@pytest.fixture
def bent(scene, random):
    """The scene with control points moved at random."""
    lattice = scene.lattice()
    scene.replace(lattice.control_points + random.uniform(-0.1, 0.1, lattice.control_points.shape))
    return scene


def some_points(scene, random, count=9000):
    """Points of the frame, and a few outside."""
    lattice = scene.lattice()
    return lattice.origin + random.uniform(0, 1.1, (count, 3)) @ lattice.edges


def test_points_are_deformed_as_by_evaluate(bent, random):
    world = some_points(bent, random)
    with bent.points(world) as points:
        values = points.deform()

        assert len(points) == 9000 and not points.has_normals
        assert repr(points) == f"<PointSet {points.id}: 9000 points of scene {bent.id}>"
        assert (values.revision, values.structure_id, values.normals) == (1, 1, None)
        np.testing.assert_allclose(values.positions, bent.evaluate(world).positions, atol=1e-13, rtol=0)
        assert [p.id for p in bent.point_sets()] == [points.id]
        assert 0 < bent.refresh().bytes["point_sets"] == points.info.bytes
    assert bent.point_sets() == []


def test_points_of_the_surface_and_of_a_view_have_normals(bent):
    faces, corners, weights = [0, 1], [[0, 1, 2], [4, 5, 6]], [[0.2, 0.3, 0.5], [1, 0, 0]]
    expected = bent.evaluate_surface(faces, corners, weights)
    values = bent.surface_points(faces, corners, weights).deform(normals=True)
    np.testing.assert_allclose(values.positions, expected.positions, atol=1e-13, rtol=0)
    np.testing.assert_allclose(values.normals, expected.normals, atol=1e-12, rtol=0)

    view = latticed.View(segments=2, normals="facet", encoding="raw")
    tessellation = bent.view_points(view).deform(normals=True)
    update = bent.get_update(view)
    assert len(tessellation.positions) == update.points.size // 3
    both = zip(tessellation.positions, update.points.reshape(-1, 3))
    assert max(np.linalg.norm(a - b) for a, b in both) < 1e-5


def test_forward_mode_is_the_difference_quotient_and_reverse_mode_its_adjoint(bent, random):
    world = some_points(bent, random, 500)
    normals = random.normal(size=world.shape)
    points = bent.points(world, normals)
    control_points = bent.lattice().control_points
    tangents = random.normal(size=(3, *control_points.shape))
    cotangents, by_normals = random.normal(size=(2, 3, *world.shape))

    moved = points.jvp(tangents, normals=True)
    pulled = points.vjp(cotangents, by_normals)

    assert moved.positions.shape == moved.normals.shape == (3, 500, 3)
    assert pulled.gradients.shape == (3, control_points.size // 3, 3)
    forward = (moved.positions * cotangents).sum() + (moved.normals * by_normals).sum()
    reverse = (pulled.gradients * tangents.reshape(3, -1, 3)).sum()
    size = np.linalg.norm(moved.positions) * np.linalg.norm(cotangents)
    assert abs(forward - reverse) <= 1e-12 * size
    np.testing.assert_array_equal(points.vjp(cotangents[1], by_normals[1]).gradients, pulled.gradients[1])
    np.testing.assert_array_equal(points.jvp(tangents[2]).positions, moved.positions[2])
    step = 1e-6
    ends = []
    for sign in (1, -1):
        bent.replace(control_points + sign * step * tangents[0])
        ends.append(points.deform().positions)
    np.testing.assert_allclose((ends[0] - ends[1]) / (2 * step), moved.positions[0], atol=1e-8)


def test_a_tangent_may_name_its_control_points(bent, random):
    points = bent.points(some_points(bent, random, 100))
    lattice = bent.lattice()
    whole = np.zeros((*lattice.size[::-1], 3))
    whole[-1] = (1, 2, 3)
    some = points.jvp(np.tile((1, 2, 3), (lattice.indices[-1].size, 1)), lattice.indices[-1].ravel())
    np.testing.assert_array_equal(some.positions, points.jvp(whole).positions)


def test_more_directions_than_one_call_takes(client, box, random):
    with client.create_scene(box, size=(20, 20, 20), delete_on_exit=True) as scene:
        points = scene.points(some_points(scene, random, 50))
        cotangents = random.normal(size=(9, 50, 3))  # 192,000 bytes of gradients each: four fit in a message
        gradients = points.vjp(cotangents).gradients
        assert gradients.shape == (9, 8000, 3)
        np.testing.assert_array_equal(points.vjp(cotangents[8]).gradients, gradients[8])
        moved = points.jvp(gradients).positions
        np.testing.assert_array_equal(points.jvp(gradients[8]).positions, moved[8])


def test_errors_say_what_is_wrong(bent, random):
    points = bent.points(some_points(bent, random, 10))
    for call in (
        lambda: points.vjp(np.zeros((9, 3))),
        lambda: points.vjp(np.zeros(30)),
        lambda: points.vjp(np.zeros((2, 10, 3)), np.zeros((10, 3))),
        lambda: bent.points(np.zeros((3, 2))),
        lambda: bent.points(np.zeros((3, 3)), np.zeros((2, 3))),
    ):
        with pytest.raises(ValueError):
            call()
    with pytest.raises(latticed.LatticedError) as refused:
        points.deform(revision=7)
    assert refused.value.reason == "REVISION_CHANGED"
    with pytest.raises(latticed.LatticedError) as refused:
        points.deform(normals=True)
    assert refused.value.field == "with_normals"
    with pytest.raises(latticed.LatticedError) as refused:
        bent.points([[0, 0, np.nan]])
    assert refused.value.field == "data.positions[0]"
    points.delete()
    with pytest.raises(latticed.LatticedError) as refused:
        points.deform()
    assert refused.value.code == grpc.StatusCode.NOT_FOUND
    with points:  # it is gone already, which is what the end of the block wants
        pass
