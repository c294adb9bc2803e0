# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Lattice.deform, which moves vertices only, against the definition and against the exact surface."""
import latticed
import numpy as np
import pytest
from latticed import bspline

import definition

EXACT = 1e-12  # a few roundings of doubles of the size of these lattices
SINGLE = 8 * np.finfo(np.float32).eps  # the server computes in float; coordinates are below 8


def frame(degree, size=(5, 4, 4)):
    """An identity lattice in a skew frame, with knots at unequal distances."""
    knots = []
    for count, p in zip(size, degree):
        inner = np.array([0.5, 2.0, 3.5, 5.0])[: count - p - 1]
        knots.append(np.concatenate([np.full(p + 1, -1.0), inner, np.full(p + 1, 6.0)]))
    lattice = latticed.Lattice(
        control_points=np.zeros((*size[::-1], 3)),
        degree=degree,
        knots=tuple(knots),
        origin=np.array([-0.5, -0.25, -1.0]),
        edges=np.array([[3.0, 0.1, 0.0], [0.2, 2.0, 0.3], [0.0, 0.1, 5.0]]),
    )
    lattice.control_points = lattice.rest()
    return lattice


def bent(lattice, random):
    lattice.control_points = lattice.rest() + random.normal(scale=0.2, size=lattice.control_points.shape)
    return lattice


DEGREES = [(1, 1, 1), (2, 2, 2), (3, 3, 3), (3, 1, 2)]


@pytest.mark.parametrize("degree", DEGREES)
def test_the_identity_lattice_leaves_points(degree, random):
    lattice = frame(degree)
    points = lattice.origin + random.uniform(-0.2, 1.2, size=(500, 3)) @ lattice.edges

    np.testing.assert_allclose(lattice.deform(points), points, atol=EXACT)


@pytest.mark.parametrize("degree", DEGREES)
def test_points_in_the_frame_go_where_the_definition_says(degree, random):
    lattice = bent(frame(degree), random)
    shares = np.concatenate([random.uniform(size=(200, 3)), np.indices((2, 2, 2)).reshape(3, -1).T])
    points = lattice.origin + shares @ lattice.edges

    moved = lattice.deform(points)

    np.testing.assert_allclose(moved, definition.deform(lattice, points), atol=EXACT)
    corners = lattice.control_points[::3, ::3, ::4].transpose(2, 1, 0, 3).reshape(-1, 3)
    np.testing.assert_allclose(moved[-8:], corners, atol=EXACT)  # clamped knots: corners of the domain


def test_points_outside_the_frame_stay_bit_by_bit(random):
    lattice = bent(frame((2, 2, 2)), random)
    shares = random.uniform(size=(300, 3))
    shares[np.arange(300), random.integers(3, size=300)] = random.choice([-1e-9, 1 + 1e-9, -7, 8], size=300)
    points = lattice.origin + shares @ lattice.edges

    np.testing.assert_array_equal(lattice.deform(points), points)


def test_points_that_rounding_put_beside_a_face_are_on_it(random):
    lattice = bent(frame((2, 2, 2)), random)
    shares = np.array([[0.3, 0.4, 0.0], [0.3, 0.4, 1.0]])
    beside = shares + np.array([[0, 0, -1e-13], [0, 0, 1e-13]])

    on_faces = lattice.deform(lattice.origin + shares @ lattice.edges)
    moved = lattice.deform(lattice.origin + beside @ lattice.edges)

    np.testing.assert_allclose(moved, on_faces, atol=EXACT)


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_a_knot_belongs_to_the_interval_below_and_all_values_sum_to_one(degree):
    knots = np.concatenate([np.zeros(degree + 1), [1.0], np.full(degree, 2.0), np.full(degree + 1, 3.0)])
    parameters = np.array([0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0])

    first, values = bspline.basis(knots, degree, parameters)

    np.testing.assert_array_equal(first, [0, 0, 0, 1, 1, degree + 1, degree + 1])
    np.testing.assert_allclose(values.sum(axis=1), 1, atol=1e-15)
    for all_values, index, some in zip(definition.basis(knots, degree, parameters), first, values):
        np.testing.assert_allclose(some, all_values[index : index + degree + 1], atol=1e-15)


def test_no_point_and_points_of_other_shapes(random):
    lattice = frame((2, 2, 2))

    assert lattice.deform(np.zeros((0, 3))).shape == (0, 3)
    for shape in [(3,), (4, 2), (2, 2, 3)]:
        with pytest.raises(ValueError, match=r"shape \(n, 3\)"):
            lattice.deform(np.zeros(shape))


@pytest.mark.parametrize("degree", DEGREES)
def test_the_exact_surface_passes_through_the_moved_vertices(client, box, degree, random):
    lattice = frame(degree)
    lattice.edges[2, 2] = 2.5  # the box is 3 high: its upper half is outside the frame
    bent(lattice, random)
    view = latticed.View(segments=1, encoding="raw", normals="none")

    with client.create_scene(box, lattice, view=view, delete_on_exit=True) as scene:
        surface = scene.get_update().points.reshape(-1, 3)
        evaluated = scene.evaluate(definition.BOX_POSITIONS).positions

    moved = lattice.deform(definition.BOX_POSITIONS)
    np.testing.assert_allclose(moved, evaluated, atol=EXACT)
    assert (moved != definition.BOX_POSITIONS).any(axis=1).sum() == 4  # the lower vertices
    distances = np.linalg.norm(surface[:, None] - moved, axis=2).min(axis=0)
    assert distances.max() < SINGLE
