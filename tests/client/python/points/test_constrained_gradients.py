# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Gradients of latticed.scipy.Shape in lattices with constraints, against differences of what the server makes of x."""
import importlib.util

import numpy as np
import pytest
from latticed.scipy import Shape

import latticed

STEP = 1e-4

KINDS = {
    "none": latticed.Constraints(),
    "held": latticed.Constraints(held=(0, 7, 31)),
    "layers at a begin": latticed.Constraints(held_layers={"w-": 2}),
    "layers at both ends": latticed.Constraints(held_layers={"u+": 1, "v-": 1, "w+": 3}),
    "mirror u": latticed.Constraints(mirror="u"),
    "mirror v, odd": latticed.Constraints(mirror="v"),
    "mirror w, odd": latticed.Constraints(mirror="w"),
    "mirror and held": latticed.Constraints(held=(5,), held_layers={"u-": 1}, mirror="u"),
    "mirror and layers": latticed.Constraints(held_layers={"w+": 1}, mirror="v"),
}


@pytest.fixture(params=[0, 1], ids=["one lattice", "the second of two"])
def lattice(request, scene, random):
    """The number of a lattice of 4 x 3 x 5 control points in `scene`, which lie where no mirror has put them."""
    if request.param:
        first = scene.lattice()
        size, degree = (3, 4, 3), (2, 1, 2)
        scene.replace_lattice(first.resized(size, degree))
        scene.add_lattice(first)
        other = scene.lattice(0)
        scene.replace(other.control_points + random.uniform(-0.1, 0.1, other.control_points.shape))
    read = scene.lattice(request.param)
    scene.edits_of(request.param).replace(
        read.control_points + random.uniform(-0.05, 0.05, read.control_points.shape)
    )
    return request.param


@pytest.fixture
def points(scene, random):
    with scene.points(random.uniform(0, 1, (50, 3)) * [2, 1, 3]) as made:
        yield made


def quadratic(random, count):
    """A function of points whose central differences are exact, and which no symmetry leaves as it is."""
    target, linear = random.normal(size=(count, 3)), random.normal(size=(count, 3))
    return lambda x: (0.5 * ((x - target) ** 2).sum() + (linear * x).sum(), x - target + linear)


def differs(function, x, direction, step=STEP):
    return (function(x + step * direction) - function(x - step * direction)) / (2 * step)


def check(function, gradient, x, random, tolerance=1e-7):
    for _ in range(3):
        direction = random.normal(size=x.shape)
        expected, got = differs(function, x, direction), gradient @ direction
        assert abs(expected - got) < tolerance * max(1, abs(expected)), (expected, got)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("free", ["all", "some", "a half"])
def test_the_gradient_is_that_of_what_the_constraints_allow(scene, lattice, points, random, kind, free):
    constraints = KINDS[kind]
    scene.edits_of(lattice).set_constraints(constraints)
    before = scene.lattice(lattice)
    indices = before.indices
    masks = {"all": np.ones(indices.shape, bool), "some": random.uniform(size=indices.shape) < 0.4}
    half = indices % 4 < 2  # of u, whose images are not free
    shape = Shape(scene, points, masks.get(free, half), lattice)
    objective = shape.objective(quadratic(random, len(points)))
    x = shape.start + random.uniform(-0.1, 0.1, shape.start.shape)

    gradient = objective(x)[1]

    check(lambda at: objective(at)[0], gradient, x, random)
    stays = (scene.lattice(lattice).control_points == before.control_points).all(axis=-1)
    assert stays.reshape(-1)[list(constraints.held)].all()
    moving = masks.get(free, half)
    by_points = np.zeros((*indices.shape, 3))
    by_points[moving] = gradient.reshape(-1, 3)
    assert not by_points[stays].any()
    assert by_points[moving & ~stays].any(axis=-1).all()


def test_an_image_that_is_not_free_follows(scene, lattice, points, random):
    scene.edits_of(lattice).set_constraints(latticed.Constraints(mirror="u"))
    read = scene.lattice(lattice)
    half = read.indices[:, :, :2].reshape(-1)
    shape = Shape(scene, points, half, lattice)
    x = shape.start + random.uniform(-0.1, 0.1, shape.start.shape)

    shape.move(x)

    placed = scene.lattice(lattice).control_points
    np.testing.assert_array_equal(placed[:, :, :2].reshape(-1), x)
    centre = read.origin[0] + read.edges[0, 0] / 2  # the box lies along the axes
    expected = placed[:, :, 1::-1] * [-1, 1, 1] + [2 * centre, 0, 0]
    np.testing.assert_allclose(placed[:, :, 2:], expected, atol=1e-13)


def test_a_strength_scales_the_gradient(scene, lattice, points, random):
    scene.edits_of(lattice).set_strength(0.3)
    scene.edits_of(lattice).set_constraints(latticed.Constraints(held_layers={"w-": 1}, mirror="u"))
    shape = Shape(scene, points, lattice=lattice)
    objective = shape.objective(quadratic(random, len(points)))
    check(lambda at: objective(at)[0], objective(shape.start)[1], shape.start, random)


def test_a_kept_volume_is_refused_and_has_a_replacement(scene, lattice, points, random):
    of = scene.edits_of(lattice)
    of.set_constraints(latticed.Constraints(keep_volume=True))
    with pytest.raises(ValueError, match="Shape.kept_volume"):
        Shape(scene, points, lattice=lattice)

    of.set_constraints(latticed.Constraints(held=(3,), mirror="u"))
    shape = Shape(scene, points, lattice=lattice)
    volume = scene.measure("volume").volume
    kept = shape.kept_volume()
    assert kept["type"] == "eq" and shape.kept_volume(2 * volume)["fun"](shape.start) < -0.4
    x = shape.start + random.uniform(-0.1, 0.1, shape.start.shape)
    gradient = kept["jac"](x)
    assert kept["fun"](x) == pytest.approx(scene.measure("volume").volume / volume - 1, abs=1e-12)
    check(kept["fun"], gradient, x, random, 1e-6)


@pytest.mark.skipif(importlib.util.find_spec("scipy") is None, reason="needs scipy")
def test_an_optimiser_keeps_the_volume_of_a_mirrored_lattice(scene, points):
    from scipy.optimize import minimize

    scene.set_constraints(latticed.Constraints(held_layers={"w-": 1}, mirror="u"))
    shape = Shape(scene, points, scene.lattice().indices[1:])
    target = (points.deform().positions - 1) * [1.2, 1, 1] + 1
    objective = shape.objective(lambda x: (((x - target) ** 2).sum(), 2 * (x - target)))
    first, kept = objective(shape.start)[0], shape.kept_volume()
    options = {"maxiter": 40}
    best = minimize(objective, shape.start, jac=True, method="SLSQP", constraints=[kept], options=options)
    assert best.fun < 0.1 * first
    shape.move(best.x)
    assert scene.measure("volume").volume == pytest.approx(6, rel=1e-4)  # without kept_volume 7.2
