# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""A thread beside Blender's own, which talks to the server. It does not use Blender.

It sends only the newest state of the lattice, and keeps only the newest surface.
"""
from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Optional

import grpc
import latticed
import numpy as np
import numpy.typing as npt

from .lattice_map import BlenderLattice, LatticeMap
from .source_mesh import SourceMesh
from .surface_layout import SurfaceLayout

_LOOK_SECONDS = 0.02  # between two polls of the stream while there is nothing to send
_EDIT_SECONDS = 30.0  # the longest wait for the update that holds an edit


@dataclass(frozen=True)
class Surface:
    """A surface from the server: positions and normals (points, 3). normals is None if the view has none.
    layout is the same object as long as only points move."""

    positions: npt.NDArray[np.float32]
    normals: Optional[npt.NDArray[np.float32]]
    layout: SurfaceLayout
    revision: int


def in_words(error: Exception, address: str) -> str:
    """The error as a text for the panel."""
    if isinstance(error, latticed.LatticedError):
        if error.code == grpc.StatusCode.UNAVAILABLE:
            return f"No server answers at {address}"
        return f"The server refused: {error.message}"
    return f"{type(error).__name__}: {error}"


class LiveSession:
    """A session, from construction to close. Any thread may call it.

    running  False once it has failed or was closed
    status   its state, or why it ended, as text
    """

    def __init__(
        self, address: str, mesh: SourceMesh, grid: BlenderLattice, view: latticed.View, token: str = ""
    ) -> None:
        self.address = address
        self._token = token or None
        self._found = False  # used by the thread alone
        self._changed = threading.Condition()  # guards all that follow
        self._mesh = mesh
        self._grid: BlenderLattice = grid
        self._view = view
        self._edits = 0  # how often the grid was changed
        self._closing = False
        self._surface: Optional[Surface] = None
        self.status = f"Connecting to {address}"
        self.running = True
        self._thread = threading.Thread(target=self._run, name="latticed for Blender", daemon=True)
        self._thread.start()

    def change(
        self,
        mesh: Optional[SourceMesh] = None,
        grid: Optional[BlenderLattice] = None,
        view: Optional[latticed.View] = None,
    ) -> None:
        """Sets the mesh, lattice and view to show; None leaves one as it is."""
        with self._changed:
            if mesh is not None and not mesh.same(self._mesh):
                self._mesh = mesh
            if grid is not None and not grid.same(self._grid):
                self._grid, self._edits = grid, self._edits + 1
            self._view = view or self._view
            self._changed.notify_all()

    def take(self) -> Optional[Surface]:
        """Returns the newest surface, or None if an earlier call returned it."""
        with self._changed:
            surface, self._surface = self._surface, None
            return surface

    def close(self) -> None:
        """Ends the session, which deletes its scene on the server. Waits for that at most a second."""
        with self._changed:
            self._closing = True
            self._changed.notify_all()
        self._thread.join(timeout=1.0)

    def _run(self) -> None:
        status = "Disconnected"
        try:
            with latticed.connect(self.address, token=self._token) as client:
                while not self._closing:
                    self._show_one_structure(client)
        except Exception as error:  # the panel shows any error
            status = in_words(error, self.address)
        with self._changed:
            self.status, self.running = status, False

    def _find_server(self) -> None:
        """Raises at once if no server answers. One that has answered is waited for when it is gone."""
        if not self._found:
            with latticed.connect(self.address, token=self._token, retry_for=0) as client:
                client.server_info()
            self._found = True

    def _show_one_structure(self, client: latticed.Client) -> None:
        """Returns when the session is closed, or when the mesh or the lattice's structure has changed."""
        with self._changed:
            mesh, grid, view, shown = self._mesh, self._grid, self._view, self._edits
        mapping = LatticeMap(grid, mesh.positions)
        self._find_server()
        self._say("Uploading the mesh")
        uploaded = client.upload_arrays(
            mesh.positions,
            mesh.faces,
            weights=mesh.weights,
            name="Blender",
            up_axis="z",
            progress=False,
        )
        with client.create_scene(
            uploaded,
            mapping.lattice(grid),
            crease_angle=mesh.crease_angle,
            weights=None if mesh.weights is None else "mesh",
            labels={"client": "blender"},
            delete_on_exit=True,
        ) as scene, scene.deform(view) as stream:
            layouts = _Layouts(scene, mesh)
            while True:
                self._publish(self._newest(stream), layouts)
                with self._changed:
                    self._changed.wait_for(lambda: self._closing or self._edits != shown, _LOOK_SECONDS)
                    if self._closing or self._mesh is not mesh or not self._grid.same_structure(grid):
                        return
                    edited, shown = self._edits != shown, self._edits
                    wanted_grid, wanted_view = self._grid, self._view
                if wanted_view != view:
                    view = wanted_view
                    stream.set_view(view)
                if edited:
                    replaced = latticed.edits.replace(mapping.control_points(wanted_grid))
                    edit = stream.apply([replaced, latticed.edits.set_strength(wanted_grid.strength)])
                    self._publish(stream.wait(edit, timeout=_EDIT_SECONDS), layouts)

    @staticmethod
    def _newest(stream: latticed.DeformStream) -> Optional[latticed.Update]:
        """Returns the newest update, or None if none has come. Raises the stream's error."""
        try:
            return stream.next_update(timeout=0)
        except TimeoutError:
            return None

    def _say(self, status: str) -> None:
        with self._changed:
            self.status = status

    def _publish(self, update: Optional[latticed.Update], layouts: _Layouts) -> None:
        """Decodes the update on this thread, so that Blender's thread only copies."""
        if update is None:
            return
        normals = update.normals
        surface = Surface(
            update.points.reshape(-1, 3).astype(np.float32),
            None if normals is None else normals.reshape(-1, 3),
            layouts.of(update),
            update.revision,
        )
        if normals is None:
            surface.layout.welding  # made here, since Blender will need it
        triangles = len(surface.layout.triangles)
        with self._changed:
            self._surface = surface
            self.status = f"Connected: {update.topology.patches:,} patches, {triangles:,} triangles"
            if update.certified_error > 0:
                self.status += f", within {update.certified_error:.3g}"


class _Layouts:
    """The layouts of one scene's updates. Asks the server only if the topology has changed. With a tolerance an
    edit may change the patterns of patches, and so the layout."""

    def __init__(self, scene: latticed.Scene, mesh: SourceMesh) -> None:
        self._scene, self._mesh = scene, mesh
        self._provenance: Optional[latticed.Provenance] = None
        self._layout: Optional[SurfaceLayout] = None

    def of(self, update: latticed.Update) -> SurfaceLayout:
        if self._provenance is None or self._provenance.topology.id != update.topology.id:
            self._provenance, self._layout = self._scene.provenance(update), None
        if self._layout is None or self._layout.patterns != update.patterns:
            self._layout = SurfaceLayout(self._mesh, self._provenance, update)
        return self._layout
