# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
import subprocess

import latticed
import numpy as np
import pytest

import definition
from server_process import LATTICECTL


def test_control_points_are_ordered_w_v_u(scene):
    lattice = scene.lattice()

    assert lattice.size == (4, 3, 5)
    assert lattice.control_points.shape == (5, 3, 4, 3)
    assert (np.diff(lattice.control_points[0, 0, :, 0]) > 0).all()
    assert (np.diff(lattice.control_points[0, :, 0, 1]) > 0).all()
    assert (np.diff(lattice.control_points[:, 0, 0, 2]) > 0).all()
    assert lattice.indices[2, 1, 3] == 3 + 4 * (1 + 3 * 2)
    np.testing.assert_allclose(lattice.rest(), lattice.control_points, atol=1e-12)
    assert repr(lattice) == "<Lattice: 4 x 3 x 5 control points of degree 3 x 1 x 2, revision 0>"


@pytest.mark.parametrize("fit", [{"size": (4, 4)}, {"size": 4}, {"degree": (2, 2, 2, 2)}])
def test_a_fit_of_other_than_three_axes_is_a_value_error(client, box, fit):
    with pytest.raises(ValueError, match="is three numbers, of u, v and w"):
        client.create_scene(box, **fit)


def test_a_scene_keeps_the_lattice_that_it_was_given(client, box, random):
    given = latticed.Lattice(
        control_points=random.normal(size=(3, 2, 4, 3)),
        degree=(3, 1, 2),
        knots=(
            np.array([0.0, 0, 0, 0, 1, 1, 1, 1]),
            np.array([0.0, 0, 1, 1]),
            np.array([0.0, 0, 0, 2, 2, 2]),
        ),
        origin=np.array([-1.0, -1, -1]),
        edges=np.array([[4.0, 0, 0], [0.5, 4, 0], [0, 0, 5]]),
    )

    with client.create_scene(box, given, delete_on_exit=True) as scene:
        got = scene.lattice()

    assert (got.degree, got.structure_id, got.revision) == ((3, 1, 2), 1, 0)
    for name in ("control_points", "origin", "edges"):
        np.testing.assert_array_equal(getattr(got, name), getattr(given, name))
    for mine, theirs in zip(given.knots, got.knots):
        np.testing.assert_array_equal(theirs, mine)


def test_latticectls_file_is_read_and_written(server, tmp_path):
    def latticectl(arguments):
        subprocess.run([LATTICECTL, *arguments.split()], cwd=tmp_path, check=True, capture_output=True)

    latticectl("sample vase -o vase.obj")
    latticectl("lattice vase.obj --size 5,4,6 --degree 2,1,3 -o L.json")

    lattice = latticed.Lattice.load(tmp_path / "L.json")
    lattice.control_points[-1, ..., 0] += 0.5
    lattice.save(tmp_path / "M.json")
    again = latticed.Lattice.load(tmp_path / "M.json")

    assert (lattice.size, lattice.degree) == ((5, 4, 6), (2, 1, 3))
    np.testing.assert_array_equal(again.control_points, lattice.control_points)
    latticectl(f"apply vase.obj --lattice M.json --server {server.address} --segments 1 -o out.ply")


def test_a_file_that_is_no_lattice_is_a_value_error(tmp_path):
    (tmp_path / "L.json").write_text('{"sizes": 4}')

    with pytest.raises(ValueError, match="L.json.*sizes"):
        latticed.Lattice.load(tmp_path / "L.json")


def test_points_go_where_the_definition_says(scene, random):
    lattice = scene.lattice()
    lattice.control_points += random.normal(scale=0.2, size=lattice.control_points.shape)
    scene.replace(lattice.control_points)
    points = lattice.origin + random.uniform(size=(200, 3)) @ lattice.edges

    evaluation = scene.evaluate(points)

    np.testing.assert_allclose(evaluation.positions, definition.deform(lattice, points), atol=1e-12)
    assert evaluation.revision == 1
    step = 1e-6
    for axis in range(3):
        offset = step * np.eye(3)[axis]
        difference = definition.deform(lattice, points[:20] + offset) - definition.deform(
            lattice, points[:20] - offset
        )
        np.testing.assert_allclose(evaluation.jacobians[:20, :, axis], difference / (2 * step), atol=1e-6)


def test_more_points_than_one_call_takes_come_in_order(scene, random):
    points = random.uniform([0, 0, 0], [2, 1, 3], size=(5000, 3))

    evaluation = scene.evaluate(points)

    np.testing.assert_allclose(evaluation.positions, points, atol=1e-12)
    assert evaluation.jacobians.shape == (5000, 3, 3)
    np.testing.assert_allclose(evaluation.jacobians, np.broadcast_to(np.eye(3), (5000, 3, 3)), atol=1e-9)
