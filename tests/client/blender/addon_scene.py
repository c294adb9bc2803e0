# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""A torus and a lattice in Blender, connected to LATTICED_SERVER by the add-on, for the tests of the add-on."""
import faulthandler
import os
import sys
import time
from pathlib import Path

import bpy
import numpy as np

TOLERANCE = 6e-4  # points at rest and results are both rounded to 16 bits over a range of 8 to 16 units
GIVES_UP = 240  # seconds: what a test does then is printed, and Blender ends
NAME = Path(sys.argv[sys.argv.index("--python") + 1]).stem  # of the test
faulthandler.dump_traceback_later(GIVES_UP, exit=True)


def install(addon):
    """Installs the add-on as a person would."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_install(filepath=addon)
    bpy.ops.preferences.addon_enable(module="latticed_blender")
    bpy.context.scene.latticed.address = os.environ["LATTICED_SERVER"]


def check(condition, text):
    if not condition:
        raise SystemExit(f"{NAME}: {text}")


def coordinates(mesh):
    values = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", values)
    return values.reshape(-1, 3).astype(float)


def corner_normals(mesh):
    mesh.calc_normals_split()
    normals = np.empty(3 * len(mesh.loops), dtype=np.float32)
    mesh.loops.foreach_get("normal", normals)
    return normals


def wait_for(condition, what):
    """Calls the timer's function itself: Blender runs no timers with --background."""
    from latticed_blender.live import LIVE

    deadline = time.monotonic() + 60
    while not condition():
        check(time.monotonic() < deadline, f"{what} did not happen: {LIVE.status}")
        bpy.context.view_layer.update()
        LIVE.tick()
        time.sleep(0.01)


def runs_by_timer():
    """Whether the timer is registered and stays so: Blender removes a timer whose function returns None."""
    from latticed_blender.live import tick

    return bpy.app.timers.is_registered(tick) and tick() is not None


def objects():
    """Finds both objects by name: an undo replaces them by new objects."""
    return bpy.data.objects["Torus"], bpy.data.objects["Lattice"]


def make_objects():
    bpy.ops.mesh.primitive_torus_add(major_segments=12, minor_segments=8)
    torus = bpy.context.active_object
    torus.location, torus.rotation_euler = (0.3, -0.2, 0.1), (0.4, 0.1, 0.0)
    make_lattice()


def make_lattice():
    data = bpy.data.lattices.new("Lattice")
    data.points_u, data.points_v, data.points_w = 4, 3, 2
    lattice = bpy.data.objects.new("Lattice", data)
    bpy.context.collection.objects.link(lattice)
    lattice.scale = (0.6, 0.8, 0.5)  # the torus reaches out of the lattice
    lattice.rotation_euler = (0.0, 0.2, 0.3)
    lattice.select_set(True)
    bpy.context.view_layer.update()


def result():
    return bpy.context.scene.latticed.result


def by_the_modifier(rest):
    """The positions to which Blender's own lattice modifier moves points at `rest`."""
    bpy.context.view_layer.update()
    torus, lattice = objects()
    mesh = bpy.data.meshes.new("points")
    mesh.vertices.add(len(rest))
    mesh.vertices.foreach_set("co", rest.astype(np.float32).reshape(-1))
    points = bpy.data.objects.new("points", mesh)
    points.matrix_world = torus.matrix_world
    bpy.context.collection.objects.link(points)
    points.modifiers.new("Lattice", "LATTICE").object = lattice
    moved = coordinates(points.evaluated_get(bpy.context.evaluated_depsgraph_get()).data)
    bpy.data.objects.remove(points)
    return moved


def compare(rest, what, distance=None, tolerance=TOLERANCE):
    """Waits until the result shows what Blender's modifier makes of points at `rest`."""
    expected = by_the_modifier(rest)
    check(np.abs(expected - rest).max() > 0.1, f"{what}: the lattice moves nothing")

    def worst():
        shown = coordinates(result().data)
        if distance is not None:
            return distance(expected, shown)
        return np.abs(shown - expected).max() if len(shown) == len(expected) else np.inf

    wait_for(lambda: worst() < tolerance, what)
    print(f"{NAME}: {what}: {len(expected)} vertices, at most {worst():.1e} from Blender's modifier")


def set_points(move):
    """Sets the position of every lattice point to `move` of its position at rest."""
    data = objects()[1].data
    for point in data.points:
        point.co_deform = move(np.array(point.co))
    data.update_tag()
    bpy.context.view_layer.update()


def set_interpolation(interpolation):
    data = objects()[1].data
    for axis in "uvw":
        setattr(data, f"interpolation_type_{axis}", interpolation)


def connect(interpolation):
    """Connects with the lattice at rest. Returns the points of the result."""
    set_interpolation(interpolation)
    set_points(lambda place: place)
    if result() is not None:
        result().data.clear_geometry()
    check(bpy.ops.latticed.connect() == {"FINISHED"}, "it did not connect")
    check(runs_by_timer(), "it connected, and no timer shows what comes")
    wait_for(lambda: result().data.vertices, "connecting")
    return coordinates(result().data)
