# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The client of one server."""
from __future__ import annotations

import mmap
import os
import uuid
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt
from google.protobuf import duration_pb2

from latticed.backup import BackedUp, Restored, read_backup, write_backup
from latticed.choices import choose
from latticed.connection import Connection, Pem
from latticed.encoding_choice import EncodingChoice
from latticed.lattice import Lattice
from latticed.mesh import Mesh
from latticed.mesh_arrays import Faces, raw_mesh
from latticed.outside import Outside
from latticed.progress_bar import Progress, progress_function
from latticed.scene import Scene
from latticed.upload import SUFFIXES, upload
from latticed.v1 import lattice_pb2, mesh_pb2, scene_pb2, server_pb2
from latticed.view import View

_UP_AXES: Dict[str, Any] = {"": 0, "x": mesh_pb2.UP_AXIS_X, "y": mesh_pb2.UP_AXIS_Y, "z": mesh_pb2.UP_AXIS_Z}
_PIPELINES: Dict[str, Any] = {
    "": scene_pb2.PIPELINE_UNSPECIFIED,
    "fused": scene_pb2.PIPELINE_FUSED,
    "gemm": scene_pb2.PIPELINE_GEMM,
    "gemm12": scene_pb2.PIPELINE_GEMM12,
    "control_net": scene_pb2.PIPELINE_CONTROL_NET,
}

# A request holds at most 1 MiB.
_MOST_WEIGHTS = 250_000


class Client:
    """Meshes and scenes of a server; made by latticed.connect. Any number of threads may use it.

    Errors: LatticedError, with reason, field and request id; UNAVAILABLE without a server.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends all calls and streams."""
        self._connection.close()

    def server_info(self) -> Any:
        """Version, devices, encodings and limits: latticed.v1.ServerInfo, described in server.proto."""
        return self._connection.call(self._connection.server.GetServerInfo, server_pb2.GetServerInfoRequest())

    def encoding_choice(self) -> EncodingChoice:
        """The encoding, and why, of streams whose view names none and whose scene's default is Draco: "meshopt" if the line to
        the server is fast enough, else "draco". Measured once."""
        return self._connection.encoding_choice()

    def upload(
        self,
        path: Union[str, "os.PathLike[str]"],
        *,
        name: str = "",
        up_axis: str = "",
        meters_per_unit: float = 0.0,
        labels: Optional[Dict[str, str]] = None,
        progress: Progress = None,
    ) -> Mesh:
        """Uploads a file: .obj, .ply, .stl, .glb or .drc. Sends nothing if the server has it already.

        name             for people; empty: the file's name
        up_axis          "x", "y" or "z"; exports keep it, and meters_per_unit
        progress         True: a bar on standard error; False: none; None: a bar if that is a terminal; or a
                         function that is called with the bytes done and in all
        """
        suffix = Path(path).suffix.lower()
        if suffix not in SUFFIXES:
            raise ValueError(f"{path}: the extension must be one of {', '.join(SUFFIXES)}")
        header = _header(name or Path(path).name, SUFFIXES[suffix], up_axis, meters_per_unit, labels)
        show = progress_function(progress, f"upload {header.name}")
        with open(path, "rb") as file:
            if os.fstat(file.fileno()).st_size == 0:
                raise ValueError(f"{path} is empty")
            with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data, memoryview(data) as view:
                return Mesh(self._connection, upload(self._connection, header, view, show))

    def upload_arrays(
        self,
        positions: npt.ArrayLike,
        faces: Faces,
        *,
        normals: Optional[npt.ArrayLike] = None,
        uvs: Optional[npt.ArrayLike] = None,
        face_groups: Optional[npt.ArrayLike] = None,
        group_names: Sequence[str] = (),
        weights: Optional[npt.ArrayLike] = None,
        name: str = "",
        up_axis: str = "",
        meters_per_unit: float = 0.0,
        labels: Optional[Dict[str, str]] = None,
        progress: Progress = None,
    ) -> Mesh:
        """Uploads arrays.

        positions     (vertices, 3); sent as float32 if they are float32, else as float64
        faces         (faces, 3 or more) vertex indices, or a list of sequences of any length
        normals, uvs  (vertices, 3 or 2), or one per corner of each face: (corners, …) or (faces, k, …)
        face_groups   (faces,): indices into group_names, which may be materials
        weights       (vertices,): for scenes that are created with weights="mesh"
        The rest as in upload. ValueError for shapes that do not fit together.
        """
        layout, data = raw_mesh(positions, faces, normals, uvs, face_groups, group_names, weights)
        header = _header(name, mesh_pb2.MESH_FORMAT_RAW, up_axis, meters_per_unit, labels)
        header.raw_layout.CopyFrom(layout)
        show = progress_function(progress, f"upload {name or 'mesh'}")
        return Mesh(self._connection, upload(self._connection, header, data, show))

    def mesh(self, mesh_id: str) -> Mesh:
        """The mesh with this id; LatticedError NOT_FOUND if there is none."""
        request = mesh_pb2.GetMeshRequest(mesh=mesh_id)
        return Mesh(self._connection, self._connection.call(self._connection.meshes.GetMesh, request))

    def meshes(self, filter: str = "") -> List[Mesh]:
        """All meshes, or those whose labels match a filter: "key=value" or "key", joined by commas."""
        request = mesh_pb2.ListMeshesRequest(filter=filter)
        pages = self._pages(self._connection.meshes.ListMeshes, request)
        return [Mesh(self._connection, info) for page in pages for info in page.meshes]

    def create_scene(
        self,
        mesh: Union[Mesh, str],
        lattice: Union[None, Lattice, Sequence[Lattice]] = None,
        *,
        size: Optional[Tuple[int, int, int]] = None,
        degree: Optional[Tuple[int, int, int]] = None,
        padding: Optional[float] = None,
        outside: Optional[Outside] = None,
        view: Optional[View] = None,
        up_axis: str = "",
        meters_per_unit: float = 0,
        crease_angle: Optional[float] = None,
        strength: Optional[float] = None,
        weights: Union[None, str, npt.ArrayLike] = None,
        name: str = "",
        scene_id: str = "",
        labels: Optional[Dict[str, str]] = None,
        idle_ttl: Optional[float] = None,
        pipeline: str = "",
        fold_watch: bool = False,
        delete_on_exit: bool = False,
    ) -> Scene:
        """Creates a scene of a mesh and a lattice, or several lattices.

        lattice          several: what they move the mesh adds up (Scene.edits_of). Where their frames are turned against each
                         other, what does not take that raises LatticedError, reason TURNED_LATTICES.
                         None: an identity lattice around the mesh, made from the next four
        size, degree     control points and degree of u, v, w; by default 4, 4, 4 and 2, 2, 2
        padding          margin on every side, as a share of the longest edge of the mesh's bounds; 0.05
        outside          what becomes of points outside it, with widths: of point sets, for the mesh has none there
        view             the view of watchers that name none
        up_axis          "x", "y" or "z"; clients and exports get it, and meters_per_unit. By default both
                         are those of the mesh
        crease_angle     smooth normals are computed, and split where faces meet at more degrees, 0 to 180;
                         None: those of the mesh, split at 30 degrees where it has none
        strength         how much of the deformation the scene takes, 0 to 1, of each of several lattices; None: those of
                         the lattices, or 1. Edits set those that differ from the first lattice's
        weights          how much of the deformation each vertex takes, 0 to 1: an array with one for each
                         vertex, or "mesh" for those that came with the mesh (PLY weight, GLB _WEIGHT,
                         upload_arrays); None: all. Those of more than 250,000 vertices come with the mesh
        name             for people, and of exported files; empty: the mesh's, without its ending
        scene_id         [a-z0-9-]{1,63}; empty: a random one. Repeating a request returns the same scene
        idle_ttl         seconds that the scene lives unwatched and unedited; None: the server's default
        pipeline         how vertices are computed, for comparisons: "fused", "gemm", "gemm12" or
                         "control_net"; empty: "fused"
        fold_watch       EditResult.folds says after every edit where the deformation folds
        delete_on_exit   the end of the scene's with block deletes it
        """
        source = lattice_pb2.LatticeSource()
        given = [lattice] if isinstance(lattice, Lattice) else lattice
        if given is not None:
            if not (size is None and degree is None and padding is None and outside is None):
                raise ValueError("size, degree, padding and outside are of a lattice that the server makes")
            sources = [lattice_pb2.LatticeSource(lattice=one.to_proto()) for one in given]
        else:
            sources = [source]
            source.fit.SetInParent()
            for field, axes, numbers in (
                ("size", source.fit.size, size),
                ("degree", source.fit.degree, degree),
            ):
                if numbers is None:
                    continue
                if np.shape(numbers) != (3,):
                    raise ValueError(f"{field} is three numbers, of u, v and w, not {numbers!r}")
                axes.u, axes.v, axes.w = numbers
            if padding is not None:
                source.fit.padding = padding
            if outside is not None:
                source.fit.outside.CopyFrom(outside.to_proto())
        request = scene_pb2.CreateSceneRequest(
            scene_id=scene_id or uuid.uuid4().hex,
            mesh=mesh.id if isinstance(mesh, Mesh) else mesh,
            lattices=sources,
            labels=labels or {},
            units=_units(up_axis, meters_per_unit),
            crease_angle=crease_angle,
            name=name,
            fold_watch=fold_watch,
        )
        if strength is not None:
            request.strength = strength
        elif given and given[0].strength != 1:
            request.strength = given[0].strength
        if isinstance(weights, str):
            if weights != "mesh":
                raise ValueError(f'weights is an array or "mesh", not {weights!r}')
            request.weights.from_mesh = True
        elif weights is not None:
            values = np.ascontiguousarray(weights, "<f4")
            if values.size > _MOST_WEIGHTS:
                raise ValueError(
                    f'{values.size} weights are too many for a request: use upload_arrays and weights="mesh"'
                )
            request.weights.values = values.tobytes()
        if view is not None:
            request.default_view.CopyFrom(view.to_proto())
        request.diagnostics.pipeline = choose("pipeline", pipeline, _PIPELINES)
        if idle_ttl is not None:
            request.idle_ttl.CopyFrom(_duration(idle_ttl))
        info = self._connection.call(self._connection.scenes.CreateScene, request, request.scene_id)
        scene = Scene(self._connection, info, delete_on_exit)
        strengths = [one.strength for one in given or []]
        others = [k for k, each in enumerate(strengths) if each != strengths[0]]
        if strength is None and others:
            try:
                for k in others:
                    scene.edits_of(k).set_strength(strengths[k])
                scene.refresh()
            except BaseException:
                scene.delete()  # nobody else knows of it
                raise
        return scene

    def scene(self, scene_id: str) -> Scene:
        """The scene with this id; LatticedError NOT_FOUND if there is none."""
        request = scene_pb2.GetSceneRequest(scene=scene_id)
        return Scene(
            self._connection, self._connection.call(self._connection.scenes.GetScene, request, scene_id)
        )

    def scenes(self, filter: str = "") -> List[Scene]:
        """All scenes, oldest first, or those whose labels match a filter as in meshes."""
        request = scene_pb2.ListScenesRequest(filter=filter)
        pages = self._pages(self._connection.scenes.ListScenes, request)
        return [Scene(self._connection, info) for page in pages for info in page.scenes]

    def backup(
        self, path: Union[str, "os.PathLike[str]"], scenes: Sequence[Union[Scene, str]] = ()
    ) -> BackedUp:
        """Copies all meshes and scenes with their undo steps to a file, or these scenes and their meshes. Edits go on
        meanwhile. What is damaged on the server is left out, and told."""
        ids = [scene.id if isinstance(scene, Scene) else scene for scene in scenes]
        return write_backup(self._connection, path, ids)

    def restore(self, path: Union[str, "os.PathLike[str]"], *, skip_existing: bool = False) -> Restored:
        """Makes the meshes and scenes of a backup, which latticectl may have written.

        skip_existing    passes over scenes that are there; by default they end the restore, ALREADY_EXISTS

        LatticedError DATA_LOSS before anything is sent, if the file is not what was written. After another error what
        came before in the file is there."""
        return read_backup(self._connection, path, skip_existing)

    def _pages(self, method: Any, request: Any) -> List[Any]:
        pages = [self._connection.call(method, request)]
        while pages[-1].next_page_token:
            request.page_token = pages[-1].next_page_token
            pages.append(self._connection.call(method, request))
        return pages


def connect(
    address: Optional[str] = None,
    *,
    token: Optional[str] = None,
    tls: bool = False,
    tls_ca: Optional[Pem] = None,
    tls_cert: Optional[Pem] = None,
    tls_key: Optional[Pem] = None,
    retry_for: float = 30.0,
) -> Client:
    """Makes a client. Does not wait for the server: without one, the first call waits, and fails.

    address            host:port or unix:path; None: $LATTICED_SERVER, or else 127.0.0.1:50151
    token              bearer token; None: $LATTICED_TOKEN
    tls                TLS with the system's roots; implied by tls_ca and by tls_cert
    tls_ca             roots to trust: PEM, as bytes or as the path of a file, like the next two
    tls_cert, tls_key  a certificate of this client, and its key
    retry_for          seconds for which a call or stream tries to reach a server that does not answer; the logger
                       "latticed" says when it waits and when the server is back. 0: it tries once
    """
    address = address or os.environ.get("LATTICED_SERVER") or "127.0.0.1:50151"
    token = os.environ.get("LATTICED_TOKEN") if token is None else token
    return Client(Connection(address, token, tls, tls_ca, tls_cert, tls_key, retry_for))


def _header(
    name: str, format: Any, up_axis: str, meters_per_unit: float, labels: Optional[Dict[str, str]]
) -> mesh_pb2.MeshHeader:
    units = _units(up_axis, meters_per_unit)
    return mesh_pb2.MeshHeader(name=name, format=format, labels=labels or {}, units=units)


def _units(up_axis: str, meters_per_unit: float) -> mesh_pb2.MeshUnits:
    axis = choose("up_axis", up_axis, _UP_AXES)
    return mesh_pb2.MeshUnits(up_axis=axis, meters_per_unit=meters_per_unit)


def _duration(seconds: float) -> duration_pb2.Duration:
    duration = duration_pb2.Duration()
    duration.FromNanoseconds(round(seconds * 1e9))
    return duration
