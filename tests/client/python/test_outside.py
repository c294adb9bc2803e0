# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Lattices that go on outside their frame: against the definition inside, and against the server outside."""
import latticed
import numpy as np
import pytest

import definition
from test_lattice_deform import EXACT, bent, frame

DEGREES = [(1, 2, 3), (2, 2, 2), (3, 1, 2)]
OUTSIDES = [
    latticed.Outside.falloff(0.3),
    latticed.Outside.falloff((0.0, 0.5, 0.2, 0.0, 0.1, 1.0), smooth=False),
    latticed.Outside.linear(1.5),
]


def with_outside(lattice, outside):
    lattice.outside = outside
    return lattice


@pytest.mark.parametrize("degree", DEGREES)
@pytest.mark.parametrize("outside", OUTSIDES)
def test_the_inside_stays_as_it_is(degree, outside, random):
    lattice = bent(frame(degree), random)
    points = lattice.origin + random.uniform(0, 1, size=(200, 3)) @ lattice.edges
    expected = lattice.deform(points)

    np.testing.assert_allclose(with_outside(lattice, outside).deform(points), expected, atol=EXACT)


@pytest.mark.parametrize("degree", DEGREES)
def test_a_falloff_has_no_gap_and_ends(degree, random):
    lattice = with_outside(bent(frame(degree), random), latticed.Outside.falloff(0.3))
    places = random.uniform(0, 1, size=(100, 3))
    places[:, 1] = 1
    inside, outside = (lattice.origin + (places + [0, d, 0]) @ lattice.edges for d in (-1e-9, 1e-9))
    np.testing.assert_allclose(lattice.deform(inside), lattice.deform(outside), atol=1e-7)
    ended = lattice.origin + (places + [0, 0.3, 0]) @ lattice.edges
    np.testing.assert_allclose(lattice.deform(ended), ended, atol=EXACT)


@pytest.mark.parametrize("degree", DEGREES)
def test_an_affine_map_goes_on_linearly(degree, random):
    lattice = with_outside(frame(degree), latticed.Outside.linear(1.5))
    shear = np.array([[1, 0.2, 0], [0, 1, -0.3], [0.1, 0, 1.5]])
    lattice.control_points = lattice.control_points @ shear + [1, 2, 3]
    points = lattice.origin + random.uniform(-1.4, 2.4, size=(100, 3)) @ lattice.edges
    np.testing.assert_allclose(lattice.deform(points), points @ shear + [1, 2, 3], atol=1e-11)


def test_bad_ones_are_refused():
    with pytest.raises(ValueError, match="one width or six"):
        latticed.Outside.falloff((0.1, 0.2))
    with pytest.raises(ValueError, match="a mode is one of"):
        latticed.Outside("round").to_proto()
    with pytest.raises(ValueError, match="needs widths"):
        with_outside(frame((2, 2, 2)), latticed.Outside.linear()).deform(np.zeros((1, 3)))


@pytest.fixture(params=OUTSIDES[:2] + [latticed.Outside.linear()], ids=["c1", "c0", "linear"])
def half_scene(request, client, box, random):
    """The box in a lattice around a part of it."""
    rest = frame((2, 2, 2))
    low, high = definition.BOX_POSITIONS.min(axis=0), definition.BOX_POSITIONS.max(axis=0)
    rest.origin, rest.edges = low - 0.1, np.diag(0.6 * (high - low))
    rest.control_points = rest.rest()
    rest.outside = request.param
    with client.create_scene(box, rest, delete_on_exit=True) as made:
        scene_lattice = made.lattice()
        moves = random.normal(scale=0.03, size=scene_lattice.control_points.shape)
        made.replace(scene_lattice.control_points + moves)
        yield made


def test_the_server_deforms_as_the_client(half_scene, random):
    lattice = half_scene.lattice()
    assert lattice.outside.mode in ("falloff", "linear") and len(lattice.outside.widths) == 6
    points = lattice.origin + random.uniform(-0.3, 1.6, size=(300, 3)) @ lattice.edges
    np.testing.assert_allclose(lattice.deform(points), half_scene.evaluate(points).positions, atol=1e-12)


def test_patches_go_on_outside(half_scene):
    update = half_scene.get_update(latticed.View(encoding="patches", normals="facet"))
    plan = half_scene.patch_plan(update.topology.id, update.view.normals)
    surface = latticed.PatchEvaluator(plan, update.lattice).at_levels(np.zeros(len(plan.edge_vertices)))
    corners = half_scene.get_update(latticed.View(segments=1, encoding="raw", normals="facet"))
    np.testing.assert_allclose(surface.points, corners.points.reshape(-1, 3), atol=1e-4)


def test_a_replaced_lattice_keeps_it(half_scene):
    before = half_scene.lattice()
    half_scene.replace_lattice(before.resized((6, 6, 6)), keep_shape=True)
    assert half_scene.lattice().outside == before.outside


def test_a_scene_takes_a_part_of_it(half_scene, random):
    whole = half_scene.lattice()
    points = whole.origin + random.uniform(-0.3, 1.6, size=(300, 3)) @ whole.edges
    assert half_scene.set_strength(0.375).largest_move == 0
    lattice = half_scene.lattice()
    assert lattice.strength == 0.375 and lattice.structure_id == whole.structure_id
    wanted = points + 0.375 * (whole.deform(points) - points)
    np.testing.assert_allclose(half_scene.evaluate(points).positions, wanted, atol=1e-12)
    np.testing.assert_allclose(lattice.deform(points), wanted, atol=1e-12)
    np.testing.assert_allclose(lattice.effective().deform(points), wanted, atol=1e-12)
    test_patches_go_on_outside(half_scene)
    half_scene.undo()
    assert half_scene.lattice().strength == 1


def test_bad_strengths_are_refused(half_scene):
    for bad in (-0.1, 1.5, float("nan")):
        with pytest.raises(latticed.LatticedError, match="edits.0..set_strength.strength"):
            half_scene.set_strength(bad)
    half_scene.set_strength(0)
    point = half_scene.pick((0.0, 0.0, 100.0), (0.0, 0.0, -1.0))
    with pytest.raises(latticed.LatticedError) as refused:
        half_scene.drag(point, (0, 0, 0))
    assert refused.value.reason == "NO_STRENGTH"


def test_a_lattice_that_the_server_makes_goes_on(client, box):
    with client.create_scene(box, outside=latticed.Outside.falloff(0.3), delete_on_exit=True) as scene:
        assert scene.lattice().outside.mode == "falloff"
        assert scene.lattice().outside.widths == (0.3,) * 6
    with pytest.raises(latticed.LatticedError, match="widths"):
        client.create_scene(box, outside=latticed.Outside.linear())
    with pytest.raises(ValueError, match="outside are of a lattice that the server makes"):
        client.create_scene(box, scene.lattice, outside=latticed.Outside.linear(1))
