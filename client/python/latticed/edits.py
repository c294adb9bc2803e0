# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Makes edits of control points: latticed.v1.Edit messages, for Scene.apply and DeformStream.apply.

Control points are named by their indices (Lattice.indices), or by a mask of the shape (nw, nv, nu).
"""
from __future__ import annotations

from typing import Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from latticed.choices import choose
from latticed.lattice import Lattice, vector
from latticed.measures import Constraints
from latticed.surface_point import SurfacePoint
from latticed.v1 import edit_pb2, lattice_pb2

_AXES = {
    "u": lattice_pb2.LATTICE_AXIS_U,
    "v": lattice_pb2.LATTICE_AXIS_V,
    "w": lattice_pb2.LATTICE_AXIS_W,
}
_RESETS = {"identity": edit_pb2.RESET_TARGET_IDENTITY, "initial": edit_pb2.RESET_TARGET_INITIAL}
_SCOPES = {"mine": edit_pb2.UNDO_SCOPE_MINE, "scene": edit_pb2.UNDO_SCOPE_SCENE}


def _indices(points: npt.ArrayLike) -> npt.NDArray[np.int64]:
    array = np.asarray(points)
    if array.dtype == bool:
        return np.flatnonzero(array)
    if array.size == 0 or np.issubdtype(array.dtype, np.integer):
        return array.astype(np.int64).reshape(-1)
    raise ValueError(f"control points are named by integers or by a mask, not by {array.dtype}")


def set_points(points: npt.ArrayLike, positions: npt.ArrayLike) -> edit_pb2.Edit:
    """Puts control points at positions, shape (points, 3), world units."""
    indices, places = _indices(points), np.asarray(positions, dtype=float)
    if places.shape[-1:] != (3,) or places.size != 3 * indices.size:
        raise ValueError(
            f"{indices.size} control points need as many positions, not the shape {places.shape}"
        )
    change = edit_pb2.SetControlPoints(indices=indices, positions=places.reshape(-1))
    return edit_pb2.Edit(set_control_points=change)


def move(points: npt.ArrayLike, offset: npt.ArrayLike) -> edit_pb2.Edit:
    """Moves control points by one offset: x, y, z, world units."""
    change = edit_pb2.MoveControlPoints(indices=_indices(points), offset=vector(offset))
    return edit_pb2.Edit(move_control_points=change)


def transform(points: npt.ArrayLike, matrix: npt.ArrayLike) -> edit_pb2.Edit:
    """Transforms control points by an affine 4 x 4 matrix that acts on columns (x, y, z, 1), world units."""
    array = np.asarray(matrix, dtype=float)
    if array.shape != (4, 4):
        raise ValueError(f"a matrix has the shape (4, 4), not {array.shape}")
    change = edit_pb2.TransformControlPoints(indices=_indices(points), matrix=array.reshape(-1, order="F"))
    return edit_pb2.Edit(transform_control_points=change)


def carry(parent: Lattice, points: npt.ArrayLike | None = None) -> edit_pb2.Edit:
    """Moves control points, by default all, as a deformed parent lattice moves the world at their places.
    Those outside of its frame stay."""
    change = edit_pb2.CarryControlPoints(parent=parent.effective().to_proto())
    if points is not None:
        change.indices.extend(_indices(points))
        if not change.indices:
            raise ValueError("no control points are named")
    return edit_pb2.Edit(carry_control_points=change)


def replace(control_points: npt.ArrayLike) -> edit_pb2.Edit:
    """Puts all control points at positions: shape (nw, nv, nu, 3), world units."""
    flat = np.asarray(control_points, dtype=float).reshape(-1)
    return edit_pb2.Edit(replace_control_points=edit_pb2.ReplaceControlPoints(control_points=flat))


def drag(points: Union[SurfacePoint, Sequence[SurfacePoint]], targets: npt.ArrayLike) -> edit_pb2.Edit:
    """Moves points of the surface to targets, shape (points, 3), world units, by the smallest possible moves
    of control points. If not all targets can be reached, the remaining distances are smallest in the
    least-squares sense; EditResult.drag_residual is the largest of them.
    """
    held = [points] if isinstance(points, SurfacePoint) else list(points)
    places = np.asarray(targets, dtype=float).reshape(-1)
    if places.size != 3 * len(held):
        raise ValueError(f"{len(held)} points need as many targets, not {places.size} numbers")
    change = edit_pb2.DragPoints(points=[point.to_proto() for point in held], targets=places)
    return edit_pb2.Edit(drag_points=change)


def insert_knot(axis: str, value: float) -> edit_pb2.Edit:
    """Adds a knot to axis "u", "v" or "w": one more control point on the axis, and the same shape. It must be
    the only edit of its batch."""
    change = edit_pb2.InsertKnot(axis=choose("axis", axis, _AXES), value=value)
    return edit_pb2.Edit(insert_knot=change)


def replace_lattice(lattice: Lattice, keep_shape: bool = False) -> edit_pb2.Edit:
    """Gives the scene another lattice. It must be the only edit of its batch.

    keep_shape: the lattice has the scene's frame. Its control points are ignored; those that keep the present
    shape best are fitted. EditResult.drag_residual is the largest distance at the knots and
    half-way between them.
    """
    change = edit_pb2.ReplaceLattice(lattice=lattice.to_proto(), keep_shape=keep_shape)
    if keep_shape:
        del change.lattice.control_points[:]
    return edit_pb2.Edit(replace_lattice=change)


def remove_lattice() -> edit_pb2.Edit:
    """Takes the lattice that the batch names away from its scene. It must be the only edit of its batch."""
    return edit_pb2.Edit(remove_lattice=edit_pb2.RemoveLattice())


def set_constraints(constraints: Constraints) -> edit_pb2.Edit:
    """Sets what later edits must keep, in place of what they kept. It must be the only edit of its batch."""
    return edit_pb2.Edit(set_constraints=edit_pb2.SetConstraints(constraints=constraints.to_proto()))


def set_strength(strength: float) -> edit_pb2.Edit:
    """Sets how much of the deformation the scene takes, 0 to 1: x goes to x + strength (F(x) - x)."""
    return edit_pb2.Edit(set_strength=edit_pb2.SetStrength(strength=strength))


def set_weights(weights: Optional[npt.ArrayLike], vertices: Optional[npt.ArrayLike] = None) -> edit_pb2.Edit:
    """Sets how much of the deformation vertices take, 0 to 1: of all vertices of the mesh, or of some, named by
    their indices or by a mask. None: the scene has no weights any more. It must be the only edit of its batch.
    """
    if weights is None:
        return edit_pb2.Edit(set_weights=edit_pb2.SetWeights(clear=True))
    if vertices is None:
        values = np.ascontiguousarray(weights, "<f4").tobytes()
        return edit_pb2.Edit(set_weights=edit_pb2.SetWeights(values=values))
    indices = _indices(vertices)
    values = np.ascontiguousarray(np.broadcast_to(np.asarray(weights, "<f4"), indices.shape)).tobytes()
    some = edit_pb2.SomeWeights(indices=indices, values=values)
    return edit_pb2.Edit(set_weights=edit_pb2.SetWeights(some=some))


def reset(to: str = "identity") -> edit_pb2.Edit:
    """Resets all control points: "identity": the mesh at rest; "initial": as the scene was
    created, or as the lattice was replaced."""
    return edit_pb2.Edit(reset=edit_pb2.Reset(target=choose("to", to, _RESETS)))


def undo(whose: str = "mine") -> edit_pb2.Edit:
    """Reverts the last step of this editor ("mine") or of any editor ("scene"). It must be the only edit of
    its batch."""
    return edit_pb2.Edit(undo=edit_pb2.Undo(scope=choose("whose", whose, _SCOPES)))


def redo() -> edit_pb2.Edit:
    """Applies again the last step that this editor has undone. It must be the only edit of its batch."""
    return edit_pb2.Edit(redo=edit_pb2.Redo())
