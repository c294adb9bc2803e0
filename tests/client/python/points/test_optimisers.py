# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""latticed.scipy, latticed.torch and their examples. Where a package is missing, its test is skipped; latticed.torch is
then tested with a stand-in for torch (stand_in/torch.py)."""
import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from server_process import ROOT

EXAMPLES = ROOT / "client/python/examples"
HERE = Path(__file__).parent


def needs(module):
    return pytest.mark.skipif(importlib.util.find_spec(module) is None, reason=f"needs {module}")


def run(server, name, *arguments):
    command = [sys.executable, EXAMPLES / name, *map(str, arguments), "--server", server.address]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def is_png(path):
    data = path.read_bytes()
    return data.startswith(b"\x89PNG") and len(data) > 5000


@needs("scipy")
@needs("matplotlib")
def test_a_lattice_is_fitted_to_a_target(server, tmp_path):
    printed = run(server, "fit_shape.py", tmp_path / "fit.png", "--iterations", 60)
    first, last = map(float, re.search(r"distance: (\S+) at first, (\S+) at last", printed).groups())
    assert first > 0.3 and last < 0.01 * first
    assert is_png(tmp_path / "fit.png")


@needs("scipy")
@needs("matplotlib")
def test_drag_falls_at_constant_volume(server, tmp_path):
    printed = run(server, "least_drag.py", tmp_path / "drag.png", "--iterations", 25)
    first, last = map(float, re.search(r"drag: (\S+) at first, (\S+) at last", printed).groups())
    assert 1.5 < first < 1.6  # pi / 2 of a round sphere
    assert last < 0.7 * first
    assert float(re.search(r"changed by (\S+) of it", printed)[1]) < 1e-3
    assert is_png(tmp_path / "drag.png")


def test_a_volume_mesh_is_deformed_as_points(server):
    printed = run(server, "tetrahedra.py", "--nodes", 20)
    assert printed.startswith("8000 nodes, 41154 tetrahedra")
    ratio, inverted = re.search(r"same cell at rest: (\S+); inverted: (\d+)", printed).groups()
    assert 0.3 < float(ratio) < 0.6 and inverted == "0"


@needs("meshio")
@pytest.mark.parametrize("name", ["vtu", "vtk"])
def test_a_volume_mesh_is_read_and_written(server, tmp_path, name):
    import meshio

    into, out = tmp_path / f"in.{name}", tmp_path / f"out.{name}"

    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]]
    nodes = np.array([*corners, [0.5, 0.45, 0.5]])  # the last one is inside the ball's lattice
    cells = np.array([[0, 1, 2, 3], [1, 2, 3, 5], [1, 3, 2, 4]])
    meshio.Mesh(nodes, [("tetra", cells)]).write(into)
    printed = run(server, "tetrahedra.py", into, "--out", out)
    assert printed.startswith("6 nodes, 3 tetrahedra")
    moved = meshio.read(out)
    assert moved.points.shape == nodes.shape and (moved.cells_dict["tetra"] == cells).all()
    distances = np.linalg.norm(moved.points - nodes, axis=1)
    assert distances[:5].max() == 0 and 0.02 < distances[5] < 0.1


def test_the_gradients_of_the_examples_are_right(random):
    sys.path.insert(0, str(EXAMPLES))
    try:
        import bodies
    finally:
        sys.path.pop(0)
    vertices, triangles = bodies.sphere(6, 8)
    x = vertices + random.uniform(-0.05, 0.05, vertices.shape)
    direction = random.normal(size=x.shape)
    for function in (bodies.volume(triangles), bodies.impact_drag(triangles, [1, 0, 0])):
        difference = (function(x + 1e-6 * direction)[0] - function(x - 1e-6 * direction)[0]) / 2e-6
        assert abs(difference - (function(x)[1] * direction).sum()) < 1e-7
    assert 3 < bodies.volume(triangles)(vertices)[0] < 4 * np.pi / 3


def with_torch(which, *command):
    """Runs a program with PyTorch, or with the stand-in for it."""
    path = [os.environ["PYTHONPATH"], str(HERE.parent)]
    if which == "stand-in":
        path.insert(0, str(HERE / "stand_in"))
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path)}
    done = subprocess.run([sys.executable, *command], capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


BOTH = pytest.mark.parametrize("which", [pytest.param("torch", marks=needs("torch")), "stand-in"])


@BOTH
def test_torch_differentiates_through_the_server(server, which):
    assert with_torch(which, HERE / "torch_session.py", server.address).endswith("gradients agree\n")


@BOTH
def test_torch_fits_a_mirrored_lattice(server, which):
    printed = with_torch(which, EXAMPLES / "fit_torch.py", "--server", server.address, "--steps", "150")
    first, last = map(float, re.search(r"distance: (\S+) at first, (\S+) at last", printed).groups())
    assert first > 0.1 and last < 0.1 * first
    assert float(re.search(r"mirror: (\S+)", printed)[1]) < 1e-12


@pytest.mark.skipif(importlib.util.find_spec("torch") is not None, reason="torch is here")
def test_the_example_says_that_it_needs_torch():
    done = subprocess.run([sys.executable, EXAMPLES / "fit_torch.py"], capture_output=True, text=True)
    assert done.returncode != 0 and "needs PyTorch" in done.stderr and "Traceback" not in done.stderr
