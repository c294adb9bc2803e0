# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
import io
import sys

import latticed
import numpy as np
import pytest

from definition import BOX_FACES, BOX_POSITIONS


def test_arrays_become_a_mesh(client, box):
    assert (box.name, box.vertices, box.faces) == ("box", 8, 6)
    np.testing.assert_array_equal(box.bounds, [[0, 0, 0], [2, 1, 3]])
    assert client.mesh(box.id).info == box.info


def test_labels_and_units_are_kept_and_found(client):
    positions = BOX_POSITIONS.astype(np.float32) + 7

    mesh = client.upload_arrays(
        positions, BOX_FACES, name="crate", up_axis="z", meters_per_unit=0.5, labels={"kind": "crate"}
    )

    assert (mesh.name, mesh.labels) == ("crate", {"kind": "crate"})
    assert (mesh.info.up_axis, mesh.info.meters_per_unit) == (3, 0.5)
    with client.create_scene(
        mesh, up_axis="y", crease_angle=0, name="old crate", delete_on_exit=True
    ) as scene:
        assert scene.info.name == "old crate"
        assert (scene.info.units.up_axis, scene.info.units.meters_per_unit) == (2, 0.5)
        assert scene.info.HasField("crease_angle") and scene.info.crease_angle == 0
    assert [found.id for found in client.meshes("kind=crate")] == [mesh.id]
    assert client.meshes("kind=barrel") == []
    mesh.delete()
    with pytest.raises(latticed.LatticedError) as caught:
        client.mesh(mesh.id)
    assert caught.value.reason == "NOT_FOUND"


def test_faces_of_any_size_and_attributes_of_corners(client):
    positions = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 2, 0], [2, 0.5, 0]]
    faces = [[0, 1, 2, 3], [3, 2, 4], (1, 5, 2)]

    mesh = client.upload_arrays(
        positions,
        faces,
        normals=np.tile([0, 0, 1.0], (6, 1)),
        uvs=np.arange(20.0).reshape(10, 2),
        face_groups=[0, 1, 1],
        group_names=["floor", "wall"],
    )

    assert (mesh.vertices, mesh.faces, mesh.info.corners) == (6, 3, 10)
    assert mesh.info.has_normals and mesh.info.has_uvs
    assert [(group.name, group.faces) for group in mesh.info.groups] == [("floor", 1), ("wall", 2)]


@pytest.mark.parametrize(
    "arguments, text",
    [
        ({"positions": np.zeros((4, 2))}, r"positions have the shape \(vertices, 3\), not \(4, 2\)"),
        ({"faces": [[0.0, 1.0, 2.0]]}, "faces hold integers, not float64"),
        ({"faces": np.zeros((2, 3))}, "faces hold integers, not float64"),
        ({"faces": [[0, 1, -1]]}, "0 or more"),
        ({"normals": np.zeros((5, 3))}, "5 normals for 8 vertices and 24 corners"),
        ({"uvs": np.zeros((8, 3))}, r"uvs have the shape \(vertices, 2\)"),
        ({"face_groups": [0] * 6}, "belong together"),
        ({"face_groups": [-1] * 6, "group_names": ["a"]}, "face_groups hold numbers of 0 or more"),
        ({"face_groups": [0] * 5, "group_names": ["a"]}, r"face_groups have the shape \(6,\), not \(5,\)"),
        ({"up_axis": "up"}, "up_axis is one of x, y, z"),
    ],
)
def test_arrays_that_do_not_fit_are_value_errors(client, arguments, text):
    with pytest.raises(ValueError, match=text):
        client.upload_arrays(**{"positions": BOX_POSITIONS, "faces": BOX_FACES, **arguments})


def write_obj(path, positions, faces):
    lines = [f"v {x} {y} {z}" for x, y, z in positions] + [
        "f " + " ".join(str(i + 1) for i in face) for face in faces
    ]
    path.write_text("\n".join(lines) + "\n")


def test_a_file_is_uploaded_once_and_its_progress_told(client, tmp_path):
    n = 181  # the file is larger than one part of 768 KiB
    x, y = np.meshgrid(np.arange(float(n)), np.arange(float(n)))
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).reshape(-1, 1)
    faces = corner + np.array([0, 1, n + 1, n])
    write_obj(tmp_path / "sheet.obj", np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3), faces)
    first, second = [], []

    mesh = client.upload(tmp_path / "sheet.obj", progress=lambda done, total: first.append((done, total)))
    again = client.upload(tmp_path / "sheet.obj", progress=lambda done, total: second.append((done, total)))

    size = (tmp_path / "sheet.obj").stat().st_size
    assert size > 768 * 1024
    assert first == [(768 * 1024, size), (size, size)]
    assert second == [(size, size)]
    assert (mesh.name, mesh.faces, again.id) == ("sheet.obj", (n - 1) ** 2, mesh.id)


def test_what_was_uploaded_comes_back(client, box, tmp_path):
    write_obj(tmp_path / "box.obj", BOX_POSITIONS, BOX_FACES)
    uploaded = (tmp_path / "box.obj").read_bytes()
    mesh = client.upload(tmp_path / "box.obj")
    told = []

    mesh.download(tmp_path / "again.obj", progress=lambda done, total: told.append((done, total)))

    assert (tmp_path / "again.obj").read_bytes() == mesh.download_bytes() == uploaded
    assert told[-1] == (len(uploaded), len(uploaded))
    assert np.array_equal(np.frombuffer(box.download_bytes(), "<f8", 24), BOX_POSITIONS.reshape(-1))
    mesh.delete()
    with pytest.raises(latticed.LatticedError) as caught:
        mesh.download(tmp_path / "gone.obj")
    assert caught.value.reason == "NOT_FOUND"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["again.obj", "box.obj"]


def test_a_bar_is_drawn_on_a_terminal_unless_told_otherwise(client, monkeypatch):
    terminal = io.StringIO()
    terminal.isatty = lambda: True
    monkeypatch.setattr(sys, "stderr", terminal)

    client.upload_arrays(BOX_POSITIONS + 4, BOX_FACES, progress=False)
    assert terminal.getvalue() == ""
    client.upload_arrays(BOX_POSITIONS + 5, BOX_FACES)
    assert terminal.getvalue().startswith("\rupload mesh [####")
    assert "100%" in terminal.getvalue() and terminal.getvalue().endswith("\n")
    terminal.isatty = lambda: False
    before = terminal.getvalue()
    client.upload_arrays(BOX_POSITIONS + 2, BOX_FACES)
    assert terminal.getvalue() == before


@pytest.mark.parametrize(
    "name, content, text", [("a.xyz", "v", "must be one of .obj"), ("a.obj", "", "is empty")]
)
def test_a_file_that_cannot_be_a_mesh_is_a_value_error(client, tmp_path, name, content, text):
    (tmp_path / name).write_text(content)

    with pytest.raises(ValueError, match=text):
        client.upload(tmp_path / name)


def test_a_mesh_in_use_is_not_deleted_unless_forced(client):
    mesh = client.upload_arrays(BOX_POSITIONS + 3, BOX_FACES)
    scene = client.create_scene(mesh)

    with pytest.raises(latticed.LatticedError) as caught:
        mesh.delete()
    mesh.delete(force=True)

    assert caught.value.reason == "MESH_IN_USE"
    with pytest.raises(latticed.LatticedError):
        scene.refresh()
