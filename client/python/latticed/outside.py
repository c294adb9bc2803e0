# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""How a lattice goes on outside its frame, and the larger lattice that is its continuation."""
from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, List, Optional, Tuple, Union

import numpy as np
import numpy.typing as npt

from latticed.v1 import lattice_pb2

if TYPE_CHECKING:
    from latticed.lattice import Lattice

FloatArray = npt.NDArray[np.float64]
Widths = Union[float, Tuple[float, ...]]

_MODES = {
    "fixed": lattice_pb2.OUTSIDE_MODE_FIXED,
    "falloff": lattice_pb2.OUTSIDE_MODE_FALLOFF,
    "linear": lattice_pb2.OUTSIDE_MODE_LINEAR,
}


@dataclass(frozen=True)
class Outside:
    """What becomes of points outside the frame: Outside(), they stay, Outside.falloff(0.3) or Outside.linear().

    mode    "fixed", "falloff" or "linear"
    widths  how far it goes on, in lengths of the frame's edges: at the begin and end of u, of v, of w; 0 is fixed
    smooth  of a falloff: whether normals, too, go on through the faces
    steps   of a falloff: how far from each face its inner knot plane is; empty: the server chooses
    """

    mode: str = "fixed"
    widths: Tuple[float, ...] = ()
    smooth: bool = True
    steps: Tuple[float, ...] = ()

    @classmethod
    def falloff(cls, width: Widths, smooth: bool = True) -> Outside:
        """The move of a face fades out at a width, one number or six, from the face. With smooth=False there is a
        crease at the face, and no point outside moves further than the face."""
        return cls("falloff", _sides(width), smooth)

    @classmethod
    def linear(cls, width: Optional[Widths] = None) -> Outside:
        """The deformation goes on along straight lines: as far as the mesh reaches, or to a width."""
        return cls("linear", () if width is None else _sides(width))

    def to_proto(self) -> lattice_pb2.LatticeOutside:
        if self.mode not in _MODES:
            raise ValueError(f"a mode is one of {', '.join(_MODES)}, not {self.mode!r}")
        made = lattice_pb2.LatticeOutside(mode=_MODES[self.mode], widths=self.widths, steps=self.steps)
        if not self.smooth:
            made.continuity = lattice_pb2.OUTSIDE_CONTINUITY_C0
        return made

    @classmethod
    def from_proto(cls, outside: Any) -> Outside:
        """Converts a latticed.v1.LatticeOutside."""
        names = {number: name for name, number in _MODES.items()}
        smooth = outside.continuity != lattice_pb2.OUTSIDE_CONTINUITY_C0
        mode = names.get(outside.mode, "fixed")
        return cls(mode, _sides(tuple(outside.widths)), smooth, _sides(tuple(outside.steps)))


def continued(lattice: Lattice, rest: Optional[FloatArray] = None) -> Lattice:
    """The lattice that plans and patches are of: the given one inside the frame, and what goes on outside it.

    Its displacements are strength times E_w x E_v x E_u times the given ones; see core/ffd/outside/outside_map.h, or LatticeOutside in
    lattice.proto. rest  its control points at rest, if they are known bit by bit

    ValueError for a linear one without widths, which the server fills in from the mesh.
    """
    lattice = lattice.effective()
    if lattice.outside.mode == "fixed":
        return lattice
    if not lattice.outside.widths:
        raise ValueError("a continuation needs widths: read the lattice from its scene")
    knots, maps, length, origin = [], [], [], lattice.origin
    for axis in range(3):
        axis_knots, axis_map = _continue_axis(lattice, axis)
        knots.append(axis_knots)
        maps.append(axis_map)
        before, after = lattice.outside.widths[2 * axis : 2 * axis + 2]
        origin = origin - before * lattice.edges[axis]
        length.append(1 + before + after)
    made = dataclasses.replace(
        lattice,
        control_points=np.zeros([len(m) for m in reversed(maps)] + [3]),
        knots=(knots[0], knots[1], knots[2]),
        origin=origin,
        edges=lattice.edges * np.array(length)[:, None],
        outside=Outside(),
    )
    at_rest = made.rest() if rest is None or not rest.size else rest.reshape(made.control_points.shape)
    given = lattice.rest()
    u, v, w = maps
    moves = np.einsum("ck,bj,ai,kjix->cbax", w, v, u, lattice.control_points - given, optimize=True)
    moved = (lattice.control_points != given).any(axis=-1).astype(float)
    has_moved = np.einsum("ck,bj,ai,kji->cba", w != 0, v != 0, u != 0, moved, optimize=True) > 0
    made.control_points = np.where(has_moved[..., None], at_rest + moves, at_rest)
    return made


def _continue_axis(lattice: Lattice, axis: int) -> Tuple[FloatArray, FloatArray]:
    """The knots of the continued axis, and E_a: (control points of it, of the given one)."""
    knots, degree, count = lattice.knots[axis], lattice.degree[axis], lattice.size[axis]
    begin, end = float(knots[degree]), float(knots[count])
    front, front_rows, front_replaced = _side(lattice, axis, 0, float(knots[degree + 1]) - begin, end - begin)
    back, back_rows, back_replaced = _side(lattice, axis, 1, end - float(knots[count - 1]), end - begin)
    inner = np.eye(count)[front_replaced : count - back_replaced]
    rows = [np.resize([], (0, count)), *(_row(r, count) for r in front_rows), inner]
    rows += [_row(r, count)[:, ::-1] for r in reversed(back_rows)]
    between = knots[degree + 1 : count]
    made = [begin - np.array(front[::-1]), between, end + np.array(back)]
    return np.concatenate(made), np.concatenate(rows)


def _row(numbers: List[float], count: int) -> FloatArray:
    return np.array([numbers + [0.0] * (count - len(numbers))])


def _side(
    lattice: Lattice, axis: int, end: int, span: float, length: float
) -> Tuple[List[float], List[List[float]], int]:
    """Distances of knots from the face outwards, rows of E_a from the outermost, and how many they replace."""
    outside, degree = lattice.outside, lattice.degree[axis]
    width = outside.widths[2 * axis + end] * length
    if width == 0:
        return [0.0] * (degree + 1), [], 0
    if outside.mode == "linear":
        reach = [k * width / span for k in range(degree, 0, -1)]
        return [0.0] * degree + [width] * (degree + 1), [[1 + r, -r] for r in reach], 0
    if outside.steps:
        step = outside.steps[2 * axis + end] * length
    else:
        step = min(width / 2, span / 4)
    smooth = outside.smooth and degree > 1
    faces = [0.0] * (degree - 1 if smooth else degree)
    distance = step / (degree * width)
    last = [1 + step / span, -step / span] if smooth else [1 - distance * distance * (3 - 2 * distance)]
    return faces + [step] + [width] * (degree + 1), [[0.0]] * degree + [last], int(smooth)


def _sides(widths: Widths) -> Tuple[float, ...]:
    """Six numbers, or none."""
    given = tuple(float(w) for w in np.atleast_1d(np.asarray(widths, dtype=float)))
    if len(given) == 1:
        return given * 6
    if len(given) not in (0, 6):
        raise ValueError(f"one width or six are needed, not {len(given)}")
    return given
