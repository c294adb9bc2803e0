# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The buttons of the panel."""
import bpy

from . import own_vertices, result_object
from .live import LIVE


def _chosen(context, settings):
    """The mesh and the lattice to connect: the selected ones, or else the ones of the last session."""
    selected = {thing.type: thing for thing in context.selected_objects}
    active = context.active_object
    if active is not None:
        selected[active.type] = active
    return selected.get("MESH") or settings.source, selected.get("LATTICE") or settings.lattice


def _done(operator, act, *arguments):
    """Acts. If a ValueError says why that cannot be, the operator reports it, and this returns False."""
    try:
        act(*arguments)
    except ValueError as error:
        operator.report({"ERROR"}, str(error))
        return False
    return True


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
        if not _done(self, LIVE.connect, context.scene, source, lattice):
            return {"CANCELLED"}
        return {"FINISHED"}


class LATTICED_OT_disconnect(bpy.types.Operator):
    """Ends the connection; the result stays as it is"""

    bl_idname = "latticed.disconnect"
    bl_label = "Disconnect"

    def execute(self, context):
        LIVE.disconnect()
        return {"FINISHED"}


class LATTICED_OT_apply(bpy.types.Operator):
    """Moves the mesh's own vertices to where the lattice has them, disconnects and removes the result"""

    bl_idname = "latticed.apply"
    bl_label = "Apply"
    bl_options = {"UNDO"}

    @classmethod
    def poll(cls, context):
        settings, shown = context.scene.latticed, set(context.view_layer.objects)
        return context.mode == "OBJECT" and {settings.source, settings.lattice} <= shown

    def execute(self, context):
        settings = context.scene.latticed
        if not _done(
            self,
            own_vertices.move_vertices,
            settings.source,
            settings.lattice,
            settings.weights,
            settings.strength,
        ):
            return {"CANCELLED"}
        LIVE.disconnect("The mesh is deformed")
        if settings.result is not None:
            result_object.remove(settings.result)
        settings.source.hide_set(False)
        return {"FINISHED"}


class LATTICED_OT_keep(bpy.types.Operator):
    """Makes the result, as it is shown, an ordinary object, and disconnects"""

    bl_idname = "latticed.keep"
    bl_label = "Keep"
    bl_options = {"UNDO"}

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT" and LIVE.connected

    def execute(self, context):
        if not _done(self, LIVE.keep):
            return {"CANCELLED"}
        return {"FINISHED"}


OPERATORS = (LATTICED_OT_connect, LATTICED_OT_disconnect, LATTICED_OT_apply, LATTICED_OT_keep)
