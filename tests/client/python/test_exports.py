# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
import latticed
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


def test_a_file_is_there_whole_or_not_at_all(scene, tmp_path):
    with pytest.raises(latticed.LatticedError) as caught:
        scene.export(tmp_path / "a.ply", revision=7)
    assert caught.value.reason == "REVISION_CHANGED"
    with pytest.raises(ValueError, match="a format is one of ply"):
        scene.export(tmp_path / "a.txt")

    assert list(tmp_path.iterdir()) == []
