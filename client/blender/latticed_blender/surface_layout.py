# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""What a surface takes over from its mesh. It does not use Blender."""
from __future__ import annotations

import functools
import uuid
from typing import Optional

import numpy as np
import numpy.typing as npt
from latticed import Provenance, Update

from .source_mesh import SourceMesh
from .welding import Welding, weld


class SurfaceLayout:
    """All of a surface that stays while its points move. Immutable.

    id         no other layout has it
    triangles  (triangles, 3): indices of the surface's points
    uvs        (points, 2): texture coordinates, interpolated in the mesh's triangles; None: the mesh has none
    uv_name    the name of their layer
    materials  (triangles,): index in the mesh's list of materials
    smooth     (triangles,): whether Blender shades the triangle smooth
    """

    def __init__(self, mesh: SourceMesh, provenance: Provenance, update: Update) -> None:
        """`update` is one of the surface's updates. With a tolerance, it is the layout of those with its patterns."""
        self.id = uuid.uuid4().hex
        self.patterns = update.patterns
        self._mesh, self._provenance = mesh, provenance
        self.triangles = update.triangles
        self.uv_name = mesh.uv_name
        self.uvs: Optional[npt.NDArray[np.float32]] = None
        if mesh.uvs is not None:
            uvs = provenance.interpolate(mesh.uvs, update.patterns)
            self.uvs = uvs.reshape(-1, 2).astype(np.float32)
        faces = np.repeat(provenance.faces, [len(pattern.triangles) for pattern in update.patterns])
        self.materials = np.zeros(len(faces), np.int32) if mesh.materials is None else mesh.materials[faces]
        self.smooth = np.ones(len(faces), bool) if mesh.smooth is None else mesh.smooth[faces]

    @functools.cached_property
    def welding(self) -> Welding:
        return weld(self._mesh, self._provenance, self.patterns)
