# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The attributes and the welded vertices of the add-on's result, which need no Blender."""
from collections import Counter
from dataclasses import replace

import latticed
import numpy as np
import pytest
from latticed_blender.source_mesh import SourceMesh
from latticed_blender.surface_layout import SurfaceLayout

import definition

FACES = np.array(definition.BOX_FACES)
BOX = SourceMesh(np.array(definition.BOX_POSITIONS, np.float32), FACES)
# Of a place on face f: affine in the place, and another function on each face, so that every edge is a seam.
UV_OF_PLACE = np.array([[0.3, 0.1], [-0.2, 0.4], [0.05, 0.25]])
UV_OF_FACE = 0.5
FLOAT32 = 1e-6  # of coordinates that are at most 4


def box_uvs(places, faces):
    return places @ UV_OF_PLACE + UV_OF_FACE * np.asarray(faces)[..., None]


def box_face(triangle):
    """Which face of the box contains a triangle, by the plane that it lies in."""
    for face, corners in enumerate(definition.BOX_POSITIONS[FACES]):
        axis = np.ptp(corners, axis=0).argmin()
        if np.allclose(triangle[:, axis], corners[0, axis], atol=1e-5):
            return face
    raise AssertionError("a triangle is on no face")


def sides(triangles):
    """How many triangles each edge has."""
    return Counter(tuple(sorted(side)) for a, b, c in triangles for side in ((a, b), (b, c), (c, a)))


@pytest.fixture
def layout_of(client):
    """Makes the layout of a mesh's surface at rest, and the surface."""
    scenes = []

    def make(mesh, segments=3, size=(4, 3, 5), degree=(3, 1, 2), tolerance=0.0, bend=None):
        uploaded = client.upload_arrays(mesh.positions, mesh.faces, progress=False)
        scenes.append(client.create_scene(uploaded, size=size, degree=degree))
        if bend is not None:
            lattice = scenes[-1].lattice()
            scenes[-1].replace(lattice.control_points + bend(lattice.control_points.shape))
        view = latticed.View(segments=segments, encoding="raw", tolerance=tolerance)
        update = scenes[-1].get_update(view)
        layout = SurfaceLayout(mesh, scenes[-1].provenance(update), update)
        return layout, update.points.reshape(-1, 3)

    yield make
    for scene in scenes:
        scene.delete()


def test_every_corner_has_the_coordinates_and_every_triangle_the_material_of_its_face(layout_of):
    face_of_corner = np.repeat(np.arange(6), 4)
    uvs = box_uvs(definition.BOX_POSITIONS[FACES.reshape(-1)], face_of_corner).astype(np.float32)
    materials, smooth = np.array([4, 0, 2, 1, 3, 5], np.int32), np.arange(6) % 2 == 0

    layout, points = layout_of(replace(BOX, uvs=uvs, uv_name="atlas", materials=materials, smooth=smooth))

    faces = [box_face(triangle) for triangle in points[layout.triangles]]
    expected = box_uvs(points[layout.triangles], np.repeat(faces, 3).reshape(-1, 3))
    np.testing.assert_allclose(layout.uvs[layout.triangles], expected, atol=FLOAT32)
    np.testing.assert_array_equal(layout.materials, materials[faces])
    np.testing.assert_array_equal(layout.smooth, smooth[faces])
    assert layout.uv_name == "atlas"


def test_a_mesh_without_attributes_gives_none(layout_of):
    layout, _ = layout_of(BOX)

    assert layout.uvs is None and not layout.materials.any() and layout.smooth.all()


@pytest.mark.parametrize("segments", [1, 2, 5])
def test_a_closed_mesh_has_a_closed_welded_surface(layout_of, segments):
    layout, points = layout_of(BOX, segments)

    chosen, vertex, kept = layout.welding

    assert kept.all()
    np.testing.assert_allclose(points[chosen][vertex], points, atol=FLOAT32)  # one vertex, one place
    assert len(np.unique(points[chosen].round(5), axis=0)) == len(chosen)  # one place, one vertex
    edges = sides(vertex[layout.triangles])
    assert set(edges.values()) == {2}
    assert len(chosen) - len(edges) + len(layout.triangles) == 2  # Euler's formula


def test_patterns_of_a_tolerance_are_welded_to_a_closed_surface(layout_of, random):
    uvs = box_uvs(definition.BOX_POSITIONS[FACES.reshape(-1)], np.repeat(np.arange(6), 4)).astype(np.float32)
    bend = lambda shape: random.normal(scale=0.2, size=shape)  # noqa: E731

    layout, points = layout_of(replace(BOX, uvs=uvs), 16, tolerance=0.02, bend=bend)

    assert len({len(pattern) for pattern in layout.patterns}) > 1, "patches differ"
    assert layout.uvs.shape == (len(points), 2)
    assert len(layout.materials) == len(layout.smooth) == len(layout.triangles)
    chosen, vertex, kept = layout.welding
    assert kept.all()
    np.testing.assert_allclose(points[chosen][vertex], points, atol=FLOAT32)
    edges = sides(vertex[layout.triangles])
    assert set(edges.values()) == {2}
    assert len(chosen) - len(edges) + len(layout.triangles) == 2


def test_faces_of_any_length_are_welded_and_parts_that_only_touch_stay_apart(layout_of):
    beside = definition.BOX_POSITIONS + [2, 0, 0]
    first = [list(face) for face in FACES[:-1]] + [[3, 0, 4], [3, 4, 7]]
    second = [[8 + vertex for vertex in face] for face in first]
    positions = np.concatenate([definition.BOX_POSITIONS, beside]).astype(np.float32)

    layout, points = layout_of(SourceMesh(positions, first + second))

    chosen, vertex, kept = layout.welding
    edges = sides(vertex[layout.triangles])
    assert set(edges.values()) == {2}
    assert len(chosen) - len(edges) + len(layout.triangles) == 4  # two closed parts
    np.testing.assert_allclose(points[chosen][vertex], points, atol=FLOAT32)


@pytest.mark.parametrize("segments", [1, 4])
def test_slivers_beside_knots_are_left_out_and_nothing_opens(layout_of, segments):
    """Each vertex of an octahedron is within rounding of two knot planes, as in meshes made symmetric in float32."""
    noise = 3e-8
    ends = [[1, noise, -noise], [-1, -noise, -noise], [noise, 1, noise], [noise, -1, -noise]]
    positions = np.array([*ends, [-noise, noise, 1], [noise, noise, -1]], np.float32)
    faces = [[x, y, z] if (x ^ y ^ z) & 1 == 0 else [x, z, y] for x in (0, 1) for y in (2, 3) for z in (4, 5)]

    layout, points = layout_of(
        SourceMesh(positions, np.array(faces)), segments, size=(4, 4, 4), degree=(2, 2, 2)
    )

    chosen, vertex, kept = layout.welding
    triangles = vertex[layout.triangles[kept]]
    edges = sides(triangles)
    assert 0 < kept.sum() < len(kept)
    assert set(edges.values()) == {2} and set(triangles.reshape(-1)) == set(range(len(chosen)))
    assert len(chosen) - len(edges) + len(triangles) == 2
    ends = points[chosen][np.array(list(edges))]
    assert np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).min() > 1e-3


def test_meshes_are_the_same_only_with_the_same_attributes():
    full = replace(
        BOX,
        uvs=np.zeros((24, 2), np.float32),
        uv_name="a",
        materials=np.zeros(6, np.int32),
        smooth=np.ones(6, bool),
    )
    listed = replace(full, faces=[list(face) for face in FACES])

    assert full.same(replace(full, uvs=full.uvs.copy())) and listed.same(
        replace(listed, faces=list(listed.faces))
    )
    for other in (
        replace(full, positions=BOX.positions + 1),
        replace(full, faces=FACES[:, ::-1]),
        replace(full, crease_angle=30.0),
        replace(full, uvs=full.uvs + 1),
        replace(full, uvs=None),
        replace(full, uv_name="b"),
        replace(full, materials=full.materials + 1),
        replace(full, smooth=~full.smooth),
    ):
        assert not full.same(other)
    assert not listed.same(replace(listed, faces=[face[::-1] for face in listed.faces]))
