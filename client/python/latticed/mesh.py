# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""A mesh on the server."""
from __future__ import annotations

import io
import os
from pathlib import Path
from typing import Any, Dict, Union

import numpy as np
import numpy.typing as npt

from latticed import transfers
from latticed.connection import Connection
from latticed.progress_bar import Progress, progress_function
from latticed.v1 import mesh_pb2


class Mesh:
    """A mesh on the server. Its id is the SHA-256 of its bytes; the same bytes sent twice are one mesh."""

    def __init__(self, connection: Connection, info: Any) -> None:
        self._connection = connection
        self.info = info  # latticed.v1.Mesh, described in mesh.proto

    def __repr__(self) -> str:
        return f"<Mesh {self.name or self.id[:8]}: {self.vertices} vertices, {self.faces} faces>"

    @property
    def id(self) -> str:
        return str(self.info.id)

    @property
    def name(self) -> str:
        return str(self.info.name)

    @property
    def vertices(self) -> int:
        return int(self.info.vertices)

    @property
    def faces(self) -> int:
        return int(self.info.faces)

    @property
    def bounds(self) -> npt.NDArray[np.float64]:
        """Smallest and largest x, y, z: shape (2, 3), world units."""
        low, high = self.info.bounds.min, self.info.bounds.max
        return np.array([[low.x, low.y, low.z], [high.x, high.y, high.z]])

    @property
    def labels(self) -> Dict[str, str]:
        return dict(self.info.labels)

    def download(self, path: Union[str, "os.PathLike[str]"], progress: Progress = None) -> None:
        """Writes the uploaded bytes to a file, as a whole or not at all. Uploaded arrays come in the format
        MESH_FORMAT_RAW. progress: as in Client.upload."""
        show = progress_function(progress, f"download {Path(path).name}")
        with transfers.whole_file(path) as part, open(part, "wb") as file:
            transfers.download(self._connection, self.id, file, show)

    def download_bytes(self) -> bytes:
        """Like download, but returns the bytes."""
        file = io.BytesIO()
        transfers.download(self._connection, self.id, file, lambda done, total: None)
        return file.getvalue()

    def delete(self, force: bool = False) -> None:
        """Deletes the mesh. If scenes use it, `force` deletes them too; without it, raises MESH_IN_USE."""
        request = mesh_pb2.DeleteMeshRequest(mesh=self.id, force=force)
        self._connection.call_once(self._connection.meshes.DeleteMesh, request)
