# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Where patches come from in the source mesh. It serves to carry colours, texture coordinates and materials
over to the deformed surface."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, List, Optional, Sequence

import numpy as np
import numpy.typing as npt

from latticed.errors import LatticedError
from latticed.pattern import PatchPattern
from latticed.topology import Topology


@dataclass(frozen=True)
class Provenance:
    """The source of every patch, in the order of update.points.

    topology         the topology that has these patches
    faces            (patches,): face of the source mesh
    corners          (patches, 3): corners of the source triangle that holds the patch. A corner's number
                     is the number of corners of all earlier faces plus its place in its face
    barycentrics     (patches, 3, 3): of the patch's corners 0, 1, 2 in that triangle
    on_lattice_face  (patches,): whether it ends on a face of the frame and the surface goes on outside
    """

    topology: Topology
    faces: npt.NDArray[np.int64]
    corners: npt.NDArray[np.int64]
    barycentrics: npt.NDArray[np.float64]
    on_lattice_face: npt.NDArray[np.bool_]

    def interpolate(
        self, values: npt.ArrayLike, patterns: Optional[Sequence[PatchPattern]] = None
    ) -> npt.NDArray[np.float64]:
        """Interpolates values of the source's corners, (corners, k), at every point: (patches, q, k).

        value of a point = sum over patch corners c, triangle corners i of
                           weights[point, c] * barycentrics[patch, c, i] * values[corners[patch, i]]

        With a tolerance, `patterns` are those of an update, and the result has the shape (points, k).
        """
        at_triangle = np.asarray(values, dtype=float)[self.corners]
        at_patch = np.einsum("pci,pik->pck", self.barycentrics, at_triangle)
        if self.topology.uniform is None:
            if patterns is None or len(patterns) != len(at_patch):
                raise ValueError("with a tolerance, patterns are those of an update of this topology")
            return np.concatenate([pattern.weights @ at for pattern, at in zip(patterns, at_patch)])
        return np.asarray(np.einsum("qc,pck->pqk", self.topology.weights, at_patch))

    @classmethod
    def from_parts(cls, topology: Topology, parts: List[Any]) -> Provenance:
        """Converts the latticed.v1.TopologyPart messages that GetTopology sends."""

        def joined(name: str, kind: Any) -> npt.NDArray[Any]:
            return np.concatenate([np.array(getattr(part, name), dtype=kind) for part in parts])

        if sum(len(part.faces) for part in parts) != topology.patches:
            raise LatticedError.data_loss("the server sent less than the whole topology")
        return cls(
            topology,
            joined("faces", np.int64),
            joined("corners", np.int64).reshape(-1, 3),
            joined("barycentrics", float).reshape(-1, 3, 3),
            joined("on_lattice_face", bool),
        )
