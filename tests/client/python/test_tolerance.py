# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Views with a tolerance: triangles within the certified error of the definition, in every encoding."""
import latticed
import numpy as np
import pytest

import definition

CORNERS = definition.BOX_POSITIONS[definition.BOX_FACES.reshape(-1)]


def bend(scene, random):
    lattice = scene.lattice()
    lattice.control_points += random.normal(scale=0.2, size=lattice.control_points.shape)
    scene.replace(lattice.control_points)
    return lattice


def distance(scene, lattice, update, random):
    """The largest distance of a random point of each triangle from the definition, at the same barycentrics."""
    rest = scene.provenance(update).interpolate(CORNERS, update.patterns)
    weights = random.dirichlet([1, 1, 1], size=len(update.triangles))
    at_rest = np.einsum("ti,tik->tk", weights, rest[update.triangles])
    chords = np.einsum("ti,tik->tk", weights, update.points[update.triangles])
    exact = definition.deform(lattice, np.clip(at_rest, 0, [2, 1, 3]))
    return np.linalg.norm(chords - exact, axis=1).max()


@pytest.mark.parametrize("encoding", ["raw", "quantised"])
def test_triangles_are_within_the_certified_error(scene, random, encoding):
    lattice = bend(scene, random)
    for tolerance in (0.05, 0.005):
        view = latticed.View(tolerance=tolerance, segments=32, encoding=encoding)
        update = scene.get_update(view, min_revision=1)

        assert update.view.tolerance == tolerance
        assert 0 < update.certified_error <= tolerance
        assert update.topology.segments == 0 and update.topology.uniform is None
        assert len(update.patterns) == scene.patches
        assert update.first_points[-1] == len(update.points) == len(update.normals)
        assert len({len(pattern) for pattern in update.patterns}) > 1, "patches differ"
        far = distance(scene, lattice, update, random)
        assert update.certified_error / 1000 < far <= update.certified_error


def test_chunks_have_the_points_of_their_patches(scene, random):
    bend(scene, random)
    update = scene.get_update(latticed.View(tolerance=0.01, encoding="raw"), min_revision=1)

    parts = [update.points_of(chunk) for chunk in range(update.topology.chunks)]

    np.testing.assert_array_equal(np.concatenate(parts), update.points)
    for chunk, part in enumerate(parts):
        patches = update.topology.patches_of(chunk)
        assert len(part) == sum(len(pattern) for pattern in update.patterns[patches])
    edges = np.sort(update.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    assert np.unique(edges, axis=0, return_counts=True)[1].max() == 2
    assert update.triangles.max() == len(update.points) - 1


def test_a_stream_follows_edits(scene, random):
    view = latticed.View(tolerance=0.01, encoding="quantised")
    with scene.watch(view) as stream:
        bend(scene, random)
        update = next(update for update in stream if update.revision == 1)
        stream.set_view(latticed.View(segments=2, encoding="quantised"))
        uniform = next(update for update in stream if update.topology.segments == 2)
    now = scene.get_update(view, min_revision=1)

    np.testing.assert_array_equal(update.points, now.points)
    np.testing.assert_array_equal(update.triangles, now.triangles)
    assert uniform.certified_error == 0 and uniform.points.shape == (scene.patches, 6, 3)


def test_what_the_grid_cannot_meet_is_refused(scene):
    with pytest.raises(latticed.LatticedError, match="16 position bits allow") as refused:
        scene.get_update(latticed.View(tolerance=1e-9, encoding="quantised"))
    assert refused.value.reason == "OUT_OF_RANGE"
    with pytest.raises(ValueError, match="patterns are those of an update"):
        update = scene.get_update(latticed.View(tolerance=0.1, encoding="raw"))
        scene.provenance(update).interpolate(CORNERS)
