# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Views of patches in scenes of several lattices, of a real server: the surface is that of their sum."""
import dataclasses

import latticed
import numpy as np
import pytest

from test_patch_stream import PATCHES, Watched, half_unit, moved_scene, some_points


@pytest.fixture
def three(client, blob, random):
    """The blob in a lattice around it, and in two around parts of it, which fade out. All are moved."""
    lattices = []
    for low, high, degree, width in [
        (-1.4, 1.4, (2, 3, 2), 0),
        (-1.3, 0.2, (3, 2, 2), 0.4),
        (0, 0.9, (2, 2, 3), 0.5),
    ]:
        size = tuple(n + 2 for n in degree)
        knots = tuple(np.array([0.0] * (n + 1) + [1] + [2] * (n + 1)) for n in degree)
        outside = latticed.Outside.falloff(width) if width else latticed.Outside()
        lattice = latticed.Lattice(
            np.zeros((*reversed(size), 3)),
            degree,
            knots,
            np.full(3, low),
            np.eye(3) * (high - low),
            outside=outside,
        )
        lattice.control_points = lattice.rest() + random.normal(scale=0.05, size=lattice.control_points.shape)
        lattices.append(lattice)
    with client.create_scene(blob, lattices, delete_on_exit=True) as scene:
        yield scene


def expect_sum(watched, count):
    """Points are x + sum_k (F_k(x) - x), with F_k by the client's own formula in double."""
    levels = watched.plan.levels(watched.update.edge_bytes, 1e-3)
    lattice = watched.update.lattice
    at_rest = dataclasses.replace(lattice, control_points=lattice.rest())
    rest, surface = (
        latticed.PatchEvaluator(watched.plan, each, np.float64).at_levels(levels).points
        for each in (at_rest, lattice)
    )
    lattices = [watched.scene.lattice(k) for k in range(count)]
    moved = rest + sum(lattice.deform(rest) - rest for lattice in lattices)
    off = np.abs(surface - moved).max()
    print(f"{len(rest)} points, off by {off:.2g}")
    assert off < 1e-12
    assert np.linalg.norm(moved - rest, axis=1).max() > 0.05


def test_patches_of_several_lattices_are_of_their_sum(three):
    expect_sum(Watched(three), 3)
    for lattice in range(3):
        three.edits_of(lattice).move(three.lattice(lattice).indices[1, 1, 1], (0.1, -0.1, 0.05))
        expect_sum(Watched(three), 3)
    three.edits_of(1).undo()
    expect_sum(Watched(three), 3)


def test_weights_go_with_the_sum(client, blob, random, three):
    lattices, weights = [three.lattice(k) for k in range(3)], random.uniform(size=134)
    with client.create_scene(blob, lattices, weights=weights, delete_on_exit=True) as scene:
        watched = Watched(scene)
        surface = watched.evaluator().surface(watched.update.edge_bytes, 1e-3)
        chosen, patch, at = some_points(surface, random)
        exact = watched.exact(patch, at)
    assert np.abs(surface.points[chosen] - exact.positions).max() <= 2 * half_unit(surface)


def test_a_stream_follows_the_sum(three):
    with three.deform(PATCHES) as stream:
        plan = three.patch_plan(stream.latest.topology.id)
        for step in range(1, 7):
            lattice = step % 3
            update = stream.wait(
                stream.edits_of(lattice).move(three.lattice(lattice).indices[1, 1, 1], (0.05, 0, 0.02)),
                timeout=60,
            )
            assert update.lattice.revision == update.revision == step
        whole = three.get_update(PATCHES, min_revision=6)
        np.testing.assert_array_equal(update.lattice.control_points, whole.lattice.control_points)
        ours = latticed.PatchEvaluator(plan, update.lattice).surface(update.edge_bytes, 1e-3)
        theirs = latticed.PatchEvaluator(plan, whole.lattice).surface(whole.edge_bytes, 1e-3)
        np.testing.assert_array_equal(ours.relative_points, theirs.relative_points)


def test_an_added_lattice_has_another_plan(client, blob, random, three):
    with moved_scene(client, blob, random) as scene, scene.deform(PATCHES) as stream:
        before = stream.latest
        scene.add_lattice(three.lattice(1))
        update = next(update for update in stream if update.revision == 2)
        assert update.topology.id != before.topology.id
        assert update.lattice.size != scene.lattice().size
        watched = Watched(scene)
        np.testing.assert_array_equal(update.lattice.control_points, watched.update.lattice.control_points)
        expect_sum(watched, 2)
