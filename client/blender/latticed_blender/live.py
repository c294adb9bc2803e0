# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The one live session: what Blender changes goes to it, what comes from it goes into the result.

Objects are found through the scene's settings at every step and never kept, since undo and loading replace
them. Main thread alone.
"""
from __future__ import annotations

import bpy
import latticed
from bpy.app.handlers import persistent

from . import blender_data
from .live_session import LiveSession

_TICK_SECONDS = 0.02

_session = None
_scene = ""  # name of the scene that it belongs to
_failure = ""  # why the last one ended, for the panel
_shown = ""  # the status that the panel shows
_dirty = set()  # of "mesh", "lattice", "view": what is to be read again
_grid = None  # the lattice as it was read last
_newest = None  # the surface that the result shows


def _settings():
    """None where the scene is gone."""
    scene = bpy.data.scenes.get(_scene)
    return scene.latticed if scene is not None else None


def status():
    """In words."""
    return _session.status if _session is not None else _failure or "Not connected"


def connected():
    return _session is not None


def view(settings):
    return latticed.View(
        segments=settings.segments,
        normals=settings.normals.lower(),
        encoding="quantised",  # the finest grid, for which no decoder is needed
        position_bits=16,
        normal_bits=12,
    )


def connect(scene, source, lattice):
    """ValueError, in words, for objects that cannot be shown."""
    global _session, _scene, _failure, _grid, _newest
    disconnect()
    settings = scene.latticed
    mesh, _grid = blender_data.read_mesh(source), blender_data.read_lattice(lattice, source)
    settings.source, settings.lattice = source, lattice
    if settings.result is None or settings.result.parent != source:
        settings.result = blender_data.make_result(source)
    _session = LiveSession(settings.address, mesh, _grid, view(settings), settings.token)
    _scene, _failure, _newest = scene.name, "", None
    _dirty.clear()
    if not bpy.app.timers.is_registered(tick):
        bpy.app.timers.register(tick, persistent=True)


def disconnect(reason=""):
    """The result stays as it is."""
    global _session, _failure
    if _session is not None:
        _session.close()
    _session, _failure = None, reason


def touch(what):
    """Something is to be read again at the next tick."""
    _dirty.add(what)


def tick():
    """Runs every few milliseconds while there is a session; returns when to run again."""
    global _newest
    if _session is None:
        _show_status()
        return None
    settings = _settings()
    gone = _what_is_gone(settings)
    if gone:
        disconnect(f"Disconnected: the {gone} is gone")
    elif not _session.running:
        disconnect(_session.status)
    else:
        try:
            _send(settings)
        except ValueError as error:
            disconnect(str(error))
    if _session is not None:
        surface = _session.take()
        if surface is not None:
            _newest = surface
            blender_data.write_surface(settings.result, surface)
    _show_status()
    return _TICK_SECONDS


def _what_is_gone(settings):
    """Objects that were deleted still stand in the settings, but in no scene."""
    if settings is None:
        return "scene"
    for what, thing in (
        ("mesh", settings.source),
        ("lattice", settings.lattice),
        ("result", settings.result),
    ):
        if thing is None or not thing.users_scene:
            return what
    return ""


def _send(settings):
    global _grid
    if not _dirty:
        return
    change = {}
    if "mesh" in _dirty:
        change["mesh"] = blender_data.read_mesh(settings.source)
    if "lattice" in _dirty:
        _grid = change["grid"] = blender_data.read_lattice(settings.lattice, settings.source, _grid)
    if "view" in _dirty:
        change["view"] = view(settings)
    _dirty.clear()
    _session.change(**change)


def _show_status():
    global _shown
    if _shown == status():
        return
    _shown = status()
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


@persistent
def on_depsgraph_update(scene, depsgraph):
    if _session is None:
        return
    settings = _settings()
    if _what_is_gone(settings):
        return
    for update in depsgraph.updates:
        changed = update.id.original
        if changed in (settings.lattice, settings.lattice.data):
            touch("lattice")
        elif changed == settings.source and update.is_updated_transform:
            touch("lattice")  # seen from the mesh it has moved
        elif changed == settings.source.data and update.is_updated_geometry:
            touch("mesh")


@persistent
def on_frame_change(*_):
    """Which tells of no single objects."""
    touch("lattice")


@persistent
def on_undo(*_):
    """Undo brings back an older result, and maybe an older lattice and mesh."""
    if _session is None:
        return
    _dirty.update(("mesh", "lattice", "view"))
    settings = _settings()
    if _newest is not None and not _what_is_gone(settings):
        blender_data.write_surface(settings.result, _newest)


@persistent
def on_load(*_):
    disconnect()


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
    disconnect()
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).remove(handler)
    if bpy.app.timers.is_registered(tick):
        bpy.app.timers.unregister(tick)
