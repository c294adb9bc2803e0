# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Scenes with vertex weights: from an array, from the mesh's file, and what is refused."""
import latticed
import numpy as np
import pytest

import definition

WEIGHTS = np.array([0, 0.25, 1, 0.5, 0, 1, 0.75, 1], np.float32)  # of the box's vertices
RAW = latticed.View(segments=4, normals="facet", encoding="raw")


def expected(lattice, weights):
    """Where the box's vertices go."""
    rest = definition.BOX_POSITIONS
    return rest + weights[:, None].astype(float) * (definition.deform(lattice, rest) - rest)


def assert_shows_vertices(update, wanted):
    points = update.points.reshape(-1, 3)
    distance = np.linalg.norm(points[:, None] - wanted, axis=-1).min(axis=0)
    assert distance.max() < 1e-5


@pytest.mark.parametrize("as_list", [False, True])
def test_an_array_weighs_the_vertices(client, as_list):
    mesh = client.upload_arrays(definition.BOX_POSITIONS, definition.BOX_FACES, progress=False)
    weights = WEIGHTS.tolist() if as_list else WEIGHTS
    with client.create_scene(mesh, weights=weights, delete_on_exit=True) as scene:
        with scene.deform(RAW) as stream:
            edit = stream.move(stream.lattice.indices[-1], (0.5, 0.25, 1))
            update = stream.wait(edit)
            assert_shows_vertices(update, expected(stream.lattice, WEIGHTS))


def test_the_meshs_file_weighs_the_vertices(client, tmp_path):
    path = tmp_path / "box.ply"
    rows = [f"{x} {y} {z} {w}" for (x, y, z), w in zip(definition.BOX_POSITIONS, WEIGHTS)]
    faces = ["4 " + " ".join(map(str, face)) for face in definition.BOX_FACES]
    properties = "".join(f"property float {name}\n" for name in ("x", "y", "z", "weight"))
    path.write_text(
        f"ply\nformat ascii 1.0\nelement vertex 8\n{properties}"
        "element face 6\nproperty list uchar int vertex_indices\nend_header\n" + "\n".join(rows + faces)
    )
    mesh = client.upload(path, progress=False)
    with client.create_scene(mesh, weights="mesh", delete_on_exit=True) as scene:
        with scene.deform(RAW) as stream:
            edit = stream.move(stream.lattice.indices[-1], (0.5, 0.25, 1))
            update = stream.wait(edit)
            assert_shows_vertices(update, expected(stream.lattice, WEIGHTS))


def test_uploaded_arrays_weigh_the_vertices(client):
    mesh = client.upload_arrays(
        definition.BOX_POSITIONS, definition.BOX_FACES, weights=WEIGHTS, progress=False
    )
    with client.create_scene(mesh, weights="mesh", delete_on_exit=True) as scene:
        with scene.deform(RAW) as stream:
            update = stream.wait(stream.move(stream.lattice.indices[-1], (0.5, 0.25, 1)))
            assert_shows_vertices(update, expected(stream.lattice, WEIGHTS))


def test_bad_weights_are_refused(client):
    mesh = client.upload_arrays(definition.BOX_POSITIONS, definition.BOX_FACES, progress=False)
    with pytest.raises(ValueError, match='weights is an array or "mesh"'):
        client.create_scene(mesh, weights="group")
    with pytest.raises(ValueError, match="too many for a request"):
        client.create_scene(mesh, weights=np.ones(250_001))
    with pytest.raises(ValueError, match=r"weights have the shape \(8,\)"):
        client.upload_arrays(definition.BOX_POSITIONS, definition.BOX_FACES, weights=WEIGHTS[:7])
    for weights in (WEIGHTS[:7], 2 * WEIGHTS, np.full(8, np.nan)):
        with pytest.raises(latticed.LatticedError) as error:
            client.create_scene(mesh, weights=weights)
        assert error.value.reason == "INVALID_FIELD"
        assert "weights" in str(error.value)


def test_a_tolerance_is_met(client):
    mesh = client.upload_arrays(definition.BOX_POSITIONS, definition.BOX_FACES, progress=False)
    with client.create_scene(mesh, weights=WEIGHTS, delete_on_exit=True) as scene:
        with scene.deform(RAW) as stream:
            stream.wait(stream.move(stream.lattice.indices[-1], (0.5, 0.25, 1)))
        update = scene.get_update(latticed.View(tolerance=0.01, segments=32))
        assert 0 < update.certified_error <= 0.01


def test_weights_are_set_later_in_part_and_ended(client):
    mesh = client.upload_arrays(definition.BOX_POSITIONS, definition.BOX_FACES, progress=False)
    with client.create_scene(mesh, delete_on_exit=True) as scene:
        scene.move(scene.lattice().indices[-1], (0.5, 0.25, 1))
        scene.set_weights(WEIGHTS)
        lattice = scene.lattice()
        assert scene.refresh().weighted and lattice.structure_id == 2
        assert_shows_vertices(scene.get_update(RAW), expected(lattice, WEIGHTS))
        some = WEIGHTS.copy()
        some[[1, 6]] = 0.125
        scene.set_weights(0.125, [1, 6])
        assert_shows_vertices(scene.get_update(RAW), expected(lattice, some))
        scene.lattice()  # of the new structure
        scene.set_weights(None)
        assert not scene.refresh().weighted
        scene.lattice()
        scene.undo()
        assert_shows_vertices(scene.get_update(RAW), expected(lattice, some))


def test_bad_weights_are_not_set(client):
    mesh = client.upload_arrays(definition.BOX_POSITIONS, definition.BOX_FACES, progress=False)
    with client.create_scene(mesh, delete_on_exit=True) as scene:
        for weights, vertices in (([0.5], None), (2.0, [1]), (0.5, [8])):
            with pytest.raises(latticed.LatticedError, match="edits.0..set_weights"):
                scene.set_weights(weights, vertices)
        assert not scene.refresh().weighted
