# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Add-on for Blender: shows the exact deformation of a mesh by a lattice object, live from a latticed server.

make_addon.py puts the Python client into the folder modules. grpcio and protobuf must be installed in
Blender's Python; for Debian's Blender they are python3-grpcio and python3-protobuf.
"""
import importlib.util
import sys
from pathlib import Path

bl_info = {
    "name": "latticed",
    "description": "Exact free-form deformation by a lattice, live from a latticed server",
    "author": "The latticed authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > latticed",
    "category": "Object",
}

_MODULES = Path(__file__).with_name("modules")
if importlib.util.find_spec("latticed") is None and _MODULES.is_dir():
    sys.path.append(str(_MODULES))


def register():
    from . import live, panel  # here, since they import bpy: tests of other modules have no bpy

    panel.register()
    live.register()


def unregister():
    from . import live, panel

    live.unregister()
    panel.unregister()
