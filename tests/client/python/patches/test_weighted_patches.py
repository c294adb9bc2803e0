# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Views of patches of scenes with vertex weights, of a real server: what PatchEvaluator makes of them, against
EvaluatePoints, against points that the server evaluates, and against x + w (F(x) - x)."""
import latticed
import numpy as np
import pytest

from shared_points import shared_points
from test_patch_stream import (
    EVERY_DEGREE,
    LEVEL,
    PATCHES,
    UNIFORM,
    Watched,
    farthest_chord,
    half_unit,
    moved_scene,
    some_points,
)


@pytest.fixture
def weights(random):
    return random.uniform(size=134)  # of the blob's vertices


@EVERY_DEGREE
def test_points_are_those_of_evaluate_points(client, blob, random, degree, weights):
    with moved_scene(client, blob, random, degree, weights=weights) as scene:
        watched = Watched(scene)
        surface = watched.evaluator().surface(watched.update.edge_bytes, 1e-3)
        chosen, patch, at = some_points(surface, random)
        exact = watched.exact(patch, at)

    assert watched.plan.weights.shape == (len(watched.plan.places),)
    off = np.abs(surface.points[chosen] - exact.positions).max()
    print(f"{off / half_unit(surface):.2f} of what is allowed without weights")
    assert off <= 2 * half_unit(surface)  # weights have 16 bits, too
    shared, across, different = shared_points(watched.plan, surface)
    assert shared > 1500 and across > 200 and different == 0


@EVERY_DEGREE
@pytest.mark.parametrize("normals", ["facet", "smooth"])
def test_points_and_normals_are_those_of_the_uniform_view(client, blob, random, degree, normals, weights):
    with moved_scene(client, blob, random, degree, weights=weights) as scene:
        watched = Watched(scene, normals)
        surface = watched.at_levels(LEVEL)
        update = scene.get_update(latticed.View(normals=normals, **UNIFORM))

    np.testing.assert_array_equal(surface.triangles, update.triangles)
    assert np.abs(surface.points - update.points.reshape(-1, 3)).max() <= 2 * half_unit(surface)
    off = np.linalg.norm(surface.normals - update.normals.reshape(-1, 3), axis=1)
    print(f"{np.median(off):.2g} rad, at most {off.max():.2g}")
    assert np.median(off) < 5e-5 and off.max() < 1e-3


@EVERY_DEGREE
def test_triangles_are_within_the_tolerance(client, blob, random, degree, weights):
    with moved_scene(client, blob, random, degree, weights=weights) as scene:
        watched = Watched(scene)
        for tolerance in (3e-2, 1e-3):
            surface, far = farthest_chord(watched, random, tolerance)
            assert tolerance / 20 < far <= tolerance + 2 * half_unit(surface)


def test_a_vertex_of_weight_0_rests_and_one_of_weight_1_follows(client, blob, random):
    with moved_scene(client, blob, random) as scene, scene.deform(PATCHES) as stream:
        full = Watched(scene).at_levels(LEVEL).points
        edit = stream.set_weights(np.zeros(134))
        update = stream.wait(edit, timeout=60)
        plan = scene.patch_plan(update.topology.id)
        evaluator = latticed.PatchEvaluator(plan, update.lattice, np.float64)
        resting = evaluator.at_levels(np.full(len(plan.edge_vertices), LEVEL)).points
        at_rest = latticed.Lattice(
            update.lattice.rest(),
            update.lattice.degree,
            update.lattice.knots,
            update.lattice.origin,
            update.lattice.edges,
        )
        rest = latticed.PatchEvaluator(plan, at_rest, np.float64)
        expected = rest.at_levels(np.full(len(plan.edge_vertices), LEVEL)).points
        np.testing.assert_allclose(resting, expected, atol=1e-14)
        stream.wait(stream.set_weights(np.ones(134)), timeout=60)
        ones = Watched(scene)
        assert (ones.plan.weights == 65535).all()
        np.testing.assert_allclose(ones.at_levels(LEVEL).points, full, atol=1e-6)
