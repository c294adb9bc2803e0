# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The renderer of the examples: hidden surfaces, and progress on a terminal."""
import os
import pty
import subprocess
import sys

import numpy as np
import pytest

from server_process import ROOT

EXAMPLES = ROOT / "client/python/examples"


@pytest.fixture
def renderer(monkeypatch):
    monkeypatch.syspath_prepend(EXAMPLES)
    import render_ply

    return render_ply


def test_blocks_sample_every_triangle_about_a_pixel_apart(renderer, random):
    corners = random.uniform(0, 40, size=(60, 3, 3)) * random.choice([0.01, 1.0], size=(60, 1, 1))
    seen = []

    for triangles, weights in renderer.blocks(corners):
        n = round((2 * len(weights)) ** 0.5) - 1
        assert len(weights) == (n + 1) * (n + 2) // 2
        np.testing.assert_allclose(weights.sum(axis=1), 1)
        edges = np.linalg.norm(np.diff(corners[triangles][:, [0, 1, 2, 0], :2], axis=1), axis=2)
        assert (edges <= n * renderer.SPACING).all()
        seen.extend(triangles)

    assert sorted(seen) == list(range(60))


def test_each_entry_shows_the_nearest_of_many_triangles(renderer, random):
    """Ten squares, each of two triangles and parallel to the screen, in any order."""
    depths = random.permutation(10)
    square = np.array([[[1, 1], [9, 1], [1, 9]], [[9, 9], [1, 9], [9, 1]]], float)
    corners = np.concatenate([np.dstack([square, np.full((2, 3), d)]) for d in depths.astype(float)])
    shares = []

    entries, owner, weights = renderer.nearest(corners, 10, 10, shares.append)

    rows, columns = np.divmod(entries, 10)
    assert set(range(1, 9)) <= set(rows) and set(range(1, 9)) <= set(columns)
    np.testing.assert_array_equal(depths[owner // 2], 0)
    places = np.einsum("mk,mkc->mc", weights, corners[owner])
    np.testing.assert_array_equal(np.floor(places[:, 1]) * 10 + np.floor(places[:, 0]), entries)
    assert shares == sorted(shares) and shares[-1] == 1


def write_ply(path):
    """One triangle, as the server exports it."""
    header = "ply\nformat binary_little_endian 1.0\nelement vertex 3\n"
    header += "".join(f"property float {name}\n" for name in "x y z nx ny nz".split())
    header += "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    vertices = np.array([[0, 0, 0, 0, -1, 0], [1, 0, 0, 0, -1, 0], [0, 0, 1, 0, -1, 0]], "<f4")
    path.write_bytes(header.encode() + vertices.tobytes() + b"\3" + np.arange(3, dtype="<i4").tobytes())


def test_polygons_become_fans_of_triangles(renderer):
    face = lambda *corners: bytes([len(corners)]) + np.array(corners, "<i4").tobytes()
    quad, triangles = face(3, 1, 4, 7), face(0, 1, 2) + face(2, 1, 0)

    np.testing.assert_array_equal(renderer.read_triangles(triangles, 2), [[0, 1, 2], [2, 1, 0]])
    np.testing.assert_array_equal(
        renderer.read_triangles(quad + triangles, 3), [[3, 1, 4], [3, 4, 7], [0, 1, 2], [2, 1, 0]]
    )


def test_progress_is_shown_on_a_terminal_only(tmp_path):
    write_ply(tmp_path / "a.ply")
    command = [sys.executable, EXAMPLES / "render_ply.py", "out.png", "a.ply", "a.ply"]

    piped = subprocess.run(command, cwd=tmp_path, check=True, stderr=subprocess.PIPE)
    ours, theirs = pty.openpty()
    subprocess.run(command, cwd=tmp_path, check=True, stderr=theirs)
    os.close(theirs)
    shown = os.read(ours, 10000).decode()
    os.close(ours)

    assert piped.stderr == b""
    assert shown == "\rdraw mesh 1 of 2 100%\r\n\rdraw mesh 2 of 2 100%\r\n"
    assert (tmp_path / "out.png").read_bytes().startswith(b"\x89PNG")


def test_without_files_it_says_how_it_is_used():
    said = subprocess.run([sys.executable, EXAMPLES / "render_ply.py"], capture_output=True, text=True)

    assert said.returncode == 2 and said.stderr.startswith(
        "usage: render_ply.py [-h] [--edges] OUT.png A.ply"
    )


def test_edges_are_darker_than_the_middle(renderer):
    corners = np.array([[[0.0, 0, 0], [100, 0, 0], [0, 100, 0]]]).repeat(3, axis=0)
    weights = np.array(
        [[0.3, 0.3, 0.4], [0.5, 0.48, 0.02], [0.5, 0.495, 0.005]]
    )  # 2 and 0.5 entries from an edge

    np.testing.assert_array_equal(renderer.near_edge(corners, weights), [False, False, True])
