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
_EVERY = slice(None)
_APART = (_EVERY, None, _EVERY)  # the welding of a surface whose every point is a vertex


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
    chosen, vertex, kept = layout.welding if welded else _APART
    points, corners = surface.positions[chosen], layout.triangles[kept].reshape(-1)
    made_for = f"{layout.id} {'welded' if welded else 'apart'}"
    if mesh.get(_LAYOUT) != made_for or (len(mesh.vertices), len(mesh.loops)) != (len(points), len(corners)):
        copy_materials(source, result)
        _make_faces(mesh, len(points), corners if vertex is None else vertex[corners])
        _dress_faces(mesh, layout, kept)
        mesh[_LAYOUT] = made_for
    mesh.vertices.foreach_set("co", np.ascontiguousarray(points).reshape(-1))
    mesh.use_auto_smooth = surface.normals is not None
    if surface.normals is not None and welded:
        mesh.normals_split_custom_set(surface.normals[corners])
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


def _make_faces(mesh, vertices, corners):
    """Makes triangles of the vertices at `corners`."""
    mesh.clear_geometry()
    mesh.vertices.add(vertices)
    mesh.loops.add(len(corners))
    mesh.polygons.add(len(corners) // 3)
    mesh.loops.foreach_set("vertex_index", corners.astype(np.int32))
    mesh.polygons.foreach_set("loop_start", np.arange(0, len(corners), 3, dtype=np.int32))
    mesh.polygons.foreach_set("loop_total", np.full(len(corners) // 3, 3, dtype=np.int32))
    mesh.update(calc_edges=True)


def _dress_faces(mesh, layout, kept):
    mesh.polygons.foreach_set("material_index", layout.materials[kept].astype(np.int32))
    mesh.polygons.foreach_set("use_smooth", layout.smooth[kept])
    if layout.uvs is not None:
        layer = mesh.uv_layers.new(name=layout.uv_name, do_init=False)
        layer.data.foreach_set("uv", layout.uvs[layout.triangles[kept]].reshape(-1))
