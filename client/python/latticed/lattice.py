# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""A B-spline lattice as numpy arrays."""
from __future__ import annotations

import dataclasses
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Optional, Tuple, Union

import numpy as np
import numpy.typing as npt
from google.protobuf import json_format

from latticed import bspline
from latticed.outside import Outside, continued
from latticed.v1 import common_pb2, lattice_pb2

FloatArray = npt.NDArray[np.float64]

# A point within this share of the domain's width of one of its faces is on the face, as on the server.
_FACE_SNAP = 2.0**-40


def vector(xyz: npt.ArrayLike) -> common_pb2.Vec3:
    """Converts three numbers to a Vec3."""
    numbers = np.asarray(xyz, dtype=float)
    if numbers.shape != (3,):
        raise ValueError(f"x, y and z are needed, not the shape {numbers.shape}")
    return common_pb2.Vec3(x=numbers[0], y=numbers[1], z=numbers[2])


def _axes(numbers: Any) -> Tuple[int, int, int]:
    return (numbers.u, numbers.v, numbers.w)


@dataclass(repr=False)
class Lattice:
    """R(u,v,w) = sum over i,j,k of control_points[k, j, i] N_i(u) N_j(v) N_k(w).

    control_points  shape (nw, nv, nu, 3), world units. control_points[-1] is the top layer of an upright
                    lattice; control_points.reshape(-1, 3)[n] is the control point with index n in edits
    degree          of u, v, w, each 1 to 3
    knots           of u, v, w: control points of the axis + its degree + 1 knots each
    origin, edges   the frame: the knot domain is the box at origin that the rows of edges, shape (3, 3),
                    span: u, v, w
    outside         how it goes on outside the frame
    strength        how much of its deformation the scene takes, 0 to 1: see effective()
    structure_id, revision  of the scene that it was read from; 0: it was read from none
    """

    control_points: FloatArray
    degree: Tuple[int, int, int]
    knots: Tuple[FloatArray, FloatArray, FloatArray]
    origin: FloatArray
    edges: FloatArray
    structure_id: int = 0
    revision: int = 0
    outside: Outside = field(default_factory=Outside)
    strength: float = 1.0

    def __repr__(self) -> str:
        size, degree = (" x ".join(map(str, axes)) for axes in (self.size, self.degree))
        return f"<Lattice: {size} control points of degree {degree}, revision {self.revision}>"

    @property
    def size(self) -> Tuple[int, int, int]:
        """Control points of u, v, w."""
        nw, nv, nu = self.control_points.shape[:3]
        return (nu, nv, nw)

    @property
    def indices(self) -> npt.NDArray[np.int64]:
        """The index of each control point in edits, shape (nw, nv, nu): indices[-1] is the top layer."""
        return np.arange(self.control_points.size // 3).reshape(self.control_points.shape[:3])

    def rest(self) -> FloatArray:
        """Control points that leave the mesh as it is, shaped like control_points: the Greville abscissae
        of each axis, (knot i+1 + … + knot i+degree) / degree, placed in the frame."""
        places = []
        for degree, knots in zip(self.degree, self.knots):
            count = len(knots) - degree - 1
            means = np.array([knots[i + 1 : i + 1 + degree].mean() for i in range(count)])
            places.append((means - knots[degree], knots[count] - knots[degree]))
        w, v, u = np.meshgrid(places[2][0], places[1][0], places[0][0], indexing="ij")
        # In this order, so that the bits are those of the server's.
        at = self.origin + u[..., None] * (self.edges[0] / places[0][1])
        at = at + v[..., None] * (self.edges[1] / places[1][1])
        return np.asarray(at + w[..., None] * (self.edges[2] / places[2][1]))

    def effective(self) -> Lattice:
        """The lattice of strength 1 that deforms as this one: control points rest + strength (P - rest)."""
        if self.strength == 1:
            return self
        rest = self.rest()
        points = rest + self.strength * (self.control_points - rest)
        return dataclasses.replace(self, control_points=points, strength=1.0)

    def resized(
        self, size: Optional[Tuple[int, int, int]] = None, degree: Optional[Tuple[int, int, int]] = None
    ) -> Lattice:
        """A lattice at rest in the same frame, with other numbers of control points or other degrees, and with
        clamped uniform knots. Scene.replace_lattice(…, keep_shape=True) gives it the scene's shape."""
        nu, nv, nw = size or self.size
        degree = degree or self.degree
        u, v, w = (_clamped_uniform(count, p) for count, p in zip((nu, nv, nw), degree))
        knots = (u, v, w)
        made = Lattice(
            np.zeros((nw, nv, nu, 3)), degree, knots, self.origin, self.edges, outside=self.outside
        )
        made.control_points = made.rest()
        return made

    def deform(self, points: npt.ArrayLike) -> FloatArray:
        """Where the lattice moves points of the undeformed world: (n, 3) to (n, 3), world units, in double.

        A point x in the frame, faces included, moves to x + strength (R - x), with R of its place in it. What is outside
        follows `outside`.

        This moves vertices only, as an ordinary lattice does: Sederberg & Parry, Free-form deformation of
        solid geometric models, 1986. The faces between moved vertices are flat. The exact surface, which
        the server sends, passes through the same vertices and is curved between them.
        """
        at = np.asarray(points, dtype=float)
        if at.ndim != 2 or at.shape[1] != 3:
            raise ValueError(f"points are of shape (n, 3), not {at.shape}")
        if self.outside.mode != "fixed" or self.strength != 1:
            return continued(self).deform(at)
        domains = np.array([bspline.domain(k, p) for k, p in zip(self.knots, self.degree)])
        begin, width = domains[:, 0], domains[:, 1] - domains[:, 0]
        parameters = begin + (at - self.origin) @ np.linalg.inv(self.edges) * width
        snap = _FACE_SNAP * width
        inside = ((parameters >= begin - snap) & (parameters <= domains[:, 1] + snap)).all(axis=1)
        moved = at.copy()
        within = np.clip(parameters[inside], begin, domains[:, 1])
        moved[inside] = bspline.volume(self.control_points, self.degree, self.knots, within)
        return moved

    def to_proto(self) -> lattice_pb2.Lattice:
        u, v, w = self.edges
        return lattice_pb2.Lattice(
            frame=lattice_pb2.LatticeFrame(origin=vector(self.origin), u=vector(u), v=vector(v), w=vector(w)),
            degree=lattice_pb2.LatticeAxes(u=self.degree[0], v=self.degree[1], w=self.degree[2]),
            size=lattice_pb2.LatticeAxes(u=self.size[0], v=self.size[1], w=self.size[2]),
            knots_u=self.knots[0],
            knots_v=self.knots[1],
            knots_w=self.knots[2],
            control_points=self.control_points.reshape(-1),
            outside=None if self.outside.mode == "fixed" else self.outside.to_proto(),
        )

    @classmethod
    def from_state(cls, state: Any) -> Lattice:
        """Converts a latticed.v1.LatticeState, with its strength."""
        made = cls.from_proto(state.lattice, state.structure_id, state.revision)
        made.strength = state.strength if state.HasField("strength") else 1.0
        return made

    @classmethod
    def from_proto(cls, lattice: Any, structure_id: int = 0, revision: int = 0) -> Lattice:
        """Converts a latticed.v1.Lattice, of strength 1. Fills in control points, size, degree and knots if unset."""
        nu, nv, nw = _axes(lattice.size) if lattice.HasField("size") else (4, 4, 4)
        degree = _axes(lattice.degree) if lattice.HasField("degree") else (2, 2, 2)
        frame = lattice.frame
        given = (lattice.knots_u, lattice.knots_v, lattice.knots_w)
        knots = [
            np.array(known, dtype=float) if known else _clamped_uniform(count, p)
            for known, count, p in zip(given, (nu, nv, nw), degree)
        ]
        made = cls(
            control_points=np.zeros((nw, nv, nu, 3)),
            degree=degree,
            knots=(knots[0], knots[1], knots[2]),
            origin=np.array([frame.origin.x, frame.origin.y, frame.origin.z]),
            edges=np.array([[edge.x, edge.y, edge.z] for edge in (frame.u, frame.v, frame.w)]),
            structure_id=structure_id,
            revision=revision,
            outside=Outside.from_proto(lattice.outside),
        )
        if lattice.control_points:
            made.control_points = np.array(lattice.control_points, dtype=float).reshape(nw, nv, nu, 3)
        else:
            made.control_points = made.rest()
        return made

    def save(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes the JSON that latticectl reads. It has no strength: that is the scene's."""
        Path(path).write_text(json_format.MessageToJson(self.to_proto()))

    @classmethod
    def load(cls, path: Union[str, os.PathLike[str]]) -> Lattice:
        """Reads the JSON that latticectl writes; ValueError if the file is not that."""
        try:
            return cls.from_proto(json_format.Parse(Path(path).read_text(), lattice_pb2.Lattice()))
        except json_format.ParseError as error:
            raise ValueError(f"{path}: {error}") from error


def _clamped_uniform(count: int, degree: int) -> FloatArray:
    spans = count - degree
    return np.concatenate([np.zeros(degree), np.arange(spans + 1.0), np.full(degree, float(spans))])
