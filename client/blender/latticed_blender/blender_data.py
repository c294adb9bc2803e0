# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Converts Blender's objects to arrays. Main thread only."""
from __future__ import annotations

import math

import bpy
import numpy as np

from .lattice_map import BlenderLattice
from .source_mesh import SourceMesh


def _array(collection, name, width, kind):
    values = np.empty(len(collection) * width, dtype=kind)
    collection.foreach_get(name, values)
    return values.reshape(-1, width) if width > 1 else values


def read_mesh(source, group=""):
    """Reads the object's own mesh, in its own space, without modifiers. `group` names the vertex group that has the
    weights; empty: there are none. ValueError if the object has no faces, or no such group."""
    index = source.vertex_groups.find(group) if group else None
    if index == -1:
        raise ValueError(f"{source.name} has no vertex group {group}")
    if source.mode != "EDIT":
        return _read(source.data, source.name, index)
    # In edit mode Blender 3.4 has no texture coordinates to read, but a copy, which has no edit mode, has.
    source.update_from_editmode()
    copy = source.data.copy()
    try:
        return _read(copy, source.name, index)
    finally:
        bpy.data.meshes.remove(copy)


def _weights(mesh, group):
    """A vertex that is not in the group has the weight 0, as in Blender's modifiers."""
    weights = np.zeros(len(mesh.vertices), np.float32)
    for vertex in mesh.vertices:
        for element in vertex.groups:
            if element.group == group:
                weights[vertex.index] = element.weight
    return weights


def _read(mesh, name, group):
    if not len(mesh.polygons):
        raise ValueError(f"{name} has no faces")
    corners = _array(mesh.loops, "vertex_index", 1, np.int32)
    begins = _array(mesh.polygons, "loop_start", 1, np.int32)
    sizes = _array(mesh.polygons, "loop_total", 1, np.int32)
    if (sizes == sizes[0]).all():
        faces = corners.reshape(-1, sizes[0])
    else:
        faces = [corners[begin : begin + size] for begin, size in zip(begins, sizes)]
    # Blender's 180 degrees are a float32, which is a little more.
    crease_angle = min(180.0, math.degrees(mesh.auto_smooth_angle)) if mesh.use_auto_smooth else 180.0
    layer = mesh.uv_layers.active
    return SourceMesh(
        _array(mesh.vertices, "co", 3, np.float32),
        faces,
        crease_angle,
        uvs=None if layer is None else _array(layer.data, "uv", 2, np.float32),
        uv_name="" if layer is None else layer.name,
        materials=_array(mesh.polygons, "material_index", 1, np.int32),
        smooth=_array(mesh.polygons, "use_smooth", 1, bool),
        weights=None if group is None else _weights(mesh, group),
    )


def read_lattice(lattice, source, strength=1.0, known=None):
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
        strength=float(strength),
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
