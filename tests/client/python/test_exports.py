# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
import json
import struct

import latticed
import numpy as np
import pytest

from definition import BOX_FACES, BOX_POSITIONS, deform


@pytest.mark.parametrize(
    "suffix, begin",
    [
        ("ply", b"ply\n"),
        ("obj", b"v "),
        ("glb", b"glTF"),
        ("drc", b"DRACO"),
        ("nets", b"LATTNETS"),
        ("usda", b"#usda 1.0"),
    ],
)
def test_every_format_by_suffix(scene, tmp_path, suffix, begin):
    told = []

    exported = scene.export(tmp_path / f"a.{suffix}", progress=lambda done, total: told.append((done, total)))

    data = (tmp_path / f"a.{suffix}").read_bytes()
    assert exported == latticed.Exported(revision=0, certified_error=0)
    assert data.startswith(begin)
    assert told[-1] == (len(data), len(data))
    assert scene.export_bytes(suffix) == data


def test_an_export_by_a_tolerance_tells_what_it_keeps(scene, tmp_path):
    edited = scene.move([21, 22, 42], (0.25, 0.5, -0.125))

    coarse = scene.export(tmp_path / "coarse.obj", view=latticed.View(segments=32, tolerance=0.05))
    fine = scene.export(tmp_path / "fine.obj", view=latticed.View(segments=32, tolerance=0.001))

    assert coarse.revision == fine.revision == edited.revision
    assert 0 < fine.certified_error <= 0.001 < coarse.certified_error <= 0.05
    assert (tmp_path / "fine.obj").stat().st_size > (tmp_path / "coarse.obj").stat().st_size


def test_a_file_is_there_whole_or_not_at_all(scene, tmp_path):
    with pytest.raises(latticed.LatticedError) as caught:
        scene.export(tmp_path / "a.ply", revision=7)
    assert caught.value.reason == "REVISION_CHANGED"
    with pytest.raises(ValueError, match="a format is one of ply"):
        scene.export(tmp_path / "a.txt")

    assert list(tmp_path.iterdir()) == []


def test_an_original_mesh_has_its_own_faces_at_deformed_places(scene):
    with scene.deform() as stream:
        edit = stream.move([21, 22, 42], (0.25, 0.5, -0.125))
        stream.wait(edit)
        lattice = stream.lattice

    lines = [line.split() for line in scene.export_bytes("obj", original=True).decode().splitlines()]

    moved = np.array([line[1:] for line in lines if line[0] == "v"], dtype=float)
    faces = np.array(
        [[corner.split("/")[0] for corner in line[1:]] for line in lines if line[0] == "f"], dtype=int
    )
    np.testing.assert_allclose(moved, deform(lattice, BOX_POSITIONS), atol=1e-12)
    assert np.abs(moved - BOX_POSITIONS).max() > 0.01
    np.testing.assert_array_equal(faces - 1, BOX_FACES)


def test_patches_that_are_not_welded_have_vertices_of_their_own(scene):
    view = latticed.View(segments=2)

    apart = scene.export_bytes("obj", view, welded=False).decode().splitlines()

    faces = sum(line.startswith("f ") for line in apart)
    assert faces % 4 == 0
    assert sum(line.startswith("v ") for line in apart) == faces // 4 * 6  # 4 triangles and 6 points a patch


def test_control_nets_are_of_the_exact_surface_only(scene):
    with pytest.raises(latticed.LatticedError) as caught:
        scene.export_bytes("nets", original=True)
    assert caught.value.reason == "INVALID_FIELD" and "geometry" in str(caught.value)


PICTURE = b"the bytes of a picture"


def painted_glb():
    """A triangle whose material has a picture."""
    corners = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
    binary = corners + PICTURE + bytes(-len(PICTURE) % 4)
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": 5126,
                "count": 3,
                "type": "VEC3",
                "min": [0, 0, 0],
                "max": [1, 1, 0],
            }
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": len(corners)},
            {"buffer": 0, "byteOffset": len(corners), "byteLength": len(PICTURE)},
        ],
        "buffers": [{"byteLength": len(binary)}],
        "images": [{"bufferView": 1, "mimeType": "image/png"}],
        "textures": [{"source": 0}],
        "materials": [{"name": "bricks", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = (
        struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    )
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


@pytest.mark.parametrize("original", [False, True])
def test_a_glb_keeps_its_materials_and_pictures(client, tmp_path, original):
    (tmp_path / "painted.glb").write_bytes(painted_glb())
    with client.create_scene(client.upload(tmp_path / "painted.glb"), delete_on_exit=True) as scene:
        data = scene.export_bytes("glb", original=original)

    length = struct.unpack_from("<I", data, 12)[0]
    document, binary = json.loads(data[20 : 20 + length]), data[28 + length :]
    assert document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] == {"index": 0}
    view = document["bufferViews"][document["images"][0]["bufferView"]]
    assert binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]] == PICTURE
    assert document["meshes"][0]["primitives"][0]["material"] == 0
