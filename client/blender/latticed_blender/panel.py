# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The tab "latticed" of the 3D view's sidebar."""
import textwrap

import bpy

from .live import LIVE
from .operators import OPERATORS

_STATUS_WIDTH = 28  # in characters; it fits a sidebar of the usual width
_NORMALS = (
    ("FACET", "Facet", "The exact normals of the deformed surface: the mesh's faces stay visible"),
    ("SMOOTH", "Smooth", "The mesh's vertex normals, carried along by the deformation"),
    ("NONE", "None", "None are sent; Blender makes its own"),
)


def _view_changed(settings, context):
    LIVE.touch("view")


def _weights_changed(settings, context):
    LIVE.touch("mesh")


def _strength_changed(settings, context):
    LIVE.touch("lattice")


def _is_mesh(settings, candidate):
    return candidate.type == "MESH"


def _is_lattice(settings, candidate):
    return candidate.type == "LATTICE"


class LatticedSettings(bpy.types.PropertyGroup):
    __annotations__ = {
        "address": bpy.props.StringProperty(
            name="Server", default="127.0.0.1:50151", description="host:port or unix:path of latticed"
        ),
        "token": bpy.props.StringProperty(
            name="Token",
            subtype="PASSWORD",
            options={"SKIP_SAVE"},
            description="Where the server asks for one",
        ),
        "source": bpy.props.PointerProperty(type=bpy.types.Object, poll=_is_mesh, name="Mesh"),
        "lattice": bpy.props.PointerProperty(type=bpy.types.Object, poll=_is_lattice, name="Lattice"),
        "result": bpy.props.PointerProperty(type=bpy.types.Object, poll=_is_mesh, name="Result"),
        "weights": bpy.props.StringProperty(
            name="Weights",
            description="Vertex group of the mesh: how much of the deformation each vertex takes. Empty: all of it",
            update=_weights_changed,
        ),
        "strength": bpy.props.FloatProperty(
            name="Strength",
            default=1.0,
            min=0.0,
            max=1.0,
            subtype="FACTOR",
            description="How much of the deformation the mesh takes",
            update=_strength_changed,
        ),
        "segments": bpy.props.IntProperty(
            name="Segments",
            default=4,
            min=1,
            max=32,
            description="Subdivisions of a patch's edge",
            update=_view_changed,
        ),
        "tolerance": bpy.props.FloatProperty(
            name="Tolerance",
            default=0.0,
            min=0.0,
            precision=5,
            description="Largest distance of the triangles from the exact surface, in the mesh's own units. "
            "Each patch then has as many as it needs. 0: all patches have Segments",
            update=_view_changed,
        ),
        "normals": bpy.props.EnumProperty(
            name="Normals", items=_NORMALS, default="FACET", update=_view_changed
        ),
    }


class LATTICED_PT_panel(bpy.types.Panel):
    bl_label = "latticed"
    bl_idname = "LATTICED_PT_panel"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "latticed"

    def draw(self, context):
        settings, layout = context.scene.latticed, self.layout
        layout.use_property_split = True
        where = layout.column()
        where.enabled = not LIVE.connected
        where.prop(settings, "address")
        where.prop(settings, "token")
        if LIVE.connected:
            layout.operator("latticed.disconnect", icon="UNLINKED")
        else:
            layout.operator("latticed.connect", icon="LINKED")
        if settings.source is not None:
            layout.prop_search(settings, "weights", settings.source, "vertex_groups")
        layout.prop(settings, "strength", slider=True)
        segments = layout.column()
        segments.enabled = settings.tolerance == 0
        segments.prop(settings, "segments")
        layout.prop(settings, "tolerance")
        layout.prop(settings, "normals")
        ends = layout.row(align=True)
        ends.operator("latticed.apply", icon="CHECKMARK")
        ends.operator("latticed.keep", icon="DUPLICATE")
        for line in textwrap.wrap(LIVE.status, _STATUS_WIDTH):
            layout.label(text=line)


_CLASSES = (LatticedSettings, *OPERATORS, LATTICED_PT_panel)


def register():
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.latticed = bpy.props.PointerProperty(type=LatticedSettings)


def unregister():
    del bpy.types.Scene.latticed
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
