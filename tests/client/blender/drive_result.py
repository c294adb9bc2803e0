# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: blender --background --factory-startup --python-exit-code 1 --python drive_result.py -- ADDON.zip
# The result's texture coordinates, materials and shading are those of the mesh, by their definition; Keep makes it an
# object of its own; Apply moves the mesh's own vertices.
import itertools
import sys
from collections import Counter
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from addon_scene import (  # noqa: E402
    by_the_modifier,
    check,
    compare,
    connect,
    coordinates,
    corner_normals,
    install,
    make_objects,
    objects,
    result,
    runs_by_timer,
    set_points,
    wait_for,
)

SEED = 20261126
PLACE_TOLERANCE = 4e-4  # points are rounded to 16 bits over a range of 8 units
UV_TOLERANCE = 1e-3  # the torus has at most 1 / (2 pi 0.25) texture units per unit of length
FLOAT32 = 1e-5  # Blender computes its lattice in single precision


def values(collection, name, width, kind):
    found = np.empty(width * len(collection), kind)
    collection.foreach_get(name, found)
    return found.reshape(-1, width) if width > 1 else found


def uvs(mesh):
    return values(mesh.uv_layers.active.data, "uv", 2, np.float32)


def materials(mesh):
    return values(mesh.polygons, "material_index", 1, np.int32)


def smooth(mesh):
    return values(mesh.polygons, "use_smooth", 1, bool)


def corners(mesh):
    return values(mesh.loops, "vertex_index", 1, np.int32)


def triangles(mesh):
    return corners(mesh).reshape(-1, 3)


def dress_torus():
    """Gives each face of the torus a material, and every third one smooth shading."""
    torus = objects()[0]
    for name in ("red", "green", "blue"):
        torus.data.materials.append(bpy.data.materials.new(name))
    torus.data.uv_layers.active.name = "atlas"
    for polygon in torus.data.polygons:
        polygon.material_index, polygon.use_smooth = polygon.index % 3, polygon.index % 3 == 1


def barycentrics(points, spanned):
    """Of points (n, 3) in triangles (m, 3, 3): (n, m, 3), and each point's distance from each plane, (n, m)."""
    a, edges = spanned[:, 0], spanned[:, 1:] - spanned[:, :1]
    normal = np.cross(edges[:, 0], edges[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    frame = np.linalg.inv(np.concatenate([edges, normal[:, None]], axis=1))
    found = np.einsum("nmi,mij->nmj", points[:, None] - a, frame)
    first = 1 - found[..., :1] - found[..., 1:2]
    return np.concatenate([first, found[..., :2]], axis=-1), np.abs(found[..., 2])


def has_what_its_mesh_has(rest):
    """Compares with all triangles that two edges or diagonals of a quad of the mesh span, since the server chooses."""
    source, mesh = objects()[0].data, result().data
    triples = np.array([c for p in source.polygons for c in itertools.combinations(p.loop_indices, 3)])
    places, of_source = coordinates(source)[corners(source)][triples], uvs(source)[triples]
    shown, wrong = uvs(mesh).reshape(-1, 3, 2), 0
    checked = np.arange(0, len(mesh.polygons), 7)
    for triangle in checked:
        points = rest[triangles(mesh)[triangle]]
        inside, distance = barycentrics(points.mean(axis=0)[None], places)
        there = np.flatnonzero((inside[0] > -1e-3).all(axis=1) & (distance[0] < PLACE_TOLERANCE))
        shares, _ = barycentrics(points, places[there])
        wanted = np.einsum("nmk,mkx->mnx", shares, of_source[there])
        face = there // 4  # a quad has four triples of corners
        good = np.abs(wanted - shown[triangle]).max(axis=(1, 2), initial=0) < UV_TOLERANCE
        good &= materials(source)[face] == materials(mesh)[triangle]
        good &= smooth(source)[face] == smooth(mesh)[triangle]
        wrong += not good.any()
    check(wrong == 0, f"{wrong} of {len(checked)} triangles have not what their face has")
    check(mesh.uv_layers.active.name == "atlas", f"the layer is called {mesh.uv_layers.active.name}")
    check(list(mesh.materials) == list(source.materials), "the materials differ")
    print(
        f"drive_result: {len(checked)} triangles have their faces' texture coordinates, material and shading"
    )


def touches_only_places_while_edited(rest, random):
    """A mark that nobody else would set must stay."""
    mesh = result().data
    before = uvs(mesh)
    mesh.polygons[5].material_index = 7
    set_points(lambda place: place + 0.2 * random.standard_normal(3))
    compare(rest, "an edit with attributes")
    check(mesh.polygons[5].material_index == 7, "an edit of the lattice sets materials again")
    check((uvs(mesh) == before).all(), "an edit of the lattice changed texture coordinates")
    normals = corner_normals(mesh).reshape(-1, 3, 3)
    curved = np.ptp(normals, axis=1).max(axis=1)
    check(curved[~smooth(mesh)].mean() > 1e-3, "flat faces have not the normals that were sent")


def moved_from(before):
    now = coordinates(result().data)
    return now.shape != before.shape or np.abs(now - before).max() > 0.01


def follows_its_mesh():
    source = objects()[0].data
    values_of = lambda: (uvs(result().data).max(), Counter(materials(result().data)))
    for loop in source.uv_layers.active.data:
        loop.uv = loop.uv * 3
    source.update()
    wait_for(lambda: abs(values_of()[0] - 3) < UV_TOLERANCE, "other texture coordinates")
    for polygon in source.polygons:
        polygon.material_index = 2
    source.update()
    wait_for(lambda: set(values_of()[1]) == {2}, "other materials of faces")
    objects()[0].material_slots[2].material = bpy.data.materials.new("gold")
    wait_for(lambda: result().data.materials[2].name == "gold", "another material")
    bpy.context.view_layer.objects.active = objects()[0]
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.transform.translate(value=(0.1, 0.0, 0.0))
    bpy.context.view_layer.update()
    before = coordinates(result().data)
    wait_for(lambda: moved_from(before), "an edit in edit mode")
    check(abs(values_of()[0] - 3) < UV_TOLERANCE, "edit mode has no texture coordinates")
    check(
        not (bpy.ops.latticed.apply.poll() or bpy.ops.latticed.keep.poll()), "edit mode offers Apply or Keep"
    )
    bpy.ops.object.mode_set(mode="OBJECT")


def is_closed(mesh):
    return set(Counter(key for polygon in mesh.polygons for key in polygon.edge_keys).values()) == {2}


def is_welded_without_normals():
    settings = bpy.context.scene.latticed
    check(not is_closed(result().data), "with normals patches share vertices, which takes long")
    settings.normals = "NONE"
    wait_for(lambda: is_closed(result().data), "closing without normals")
    check(abs(uvs(result().data).max() - 3) < UV_TOLERANCE, "the welded result has no texture coordinates")
    settings.normals = "FACET"
    wait_for(lambda: result().data.has_custom_normals, "facet normals")


def keeps_the_result(random):
    shown, place = result(), result().matrix_world.copy()
    mesh = shown.data
    corner_places = lambda: coordinates(mesh)[triangles(mesh)]
    before = (corner_places(), uvs(mesh), materials(mesh), smooth(mesh), corner_normals(mesh))
    check(bpy.ops.latticed.keep() == {"FINISHED"}, "Keep did not work")

    def compare_with_before(what):
        now = (corner_places(), uvs(mesh), materials(mesh), smooth(mesh))
        check(all((a == b).all() for a, b in zip(now, before)), f"{what} changed the kept object")

    compare_with_before("Keep")
    check(is_closed(mesh), "the kept object has open edges")
    differs = np.abs(corner_normals(mesh) - before[4]).max()
    check(mesh.has_custom_normals and differs < 5e-3, f"its normals differ by {differs}")
    bpy.context.view_layer.update()
    stays = np.abs(np.array(shown.matrix_world) - np.array(place)).max() < FLOAT32
    check(shown.parent is None and stays, "the kept object is not where it was")
    check(result() is None and not runs_by_timer(), "it is kept, and the session goes on")
    connect("KEY_LINEAR")
    check(result() != shown, "the next session drives the kept object")
    set_points(lambda place: place + 0.3 * random.standard_normal(3))
    compare_with_before("a later edit")
    print(f"drive_result: kept {len(mesh.vertices)} vertices, normals differ by at most {differs:.1e}")


def undoes_keep():
    bpy.ops.ed.undo_push(message="before Keep")
    name = result().name
    check(bpy.ops.latticed.keep("EXEC_DEFAULT", True) == {"FINISHED"}, "Keep did not work again")
    check(is_closed(bpy.data.objects[name].data), "the second kept object has open edges")
    check(bpy.ops.ed.undo() == {"FINISHED"}, "Keep cannot be undone")
    check(result().name == name and result().parent == objects()[0], "the undo did not restore the result")
    check(not is_closed(result().data), "the undo did not restore the result's vertices")


def is_refused(operator, why):
    try:
        operator()
        check(False, f"it works although: {why}")
    except RuntimeError as error:
        check(why in str(error), f"instead of {why!r} it says {error}")


def says_why_it_does_not():
    torus = objects()[0]
    before = coordinates(torus.data)
    torus.shape_key_add(name="Basis")
    is_refused(bpy.ops.latticed.apply, "Torus has shape keys: apply or remove them first")
    torus.shape_key_clear()
    twin = bpy.data.objects.new("Twin", torus.data)
    is_refused(bpy.ops.latticed.apply, "2 objects share the mesh of Torus: make it single-user first")
    bpy.data.objects.remove(twin)
    check((coordinates(torus.data) == before).all(), "a refused Apply moves vertices")
    bpy.ops.latticed.connect()
    is_refused(bpy.ops.latticed.keep, "No surface has come yet")
    bpy.ops.latticed.disconnect()
    check(not bpy.ops.latticed.keep.poll(), "Keep is offered without a session")


def applies_and_undoes():
    torus = objects()[0]
    rest = coordinates(torus.data)
    wanted = by_the_modifier(rest)
    before = (
        uvs(torus.data),
        materials(torus.data),
        corners(torus.data),
        len(torus.data.materials),
    )
    bpy.ops.ed.undo_push(message="before Apply")
    name = result().name
    torus.hide_set(True)
    check(bpy.ops.latticed.apply("EXEC_DEFAULT", True) == {"FINISHED"}, "Apply did not work")
    mesh = objects()[0].data
    differs = np.abs(coordinates(mesh) - wanted).max()
    check(np.abs(wanted - rest).max() > 0.1 and differs < FLOAT32, f"vertices differ by {differs}")
    now = (uvs(mesh), materials(mesh), corners(mesh), len(mesh.materials))
    check(all(np.array_equal(a, b) for a, b in zip(now, before)), "Apply changed more than places")
    check(name not in bpy.data.objects and result() is None, "Apply leaves the result")
    check(objects()[0].visible_get(), "Apply leaves the mesh hidden")
    check(not runs_by_timer(), "it is applied, and the session goes on")
    check(bpy.ops.ed.undo() == {"FINISHED"}, "Apply cannot be undone")
    check((coordinates(objects()[0].data) == rest).all(), "the undo did not restore the mesh")
    check(result() is not None and result().name == name, "the undo did not restore the result")
    print(f"drive_result: Apply: {len(rest)} vertices, at most {differs:.1e} from Blender's modifier")


def applies_without_a_server():
    wanted = by_the_modifier(coordinates(objects()[0].data))
    check(bpy.ops.latticed.apply() == {"FINISHED"}, "Apply needs a session")
    check(
        np.abs(coordinates(objects()[0].data) - wanted).max() < FLOAT32,
        "without a server Apply does something else",
    )


def main(addon):
    install(addon)
    print("drive_result: seed", SEED)
    random = np.random.default_rng(SEED)
    make_objects()
    dress_torus()
    rest = connect("KEY_BSPLINE")
    has_what_its_mesh_has(rest)
    touches_only_places_while_edited(rest, random)
    follows_its_mesh()
    is_welded_without_normals()
    keeps_the_result(random)
    undoes_keep()
    connect("KEY_LINEAR")
    set_points(lambda place: place + 0.3 * random.standard_normal(3))
    applies_and_undoes()
    says_why_it_does_not()
    applies_without_a_server()


main(sys.argv[sys.argv.index("--") + 1])
