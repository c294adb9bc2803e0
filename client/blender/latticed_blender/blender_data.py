# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Converts Blender's objects to arrays, and a surface to a mesh object. Main thread only."""
from __future__ import annotations

import math

import bpy
import numpy as np

from .lattice_map import BlenderLattice
from .live_session import SourceMesh, Surface


def _array(collection, name, width, kind):
    values = np.empty(len(collection) * width, dtype=kind)
    collection.foreach_get(name, values)
    return values.reshape(-1, width) if width > 1 else values


def read_mesh(source):
    """Reads the object's own mesh, in its own space, without modifiers. ValueError if it has no faces."""
    if source.mode == "EDIT":
        source.update_from_editmode()
    mesh = source.data
    if not len(mesh.polygons):
        raise ValueError(f"{source.name} has no faces")
    corners = _array(mesh.loops, "vertex_index", 1, np.int32)
    begins = _array(mesh.polygons, "loop_start", 1, np.int32)
    sizes = _array(mesh.polygons, "loop_total", 1, np.int32)
    if (sizes == sizes[0]).all():
        faces = corners.reshape(-1, sizes[0])
    else:
        faces = [corners[begin : begin + size] for begin, size in zip(begins, sizes)]
    # Blender's 180 degrees are a float32, which is a little more.
    crease_angle = min(180.0, math.degrees(mesh.auto_smooth_angle)) if mesh.use_auto_smooth else 180.0
    return SourceMesh(_array(mesh.vertices, "co", 3, np.float32), faces, crease_angle)


def read_lattice(lattice, source, known=None):
    """Reads a lattice object's points, after edits, shape keys and hooks, relative to the mesh object.
    `known` is the result of an earlier call for the same lattice, or None."""
    data = lattice.data
    evaluated = lattice.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    shape = (data.points_w, data.points_v, data.points_u, 3)
    return BlenderLattice(
        rest=_rest(lattice, shape, known),
        deformed=_array(evaluated.points, "co_deform", 3, np.float32).astype(float).reshape(shape),
        interpolation=(data.interpolation_type_u, data.interpolation_type_v, data.interpolation_type_w),
        to_mesh=np.array(source.matrix_world.inverted_safe() @ lattice.matrix_world),
    )


def _rest(lattice, shape, known):
    """The points at rest. In edit mode Blender 3.4 reads `co` of wrong points, but a copy, which has no edit
    mode, reads right. The number of points cannot change in edit mode."""
    if lattice.mode != "EDIT":
        return _array(lattice.data.points, "co", 3, np.float32).astype(float).reshape(shape)
    if known is not None and known.rest.shape == shape:
        return known.rest
    copy = lattice.data.copy()
    rest = _array(copy.points, "co", 3, np.float32).astype(float).reshape(shape)
    bpy.data.lattices.remove(copy)
    return rest


def make_result(source):
    """Makes an empty mesh object that moves with the source, in the source's collections."""
    result = bpy.data.objects.new(
        f"{source.name} (latticed)", bpy.data.meshes.new(f"{source.name} (latticed)")
    )
    for collection in source.users_collection:
        collection.objects.link(result)
    result.parent = source
    for material in source.data.materials[:1]:
        result.data.materials.append(material)
    return result


def write_surface(result, surface: Surface):
    """Writes points and normals, and triangles if the number of points or triangles changed."""
    mesh = result.data
    points, triangles = surface.positions, surface.triangles
    if len(mesh.vertices) != len(points) or len(mesh.polygons) != len(triangles):
        _make_geometry(mesh, len(points), triangles)
    mesh.vertices.foreach_set("co", np.ascontiguousarray(points).reshape(-1))
    mesh.use_auto_smooth = surface.normals is not None
    if surface.normals is not None:
        mesh.normals_split_custom_set_from_vertices(surface.normals)
    mesh.update()


def _make_geometry(mesh, points, triangles):
    mesh.clear_geometry()
    mesh.vertices.add(points)
    mesh.loops.add(3 * len(triangles))
    mesh.polygons.add(len(triangles))
    mesh.loops.foreach_set("vertex_index", triangles.astype(np.int32).reshape(-1))
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * len(triangles), 3, dtype=np.int32))
    mesh.polygons.foreach_set("loop_total", np.full(len(triangles), 3, dtype=np.int32))
    mesh.polygons.foreach_set("use_smooth", np.ones(len(triangles), dtype=bool))
    mesh.update(calc_edges=True)
