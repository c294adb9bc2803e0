# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: blender --background --factory-startup --python-exit-code 1 --python drive_addon.py -- ADDON.zip
# Installs the add-on as a person would, connects it to LATTICED_SERVER and edits the lattice. Compares the
# result object with Blender's own lattice modifier on the same points.
import math
import os
import sys
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from addon_scene import (  # noqa: E402
    TOLERANCE,
    by_the_modifier,
    check,
    compare,
    connect,
    coordinates,
    corner_normals,
    install,
    make_lattice,
    make_objects,
    objects,
    result,
    runs_by_timer,
    set_interpolation,
    set_points,
    wait_for,
)

SEED = 20261122


def follows_every_interpolation(random):
    for interpolation in ("KEY_BSPLINE", "KEY_LINEAR", "KEY_CATMULL_ROM"):
        rest = connect(interpolation)
        set_points(lambda place: place + 0.3 * random.standard_normal(3))
        compare(rest, interpolation)
    set_interpolation("KEY_CARDINAL")  # a new scene on the server, but with the same knots
    compare(rest, "KEY_CARDINAL, while it was connected")
    return rest


def follows_undo(rest, random):
    bpy.ops.ed.undo_push(message="before")
    before = by_the_modifier(rest)
    set_points(lambda place: place + 0.3 * random.standard_normal(3))
    bpy.ops.ed.undo_push(message="edit")
    compare(rest, "an edit")
    check(bpy.ops.ed.undo() == {"FINISHED"}, "nothing was undone")
    check(np.abs(by_the_modifier(rest) - before).max() < 1e-6, "the undo did not restore the lattice")
    compare(rest, "its undo")


def follows_a_shape_key(rest, random):
    lattice = objects()[1]
    lattice.shape_key_add(name="Basis")
    key = lattice.shape_key_add(name="Bent")
    for point in key.data:
        point.co = np.array(point.co) + 0.3 * random.standard_normal(3)
    key.value = 0.75
    compare(rest, "a shape key")
    for frame, value in ((1, 0.75), (10, 0.25)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    bpy.context.scene.frame_set(10)
    compare(rest, "another frame of its animation")
    lattice.shape_key_clear()


def follows_edit_mode(rest):
    bpy.context.view_layer.objects.active = objects()[1]
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.lattice.select_all(action="SELECT")
    bpy.ops.transform.translate(value=(0.25, 0.0, 0.5))
    bpy.context.view_layer.update()
    compare(rest, "edit mode")
    bpy.ops.object.mode_set(mode="OBJECT")


def compare_vertices(what):
    """Like compare, for the mesh's vertices only. Each is a point of the result, whatever the patches are."""

    def farthest(expected, shown):
        return np.linalg.norm(expected[:, None] - shown, axis=-1).min(axis=1).max()

    # A distance is at most sqrt(3) times its largest coordinate.
    compare(coordinates(objects()[0].data), what, farthest, 2 * TOLERANCE)


def follows_other_structures(random):
    set_points(lambda place: place + 0.3 * random.standard_normal(3))
    compare_vertices("an edit")
    torus, lattice = objects()
    lattice.location = (0.4, 0.3, 0.2)
    compare_vertices("the lattice's own move")
    torus.rotation_euler = (0.1, 0.5, 0.2)
    compare_vertices("the mesh's own turn")
    for vertex in torus.data.vertices[:10]:
        vertex.co *= 1.3
    torus.data.update()
    compare_vertices("an edit of the mesh")
    lattice.data.points_u = 5
    compare_vertices("more lattice points")


def follows_the_view(rest):
    settings = bpy.context.scene.latticed
    settings.segments = 2 * settings.segments
    wait_for(lambda: len(result().data.vertices) > 2 * len(rest), "more segments")
    check(result().data.has_custom_normals, "the result has not the normals that were sent")
    uniform = len(result().data.polygons)
    settings.tolerance = 0.001
    wait_for(lambda: len(result().data.polygons) != uniform, "patterns of their own")
    fine = len(result().data.polygons)
    settings.tolerance = 0.1
    wait_for(lambda: len(result().data.polygons) < fine, "a larger tolerance")
    settings.tolerance = 0.0
    wait_for(lambda: len(result().data.polygons) == uniform, "segments again")
    facets = corner_normals(result().data)
    differs = lambda: np.abs(corner_normals(result().data) - facets).mean()
    settings.normals = "SMOOTH"
    wait_for(lambda: differs() > 0.05, "smooth normals")
    mesh = objects()[0].data
    mesh.use_auto_smooth, mesh.auto_smooth_angle = True, 0.0
    mesh.update()
    bpy.context.view_layer.update()
    wait_for(lambda: differs() < 0.02, "creases at every edge")
    mesh.auto_smooth_angle = math.pi
    mesh.update()
    bpy.context.view_layer.update()
    wait_for(lambda: differs() > 0.05, "the largest crease angle")
    settings.normals = "NONE"
    wait_for(lambda: not result().data.use_auto_smooth, "no normals")


def follows_a_vertex_group(random):
    """The vertices are where the lattice modifier has them with the same group, and with a strength."""
    settings, (torus, lattice) = bpy.context.scene.latticed, objects()
    modifier_strength = 0.375  # a float32 too
    group = torus.vertex_groups.new(name="Some")
    for vertex in torus.data.vertices:
        if vertex.index % 3:  # the others are in no group
            group.add([vertex.index], float(random.uniform()), "REPLACE")
    settings.weights = "Some"
    set_points(lambda place: place + 0.3 * random.standard_normal(3))
    copy = bpy.data.objects.new("weighted", torus.data.copy())
    copy.matrix_world = torus.matrix_world
    bpy.context.collection.objects.link(copy)
    copy.vertex_groups.new(name="Some")
    modifier = copy.modifiers.new("Lattice", "LATTICE")
    modifier.object, modifier.vertex_group = lattice, "Some"
    bpy.context.view_layer.update()

    def modified(strength):
        modifier.strength = strength
        bpy.context.view_layer.update()
        return coordinates(copy.evaluated_get(bpy.context.evaluated_depsgraph_get()).data)

    expected = {1.0: modified(1.0), modifier_strength: modified(modifier_strength)}
    bpy.data.objects.remove(copy)

    def worst():
        wanted = expected[settings.strength]
        shown = coordinates(result().data)
        if not len(shown):
            return np.inf
        return np.linalg.norm(wanted[:, None] - shown, axis=-1).min(axis=1).max()

    wait_for(lambda: worst() < 2 * TOLERANCE, "a vertex group")
    print(f"drive_addon: a vertex group: at most {worst():.1e} from Blender's modifier")
    settings.strength = modifier_strength
    wait_for(lambda: worst() < 2 * TOLERANCE, "another strength")
    settings.strength = 1.0
    settings.weights = "None of them"
    wait_for(lambda: not runs_by_timer(), "noticing that there is no such group")
    settings.weights = ""
    connect("KEY_BSPLINE")


def leaves_no_timer():
    """Checks that a disconnect stops the timer, and so does disabling the add-on."""
    from latticed_blender.live import tick

    bpy.context.scene.latticed.address = os.environ["LATTICED_SERVER"]
    connect("KEY_BSPLINE")
    check(bpy.ops.latticed.disconnect() == {"FINISHED"}, "it did not disconnect")
    check(not runs_by_timer(), "it is disconnected, and its timer goes on")
    connect("KEY_BSPLINE")
    bpy.ops.preferences.addon_disable(module="latticed_blender")
    check(not bpy.app.timers.is_registered(tick), "the add-on is disabled, and its timer stays")


def says_what_is_wrong():
    from latticed_blender.live import LIVE

    settings = bpy.context.scene.latticed
    bpy.data.objects.remove(objects()[1])
    wait_for(lambda: LIVE.status == "Disconnected: the lattice is gone", "noticing that the lattice is gone")
    check(not runs_by_timer(), "the lattice is gone, and the timer goes on")
    try:
        bpy.ops.latticed.connect()
        check(False, "it connected without a lattice")
    except RuntimeError as error:
        check("Select a mesh and a lattice" in str(error), f"without a lattice it says {error}")
    make_lattice()
    settings.address = "127.0.0.1:1"
    bpy.ops.latticed.connect()
    wait_for(lambda: not LIVE.connected, "noticing that there is no server")
    check(LIVE.status == "No server answers at 127.0.0.1:1", f"without a server it says: {LIVE.status}")


def main(addon):
    install(addon)
    from latticed_blender.live import LIVE

    print("drive_addon: seed", SEED)
    random = np.random.default_rng(SEED)
    make_objects()
    rest = follows_every_interpolation(random)
    print("drive_addon:", LIVE.status)
    follows_undo(rest, random)
    follows_edit_mode(rest)
    follows_a_shape_key(rest, random)
    follows_other_structures(random)
    follows_the_view(rest)
    follows_a_vertex_group(random)
    says_what_is_wrong()
    leaves_no_timer()


main(sys.argv[sys.argv.index("--") + 1])
