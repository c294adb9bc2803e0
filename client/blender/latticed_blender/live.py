# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The one live session: sends changes of Blender's objects, and writes surfaces into the result object.

Each step finds the objects through the scene's settings and keeps no reference, because undo and loading
replace objects. Main thread only.
"""
from __future__ import annotations

import bpy
import latticed
from bpy.app.handlers import persistent

from . import blender_data, result_object
from .live_session import LiveSession

_TICK_SECONDS = 0.02
# A view with a tolerance has at most as many points as these segments would give. The server reserves memory for them.
_MOST_SEGMENTS = 16


def _view(settings):
    return latticed.View(
        segments=_MOST_SEGMENTS if settings.tolerance > 0 else settings.segments,
        tolerance=settings.tolerance,
        normals=settings.normals.lower(),
        position_bits=16,
        normal_bits=12,
    )


class Live:
    """connected   whether there is a session
    status      the session's state, or why it ended, as text
    """

    def __init__(self):
        self._session = None
        self._scene = ""  # name of the session's Blender scene
        self._ended = "Not connected"
        self._shown = ""  # the status that panels show
        self._dirty = set()  # a set of "mesh", "lattice", "view": these must be read again
        self._grid = None  # the lattice as last read
        self._newest = None  # the surface that the result shows

    @property
    def connected(self):
        return self._session is not None

    @property
    def status(self):
        return self._session.status if self.connected else self._ended

    def connect(self, scene, source, lattice):
        """Starts a session. ValueError, with a text for the user, for objects that cannot be shown."""
        self.disconnect()
        settings = scene.latticed
        mesh = blender_data.read_mesh(source, settings.weights)
        grid = blender_data.read_lattice(lattice, source, settings.strength)
        settings.source, settings.lattice = source, lattice
        if settings.result is None or settings.result.parent != source:
            settings.result = result_object.make_result(source)
        self._session = LiveSession(settings.address, mesh, grid, _view(settings), settings.token)
        self._scene, self._grid = scene.name, grid
        self._dirty.clear()
        if not bpy.app.timers.is_registered(tick):
            bpy.app.timers.register(tick, persistent=True)

    def disconnect(self, reason="Not connected"):
        """Ends the session. The result object stays as it is."""
        if self.connected:
            self._session.close()
        self._session, self._newest, self._ended = None, None, reason

    def keep(self):
        """Welds the result as it is shown, makes it an object of its own, and ends the session. ValueError, with
        a text for the user, if nothing is shown yet."""
        settings = self._settings()
        if not self.connected or self._newest is None or self._what_is_gone(settings):
            raise ValueError("No surface has come yet")
        result_object.write_surface(settings.source, settings.result, self._newest, welded=True)
        result_object.release(settings.result)
        settings.result = None
        self.disconnect("The result is an object of its own")

    def touch(self, what):
        """Makes the next tick read this again: "mesh", "lattice" or "view"."""
        if self.connected:
            self._dirty.add(what)

    def tick(self):
        """Runs every 20 ms while there is a session. Returns the next pause in seconds, or None to stop."""
        if self.connected:
            self._step(self._settings())
        self._show_status()
        return _TICK_SECONDS if self.connected else None

    def notice(self, updates):
        """Marks as dirty the objects that a depsgraph's updates name."""
        settings = self._settings()
        if not self.connected or self._what_is_gone(settings):
            return
        for update in updates:
            changed = update.id.original
            if changed in (settings.lattice, settings.lattice.data):
                self.touch("lattice")
            elif changed == settings.source and update.is_updated_transform:
                self.touch("lattice")  # the mesh has moved relative to it
            elif changed == settings.source.data and update.is_updated_geometry:
                self.touch("mesh")

    def after_undo(self):
        """Undo brings back an older result, and maybe an older lattice and mesh."""
        for what in ("mesh", "lattice", "view"):
            self.touch(what)
        settings = self._settings()
        if self.connected and self._newest is not None and not self._what_is_gone(settings):
            result_object.write_surface(settings.source, settings.result, self._newest)

    def _settings(self):
        """The session's settings; None if its scene is gone."""
        scene = bpy.data.scenes.get(self._scene)
        return scene.latticed if scene is not None else None

    @staticmethod
    def _what_is_gone(settings):
        """Names what is missing, or "". A deleted object may still be in the settings, but is in no scene."""
        if settings is None:
            return "scene"
        needed = (("mesh", settings.source), ("lattice", settings.lattice), ("result", settings.result))
        return next((what for what, thing in needed if thing is None or not thing.users_scene), "")

    def _step(self, settings):
        gone = self._what_is_gone(settings)
        if gone:
            self.disconnect(f"Disconnected: the {gone} is gone")
        elif not self._session.running:
            self.disconnect(self._session.status)
        else:
            try:
                self._send(settings)
            except ValueError as error:
                self.disconnect(str(error))
        surface = self._session.take() if self.connected else None
        if surface is not None:
            self._newest = surface
            result_object.write_surface(settings.source, settings.result, surface)

    def _send(self, settings):
        mesh = grid = view = None
        if "mesh" in self._dirty:
            mesh = blender_data.read_mesh(settings.source, settings.weights)
            result_object.copy_materials(settings.source, settings.result)
        if "lattice" in self._dirty:
            grid = self._grid = blender_data.read_lattice(
                settings.lattice, settings.source, settings.strength, self._grid
            )
        if "view" in self._dirty:
            view = _view(settings)
        if self._dirty:
            self._dirty.clear()
            self._session.change(mesh, grid, view)

    def _show_status(self):
        if self._shown == self.status:
            return
        self._shown = self.status
        for window in bpy.context.window_manager.windows:
            for area in window.screen.areas:
                if area.type == "VIEW_3D":
                    area.tag_redraw()


LIVE = Live()


def tick():
    return LIVE.tick()


@persistent
def on_depsgraph_update(_, depsgraph):
    LIVE.notice(depsgraph.updates)


@persistent
def on_frame_change(*_):
    """A frame change does not name changed objects, so the lattice is read again."""
    LIVE.touch("lattice")


@persistent
def on_undo(*_):
    LIVE.after_undo()


@persistent
def on_load(*_):
    LIVE.disconnect()


_HANDLERS = {
    "depsgraph_update_post": on_depsgraph_update,
    "frame_change_post": on_frame_change,
    "undo_post": on_undo,
    "redo_post": on_undo,
    "load_pre": on_load,
}


def register():
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).append(handler)


def unregister():
    LIVE.disconnect()
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).remove(handler)
    if bpy.app.timers.is_registered(tick):
        bpy.app.timers.unregister(tick)
