# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The mesh object that shows a surface. Main thread only.

While it follows edits with normals from the server, each patch has its own vertices: if patches shared them,
Blender would need a normal per corner of a face, which takes 1.7 times as long as one per vertex. Without normals,
patches share vertices, which takes half as long, and so they do once the result is kept.
"""
from __future__ import annotations

import bpy
import numpy as np

from .live_session import Surface

_LAYOUT = "latticed_layout"  # a mesh's own record of what it was made for, which undo restores with it


def make_result(source):
    """Makes an empty mesh object that moves with the source, in the source's collections."""
    name = f"{source.name} (latticed)"
    result = bpy.data.objects.new(name, bpy.data.meshes.new(name))
    for collection in source.users_collection:
        collection.objects.link(result)
    result.parent = source
    return result


def copy_materials(source, result):
    """Gives the result the materials that the source shows, slot by slot."""
    wanted, materials = [slot.material for slot in source.material_slots], result.data.materials
    for index, material in enumerate(wanted):
        if index == len(materials):
            materials.append(material)
        elif materials[index] != material:
            materials[index] = material
    while len(materials) > len(wanted):
        materials.pop()


def write_surface(source, result, surface: Surface, welded=False):
    """Writes points and normals; faces, texture coordinates and materials only if the layout is another one."""
    mesh, layout = result.data, surface.layout
    welded = welded or surface.normals is None
    chosen, vertex = layout.welded if welded else (slice(None), None)
    points = surface.positions[chosen]
    made_for = f"{layout.id} {'welded' if welded else 'apart'}"
    counts = (len(mesh.vertices), len(mesh.polygons))
    if mesh.get(_LAYOUT) != made_for or counts != (len(points), len(layout.triangles)):
        copy_materials(source, result)
        _make_geometry(mesh, len(points), layout, vertex)
        mesh[_LAYOUT] = made_for
    mesh.vertices.foreach_set("co", np.ascontiguousarray(points).reshape(-1))
    mesh.use_auto_smooth = surface.normals is not None
    if surface.normals is not None and welded:
        mesh.normals_split_custom_set(surface.normals[layout.triangles.reshape(-1)])
    elif surface.normals is not None:
        mesh.normals_split_custom_set_from_vertices(surface.normals)
    mesh.update()


def release(result):
    """Makes the result an object of its own, where it is."""
    place = result.matrix_world.copy()
    result.parent = None
    result.matrix_world = place
    result.data.pop(_LAYOUT, None)


def remove(result):
    """Deletes the result, and its mesh if no other object has it."""
    mesh = result.data
    bpy.data.objects.remove(result)
    if not mesh.users:
        bpy.data.meshes.remove(mesh)


def _make_geometry(mesh, points, layout, vertex):
    """`vertex` is the vertex of each point of the surface; None: points are vertices."""
    mesh.clear_geometry()
    corners = layout.triangles.reshape(-1)
    mesh.vertices.add(points)
    mesh.loops.add(len(corners))
    mesh.polygons.add(len(layout.triangles))
    vertices = corners if vertex is None else vertex[corners]
    mesh.loops.foreach_set("vertex_index", vertices.astype(np.int32))
    mesh.polygons.foreach_set("loop_start", np.arange(0, len(corners), 3, dtype=np.int32))
    mesh.polygons.foreach_set("loop_total", np.full(len(layout.triangles), 3, dtype=np.int32))
    mesh.polygons.foreach_set("material_index", layout.materials.astype(np.int32))
    mesh.polygons.foreach_set("use_smooth", layout.smooth)
    if layout.uvs is not None:
        layer = mesh.uv_layers.new(name=layout.uv_name, do_init=False)
        layer.data.foreach_set("uv", layout.uvs[corners].reshape(-1))
    mesh.update(calc_edges=True)
