# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The edits as methods of scenes, streams and gestures."""
from __future__ import annotations

import uuid
from abc import ABC, abstractmethod
from typing import Callable, Generic, Sequence, Type, TypeVar, Union

import numpy.typing as npt

from latticed import edits
from latticed.lattice import Lattice
from latticed.measures import Constraints
from latticed.surface_point import SurfacePoint
from latticed.v1 import edit_pb2

Applied = TypeVar("Applied")


class PointEdits(ABC, Generic[Applied]):
    """One edit per call. Every method returns the result of apply."""

    @abstractmethod
    def apply(self, changes: Sequence[edit_pb2.Edit]) -> Applied:
        """Applies several of latticed.edits at once."""

    def set_points(self, points: npt.ArrayLike, positions: npt.ArrayLike) -> Applied:
        """Puts control points at positions, shape (points, 3), world units."""
        return self.apply([edits.set_points(points, positions)])

    def move(self, points: npt.ArrayLike, offset: npt.ArrayLike) -> Applied:
        """Moves control points by one offset: x, y, z, world units."""
        return self.apply([edits.move(points, offset)])

    def transform(self, points: npt.ArrayLike, matrix: npt.ArrayLike) -> Applied:
        """Transforms control points by an affine 4 x 4 matrix that acts on columns (x, y, z, 1)."""
        return self.apply([edits.transform(points, matrix)])

    def carry(self, parent: Lattice, points: npt.ArrayLike | None = None) -> Applied:
        """Moves control points, by default all, as a deformed parent lattice moves the world at their
        places: the scene's lattice is nested in the parent."""
        return self.apply([edits.carry(parent, points)])

    def replace(self, control_points: npt.ArrayLike) -> Applied:
        """Puts all control points at positions: shape (nw, nv, nu, 3), world units."""
        return self.apply([edits.replace(control_points)])

    def set_strength(self, strength: float) -> Applied:
        """Sets how much of the deformation the scene takes, 0 to 1: x goes to x + strength (F(x) - x), exactly. It
        moves no control point; a drag at 0 fails with the reason NO_STRENGTH."""
        return self.apply([edits.set_strength(strength)])

    def drag(self, points: Union[SurfacePoint, Sequence[SurfacePoint]], targets: npt.ArrayLike) -> Applied:
        """Moves points of the surface, for example from Scene.pick, to targets, shape (points, 3), world
        units, by the smallest possible moves of control points."""
        return self.apply([edits.drag(points, targets)])


class Gesture(PointEdits[Applied]):
    """Edits that are one step of undo. Each replaces the previous one, and applies to the state at the begin.

        with stream.gesture() as drag:
            for share in np.linspace(0, 1, 60):
                drag.move(lattice.indices[-1], (share, 0, 0))

    The end of the block commits the gesture. An exception in the block cancels it, which restores the state
    at its begin.
    """

    def __init__(
        self,
        apply: Callable[[edit_pb2.EditBatch], Applied],
        gesture_id: str,
        refuse_folds: bool = False,
        keep_volume: bool = False,
    ) -> None:
        self._send = apply
        self._begin = edit_pb2.EditBatch(gesture_id=gesture_id, refuse_folds=refuse_folds)
        if keep_volume:
            self._begin.keep_volume.SetInParent()

    def _batch(self, phase: edit_pb2.GesturePhase, changes: Sequence[edit_pb2.Edit] = ()) -> Applied:
        batch = edit_pb2.EditBatch(gesture_phase=phase, edits=changes)
        batch.MergeFrom(self._begin)
        return self._send(batch)

    def apply(self, changes: Sequence[edit_pb2.Edit]) -> Applied:
        """Applies several of latticed.edits in place of the previous ones."""
        return self._batch(edit_pb2.GESTURE_PHASE_UPDATE, changes)

    def commit(self) -> Applied:
        """Ends the gesture; its last edits stay."""
        return self._batch(edit_pb2.GESTURE_PHASE_COMMIT)

    def cancel(self) -> Applied:
        """Ends the gesture and restores the state at its begin."""
        return self._batch(edit_pb2.GESTURE_PHASE_CANCEL)

    def __enter__(self) -> Gesture[Applied]:
        return self

    def __exit__(self, kind: Type[BaseException] | None, *error: object) -> None:
        if kind is None:
            self.commit()
        else:
            self.cancel()


class EditCalls(PointEdits[Applied]):
    """Edits of a scene, which return an EditResult, or of a stream, which return a sequence to wait for.

    Control points are named by their indices (Lattice.indices), or by a mask of the shape (nw, nv, nu).

    refuse_folds: whether edits fail that make a new fold near the surface, with a LatticedError of the reason
    FOLD. Its metadata has box, rest_point and determinant. What mends an old fold, or leaves it, passes.
    """

    refuse_folds = False

    @abstractmethod
    def _apply(self, batch: edit_pb2.EditBatch) -> Applied:
        """Fills in sequence and, if it is 0, structure_id (a Scene also scene and editor). Sends the batch."""

    def apply(
        self,
        changes: Sequence[edit_pb2.Edit],
        expected_revision: int | None = None,
        refuse_folds: bool | None = None,
    ) -> Applied:
        """Applies several of latticed.edits at once, all or none, as one revision and one step of undo.

        expected_revision: refused with REVISION_CHANGED unless the scene is at this revision.
        refuse_folds: None: as the attribute says.
        """
        refuse = self.refuse_folds if refuse_folds is None else refuse_folds
        batch = edit_pb2.EditBatch(edits=changes, refuse_folds=refuse)
        if expected_revision is not None:
            batch.expected_revision = expected_revision
        return self._apply(batch)

    def insert_knot(self, axis: str, value: float) -> Applied:
        """Adds a knot to axis "u", "v" or "w": one more control point on the axis, and the same shape."""
        return self.apply([edits.insert_knot(axis, value)])

    def replace_lattice(self, lattice: Lattice, keep_shape: bool = False) -> Applied:
        """Gives the scene another lattice. The strength stays what it is in the scene.

        keep_shape: the lattice has the scene's frame. Its control points are ignored; those that keep the
        present shape best are fitted. EditResult.drag_residual is the largest distance at the knots
        and half-way between them.
        """
        return self.apply([edits.replace_lattice(lattice, keep_shape)])

    def set_weights(self, weights: npt.ArrayLike | None, vertices: npt.ArrayLike | None = None) -> Applied:
        """Sets how much of the deformation vertices take, 0 to 1: an array with one number for each vertex, or with
        `vertices`, their indices or a mask, for each of those. None: the scene has no weights any more. It is one
        step of undo; the scene's plan is made again."""
        return self.apply([edits.set_weights(weights, vertices)])

    def set_constraints(self, constraints: Constraints) -> Applied:
        """Sets what later edits must keep, in place of what they kept; Constraints() ends all."""
        return self.apply([edits.set_constraints(constraints)])

    def reset(self, to: str = "identity") -> Applied:
        """Resets all control points: "identity": the mesh at rest; "initial": as the scene was
        created, or as the lattice was replaced."""
        return self.apply([edits.reset(to)])

    def undo(self, whose: str = "mine") -> Applied:
        """Reverts the last step of this editor ("mine") or of any editor ("scene")."""
        return self.apply([edits.undo(whose)])

    def redo(self) -> Applied:
        """Applies again the last step that this editor has undone."""
        return self.apply([edits.redo()])

    def edits_of(self, lattice: int) -> LatticeEdits[Applied]:
        """The same edits for another lattice of the scene, from 0. Each lattice has undo steps, gestures and
        constraints of its own; what all of them move the mesh adds up."""
        return LatticeEdits(self, lattice)

    def gesture(self, keep_volume: bool = False) -> Gesture[Applied]:
        """Begins edits that are one step of undo, for example a drag. See Gesture.

        keep_volume: free control points move along, so that the surface encloses the volume that it has at rest.
        """
        return Gesture(self._apply, uuid.uuid4().hex, self.refuse_folds, keep_volume)


class LatticeEdits(EditCalls[Applied]):
    """Edits of one lattice of several, from EditCalls.edits_of."""

    def __init__(self, target: EditCalls[Applied], lattice: int) -> None:
        self._target = target
        self._lattice = lattice

    @property
    def refuse_folds(self) -> bool:
        """The setting of the scene or stream that made this object."""
        return self._target.refuse_folds

    @refuse_folds.setter
    def refuse_folds(self, on: bool) -> None:
        self._target.refuse_folds = on

    def _apply(self, batch: edit_pb2.EditBatch) -> Applied:
        batch.lattice = self._lattice
        return self._target._apply(batch)
