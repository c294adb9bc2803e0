# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Deforms the mesh itself instead of showing its surface. Needs no server. Main thread only."""
from __future__ import annotations

import bpy
import numpy as np

from . import blender_data
from .lattice_map import LatticeMap


def move_vertices(source, lattice, group="", strength=1.0):
    """Moves the mesh's vertices to where the lattice has them, computed in double, each by its weight in the vertex group
    `group`, or all of the way where that is empty, and by the strength. Faces, texture coordinates and
    materials stay. ValueError, with a text for the user, for a mesh that cannot be changed so."""
    mesh = source.data
    if mesh.shape_keys is not None:
        raise ValueError(f"{source.name} has shape keys: apply or remove them first")
    users = sum(thing.data == mesh for thing in bpy.data.objects)
    if users > 1:
        raise ValueError(f"{users} objects share the mesh of {source.name}: make it single-user first")
    read = blender_data.read_mesh(source, group)
    positions = read.positions.astype(float)
    grid = blender_data.read_lattice(lattice, source, strength)
    moved = LatticeMap(grid, positions).lattice(grid).deform(positions)
    if read.weights is not None:
        moved = positions + read.weights[:, None].astype(float) * (moved - positions)
    mesh.vertices.foreach_set("co", moved.astype(np.float32).reshape(-1))
    mesh.update()
