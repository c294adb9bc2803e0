# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The tab "latticed" of the 3D view's sidebar."""
import textwrap

import bpy

from .live import LIVE

_STATUS_WIDTH = 28  # in characters; it fits a sidebar of the usual width
_NORMALS = (
    ("FACET", "Facet", "The exact normals of the deformed surface: the mesh's faces stay visible"),
    ("SMOOTH", "Smooth", "The mesh's vertex normals, carried along by the deformation"),
    ("NONE", "None", "None are sent; Blender makes its own"),
)


def _view_changed(settings, context):
    LIVE.touch("view")


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
        "segments": bpy.props.IntProperty(
            name="Segments",
            default=4,
            min=1,
            max=32,
            description="Subdivisions of a patch's edge",
            update=_view_changed,
        ),
        "normals": bpy.props.EnumProperty(
            name="Normals", items=_NORMALS, default="FACET", update=_view_changed
        ),
    }


def _chosen(context, settings):
    """The mesh and the lattice to connect: the selected ones, or else the ones of the last session."""
    selected = {thing.type: thing for thing in context.selected_objects}
    active = context.active_object
    if active is not None:
        selected[active.type] = active
    return selected.get("MESH") or settings.source, selected.get("LATTICE") or settings.lattice


class LATTICED_OT_connect(bpy.types.Operator):
    """Sends the selected mesh and lattice, and shows the deformed surface while the lattice is edited"""

    bl_idname = "latticed.connect"
    bl_label = "Connect"
    bl_options = {"UNDO"}  # an undo step: undoing the first edit after it restores this state

    def execute(self, context):
        settings = context.scene.latticed
        source, lattice = _chosen(context, settings)
        if source == settings.result and source is not None:
            source = settings.source
        if source is None or lattice is None:
            self.report({"ERROR"}, "Select a mesh and a lattice")
            return {"CANCELLED"}
        try:
            LIVE.connect(context.scene, source, lattice)
        except ValueError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class LATTICED_OT_disconnect(bpy.types.Operator):
    """Ends the connection; the result stays as it is"""

    bl_idname = "latticed.disconnect"
    bl_label = "Disconnect"

    def execute(self, context):
        LIVE.disconnect()
        return {"FINISHED"}


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
        layout.prop(settings, "segments")
        layout.prop(settings, "normals")
        for line in textwrap.wrap(LIVE.status, _STATUS_WIDTH):
            layout.label(text=line)


_CLASSES = (LatticedSettings, LATTICED_OT_connect, LATTICED_OT_disconnect, LATTICED_PT_panel)


def register():
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.latticed = bpy.props.PointerProperty(type=LatticedSettings)


def unregister():
    del bpy.types.Scene.latticed
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
