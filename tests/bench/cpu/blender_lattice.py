# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# Blender runs this: a 7 x 7 x 7 B-spline lattice modifier on 1,129,969 vertices. Prints the median
# time in milliseconds of a whole depsgraph update after one lattice point has moved, and of the
# same update without the modifier.
import statistics
import time

import bpy

SIDE = 1063  # SIDE * SIDE vertices
FRAMES = 9

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.mesh.primitive_grid_add(x_subdivisions=SIDE - 1, y_subdivisions=SIDE - 1, size=2)
surface = bpy.context.object
assert len(surface.data.vertices) == SIDE * SIDE, len(surface.data.vertices)

bpy.ops.object.add(type="LATTICE")
cage = bpy.context.object
cage.scale = (2.1, 2.1, 2.1)
lattice = cage.data
lattice.points_u = lattice.points_v = lattice.points_w = 7
for axis in "uvw":
    setattr(lattice, "interpolation_type_" + axis, "KEY_BSPLINE")
modifier = surface.modifiers.new("lattice", "LATTICE")
modifier.object = cage


def update(frame):
    """Moves a point, makes the surface depend on it anew; seconds until it is evaluated."""
    lattice.points[171].co_deform.z = 0.1 * (frame % 2)
    lattice.update_tag()
    surface.update_tag(refresh={"DATA"})
    start = time.perf_counter()
    bpy.context.view_layer.update()
    graph = bpy.context.evaluated_depsgraph_get()
    vertices = surface.evaluated_get(graph).data.vertices
    seconds = time.perf_counter() - start
    assert len(vertices) == SIDE * SIDE
    return seconds


def median_ms():
    update(0)
    return statistics.median(1e3 * update(frame) for frame in range(FRAMES))


whole = median_ms()
modifier.show_viewport = False
without = median_ms()
print(f"blender_lattice {whole:.1f} {without:.1f}")
