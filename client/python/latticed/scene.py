# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""A scene: one mesh under one lattice or several, edited and watched."""
from __future__ import annotations

import io
import os
import threading
import uuid
from datetime import timedelta
from pathlib import Path
from typing import Any, Dict, List, Optional, Type, Union

import numpy.typing as npt

from latticed import edits, evaluation, transfers
from latticed.connection import Connection
from latticed.deform_stream import DeformStream
from latticed.choices import choose
from latticed.edit_calls import EditCalls
from latticed.edit_result import EditResult
from latticed.errors import LatticedError
from latticed.exported import Exported
from latticed.folds import FoldReport
from latticed.evaluation import Evaluation
from latticed.lattice import Lattice, vector
from latticed.measures import Constraints, Measured, measure
from latticed.patches.plan import PatchPlan
from latticed.points.calls import PointSetCalls
from latticed.progress_bar import Progress, ProgressFunction, progress_function
from latticed.provenance import Provenance
from latticed.share import ROLES, Share
from latticed.surface_point import SurfacePoint
from latticed.update import Update
from latticed.v1 import edit_pb2, fold_pb2, scene_pb2, share_pb2, surface_pb2
from latticed.view import View
from latticed.watch_stream import WatchStream

_DEFAULT_VIEW = View()


def _geometry(original: bool, welded: bool) -> surface_pb2.ExportGeometry:
    if original:
        return surface_pb2.EXPORT_GEOMETRY_ORIGINAL
    return surface_pb2.EXPORT_GEOMETRY_EXACT if welded else surface_pb2.EXPORT_GEOMETRY_PATCHES


class Scene(EditCalls[EditResult], PointSetCalls):
    """Made by Client.create_scene or scene. Every edit waits for its result; edits of deform() do not.

    As a context manager it deletes the scene at the end of the block, if create_scene had delete_on_exit.
    Any number of threads may use it. It is one editor, and sends one edit at a time.
    """

    def __init__(self, connection: Connection, info: Any, delete_on_exit: bool = False) -> None:
        self._connection = connection
        self._stub = connection.scenes
        self.info = info  # latticed.v1.Scene, described in scene.proto, as last received from the server
        self.editor_id = str(uuid.uuid4())  # names this object's edits to other watchers
        self._delete_on_exit = delete_on_exit
        self._one_edit_at_a_time = threading.Lock()
        self._sequence = 0
        self._structure_id = int(info.structure_id)

    def __repr__(self) -> str:
        if self.info.asleep:  # as a list has it
            return f"<Scene {self.id}: asleep>"
        return f"<Scene {self.id}: {self.patches} patches, revision {self.info.revision}>"

    @property
    def id(self) -> str:
        return str(self.info.id)

    @property
    def patches(self) -> int:
        return int((self.refresh() if self.info.asleep else self.info).patches)

    @property
    def labels(self) -> Dict[str, str]:
        return dict(self.info.labels)

    @property
    def default_view(self) -> View:
        """The view of watchers that name none, with every field filled in."""
        return View.from_proto(self.info.default_view)

    @property
    def encoding(self) -> str:
        """The encoding of updates whose view names none: the default view's, but "quantised" instead of Draco
        if no decoder is installed."""
        options = _DEFAULT_VIEW.for_watching(self.default_view)
        return View.from_proto(options).encoding or self.default_view.encoding

    def refresh(self) -> Any:
        """Asks the server for the newest info, for example the scene's revision."""
        self.info = self._connection.call(
            self._stub.GetScene, scene_pb2.GetSceneRequest(scene=self.id), self.id
        )
        return self.info

    def lattice(self, number: int = 0) -> Lattice:
        """The lattice at the newest revision, of several that with this number. Later edits refer to its structure."""
        return Lattice.from_state(self._lattice_state(number))

    def add_lattice(self, lattice: Lattice) -> EditResult:
        """Adds a lattice: what it moves the mesh adds to what the others do. It gets the lowest number that no lattice
        has; edits_of(number) has its edits, and undo there takes it away again. A strength below 1 is a second edit.
        """
        info = self.refresh()
        taken = {lattice.index for lattice in info.lattices}
        number = min(set(range(len(taken) + 1)) - taken)
        batch = edit_pb2.EditBatch(
            lattice=number,
            structure_id=info.structure_id,
            edits=[edits.replace_lattice(lattice, False)],
            refuse_folds=self.refuse_folds,
        )
        result = self._apply(batch)
        return result if lattice.strength == 1 else self.edits_of(number).set_strength(lattice.strength)

    def remove_lattice(self, number: int) -> EditResult:
        """Takes a lattice of several away, with what it moves. The others keep their numbers. edits_of(number).undo()
        gives it back, with its control points, constraints and steps of undo. The last one stays: LAST_LATTICE.
        """
        batch = edit_pb2.EditBatch(
            lattice=number,
            structure_id=self.refresh().structure_id,
            edits=[edits.remove_lattice()],
            refuse_folds=self.refuse_folds,
        )
        return self._apply(batch)

    def get_update(self, view: View = _DEFAULT_VIEW, min_revision: int = 0) -> Update:
        """The whole surface at the newest revision. Waits until the revision is at least min_revision."""
        options = view.for_watching(self.default_view)
        request = scene_pb2.GetUpdateRequest(scene=self.id, min_revision=min_revision, view=options)
        return transfers.get_update(self._connection, request)

    def provenance(self, update: Update) -> Provenance:
        """Where the patches of an update come from, for example to carry texture coordinates over."""
        return transfers.get_provenance(self._connection, self.id, update.topology)

    def patch_plan(self, topology_id: str, normals: str = "") -> PatchPlan:
        """What PatchEvaluator needs once to make the points of a view with the encoding "patches".

        topology_id  Update.topology.id of such a view. A plan depends on it and on normals alone
        normals      "none", "facet" or "smooth"; empty: as in the scene's default view
        """
        return transfers.get_patch_plan(self._connection, self.id, topology_id, normals)

    def deform(
        self, view: View = _DEFAULT_VIEW, editor_id: str = "", max_unacked_updates: Optional[int] = None
    ) -> DeformStream:
        """Opens a stream of edits and updates, and waits for its first update.

        editor_id            the editor of an earlier stream, to continue as that editor; empty: a new one
        max_unacked_updates  most updates that the server begins before this stream acknowledges them, up to
                             100; distant servers need more. 0: no limit; None: 2
        """
        watch = scene_pb2.WatchRequest(
            scene=self.id,
            editor_id=editor_id or str(uuid.uuid4()),
            max_unacked_updates=max_unacked_updates,
        )
        stream = DeformStream(self._connection, watch, view, self.default_view)
        stream._start()
        return stream

    def watch(
        self, view: View = _DEFAULT_VIEW, editor_id: str = "", max_unacked_updates: Optional[int] = None
    ) -> WatchStream:
        """Opens a stream of updates, without edits, and waits for its first update.

        editor_id: the editor whose presence show() sends; empty: show() fails.
        max_unacked_updates: as in deform.
        """
        watch = scene_pb2.WatchRequest(
            scene=self.id, editor_id=editor_id, max_unacked_updates=max_unacked_updates
        )
        stream = WatchStream(self._connection, watch, view, self.default_view)
        stream._start()
        return stream

    def evaluate(self, points: npt.ArrayLike) -> Evaluation:
        """The deformation, in double precision, at points of the undeformed world, (n, 3)."""
        return evaluation.evaluate_world(self._connection, self.id, points)

    def evaluate_surface(
        self, faces: npt.ArrayLike, corners: npt.ArrayLike, barycentrics: npt.ArrayLike
    ) -> Evaluation:
        """The deformation, in double precision, at points of the surface, by their place in the source
        mesh: face (n,), three corners of it, numbered as in Provenance, and barycentrics, (n, 3) each."""
        return evaluation.evaluate_surface(self._connection, self.id, faces, corners, barycentrics)

    def measure(
        self,
        *measures: str,
        with_gradient: bool = False,
        area_tolerance: Optional[float] = None,
        lattice: int = 0,
    ) -> Measured:
        """Measures the exact deformed surface: any of "volume", "area", "centroid" and "bounds".

        with_gradient: derivatives by all control points of a lattice, too.
        area_tolerance: the largest error of the area, as a fraction of it; 1e-6 if None.
        Volume and centroid need a closed surface; else LatticedError, reason OPEN_SURFACE.
        """
        return measure(self._connection, self.id, measures, with_gradient, area_tolerance, lattice)

    def constraints(self, lattice: int = 0) -> Constraints:
        """What edits of a lattice keep, at the newest revision. See set_constraints."""
        request = scene_pb2.GetLatticeRequest(scene=self.id, lattice=lattice)
        return Constraints.from_proto(
            self._connection.call(self._stub.GetLattice, request, self.id).constraints
        )

    def pick(self, origin: npt.ArrayLike, direction: npt.ArrayLike) -> Optional[SurfacePoint]:
        """The first point of the deformed surface on a world ray, for drag; None if the ray misses it."""
        ray = surface_pb2.Ray(origin=vector(origin), direction=vector(direction))
        request = surface_pb2.PickRequest(scene=self.id, ray=ray)
        try:
            return SurfacePoint.from_proto(self._connection.call(self._stub.Pick, request, self.id))
        except LatticedError as error:
            if error.reason == "NOTHING_HIT":
                return None
            raise

    def certify_folds(self, volume: bool = False) -> FoldReport:
        """Proves that the deformation folds nowhere, or says where, at the newest revision.

        volume: looks in the whole frame, and in those of turned lattices, not only in the bounds of the surface
            in each knot box.
        """
        scope = fold_pb2.FOLD_SCOPE_VOLUME if volume else fold_pb2.FOLD_SCOPE_SURFACE
        request = fold_pb2.CertifyFoldsRequest(scene=self.id, scope=scope)
        return FoldReport.from_proto(self._connection.call(self._stub.CertifyFolds, request, self.id))

    def export(
        self,
        path: Union[str, "os.PathLike[str]"],
        format: str = "",
        view: View = _DEFAULT_VIEW,
        revision: int = 0,
        progress: Progress = None,
        original: bool = False,
        welded: bool = True,
    ) -> Exported:
        """Writes the deformed surface to a file, as a whole or not at all. Returns what the server says about it.

        format    "ply", "obj", "stl", "glb", "usda", "drc" or "nets" (Bézier control points); empty: by the suffix
        view      only its segments, tolerance and normals are used, and its bits for drc
        original  writes the uploaded vertices and faces, moved by the deformation, in place of the exact surface
        welded    patches of the exact surface share the vertices between them; if not, each has its own
        revision  fails with REVISION_CHANGED unless this is the newest revision; 0: exports the newest
        """
        show = progress_function(progress, f"export {Path(path).name}")
        wanted = format or Path(path).suffix[1:].lower()
        with transfers.whole_file(path) as part:
            return self._export(
                lambda: open(part, "wb"), wanted, view, revision, _geometry(original, welded), show
            )

    def export_bytes(
        self,
        format: str,
        view: View = _DEFAULT_VIEW,
        revision: int = 0,
        original: bool = False,
        welded: bool = True,
    ) -> bytes:
        """Like export, but returns the bytes."""

        class Kept(io.BytesIO):
            def __exit__(self, *error: Any) -> None:
                """Does not close it, since its bytes are read after the block."""

        files = []

        def open_file() -> Kept:
            files.append(Kept())
            return files[-1]

        geometry = _geometry(original, welded)
        self._export(open_file, format, view, revision, geometry, lambda done, total: None)
        return files[-1].getvalue()

    def _export(
        self,
        open_file: Any,
        format: str,
        view: View,
        revision: int,
        geometry: surface_pb2.ExportGeometry,
        progress: ProgressFunction,
    ) -> Exported:
        number = choose("a format", format, transfers.EXPORT_FORMATS)
        request = surface_pb2.ExportRequest(
            scene=self.id, revision=revision, format=number, view=view.to_proto(), geometry=geometry
        )
        return transfers.export(self._connection, request, open_file, progress)

    def share(self, role: str = "read", ttl: timedelta = timedelta(days=7)) -> Share:
        """Shares the scene with whoever has the token of the result: latticed.connect(address, token=share.token).

        role: "read" to watch, evaluate and export, or "edit". ttl: a second to 366 days. Needs the role edit.
        """
        request = share_pb2.CreateShareRequest(scene=self.id, role=choose("a role", role, ROLES))
        request.ttl.FromTimedelta(ttl)
        made = self._connection.call_once(self._connection.shares.CreateShare, request, self.id)
        return Share.from_proto(made.share, made.token)

    def shares(self) -> List[Share]:
        """The shares of the scene, oldest first, without their tokens."""
        request = share_pb2.ListSharesRequest(scene=self.id)
        listed = self._connection.call(self._connection.shares.ListShares, request, self.id)
        return [Share.from_proto(share) for share in listed.shares]

    def revoke(self, share: Share) -> None:
        """Ends a share, and the streams of those who came by it."""
        request = share_pb2.RevokeShareRequest(scene=self.id, share_id=share.id)
        self._connection.call_once(self._connection.shares.RevokeShare, request, self.id)

    def delete(self) -> None:
        """Deletes the scene. Its streams end with NOT_FOUND."""
        request = scene_pb2.DeleteSceneRequest(scene=self.id)
        self._connection.call_once(self._stub.DeleteScene, request, self.id)

    def __enter__(self) -> Scene:
        return self

    def __exit__(self, kind: Type[BaseException] | None, *error: object) -> None:
        if not self._delete_on_exit:
            return
        try:
            self.delete()
        except LatticedError as failure:
            if kind is None and failure.reason != "NOT_FOUND":  # an exception of the block comes first
                raise

    def _lattice_state(self, number: int) -> Any:
        request = scene_pb2.GetLatticeRequest(scene=self.id, lattice=number)
        state = self._connection.call(self._stub.GetLattice, request, self.id)
        with self._one_edit_at_a_time:
            self._structure_id = state.structure_id
        return state

    def _apply(self, batch: edit_pb2.EditBatch) -> EditResult:
        with self._one_edit_at_a_time:
            self._sequence += 1
            batch.scene, batch.editor_id, batch.sequence = self.id, self.editor_id, self._sequence
            if batch.structure_id == 0:
                if self._structure_id == 0:  # of a scene that was asleep
                    self._structure_id = int(self.refresh().structure_id)
                batch.structure_id = self._structure_id
            result = self._connection.call(self._stub.ApplyEdits, batch, self.id)
            self._structure_id = result.structure_id
        return EditResult.from_proto(result)
