# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
import latticed
import numpy as np
import pytest


@pytest.mark.parametrize(
    "suffix, begin",
    [("ply", b"ply\n"), ("obj", b"v "), ("glb", b"glTF"), ("drc", b"DRACO"), ("nets", b"LATTNETS")],
)
def test_every_format_by_suffix(scene, tmp_path, suffix, begin):
    told = []

    revision = scene.export(tmp_path / f"a.{suffix}", progress=lambda done, total: told.append((done, total)))

    data = (tmp_path / f"a.{suffix}").read_bytes()
    assert revision == 0 and data.startswith(begin)
    assert told[-1] == (len(data), len(data))
    assert scene.export_bytes(suffix) == data


def test_a_file_shows_what_an_update_shows(scene):
    scene.move(scene.lattice().indices[-1], (1, 0, 0))
    update = scene.get_update(latticed.View(encoding="raw", segments=3))

    data = scene.export_bytes("stl", latticed.View(segments=3))

    kind = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    triangles = np.frombuffer(data, kind, offset=84)["corners"]
    np.testing.assert_allclose(triangles, update.points.reshape(-1, 3)[update.triangles], atol=1e-5)


def test_a_file_is_there_whole_or_not_at_all(scene, tmp_path):
    with pytest.raises(latticed.LatticedError) as caught:
        scene.export(tmp_path / "a.ply", revision=7)
    assert caught.value.reason == "REVISION_CHANGED"
    with pytest.raises(ValueError, match="a format is one of ply"):
        scene.export(tmp_path / "a.txt")

    assert list(tmp_path.iterdir()) == []
