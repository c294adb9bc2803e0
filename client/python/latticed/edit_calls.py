# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The edits as methods: of scenes, streams and gestures."""
from __future__ import annotations

import uuid
from abc import ABC, abstractmethod
from typing import Callable, Generic, Sequence, Type, TypeVar, Union

import numpy.typing as npt

from latticed import edits
from latticed.surface_point import SurfacePoint
from latticed.v1 import edit_pb2

Applied = TypeVar("Applied")


class PointEdits(ABC, Generic[Applied]):
    """One edit a call; apply says what comes of it."""

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

    def replace(self, control_points: npt.ArrayLike) -> Applied:
        """Puts all control points at positions: shape (nw, nv, nu, 3), world units."""
        return self.apply([edits.replace(control_points)])

    def drag(self, points: Union[SurfacePoint, Sequence[SurfacePoint]], targets: npt.ArrayLike) -> Applied:
        """Moves control points as little as takes points of the surface, those of Scene.pick for instance, to
        targets, shape (points, 3), world units."""
        return self.apply([edits.drag(points, targets)])


class Gesture(PointEdits[Applied]):
    """Every update replaces the one before it and begins at the state at the gesture's begin.

        with stream.gesture() as drag:
            for share in np.linspace(0, 1, 60):
                drag.move(lattice.indices[-1], (share, 0, 0))

    It is committed at the end of the block, and cancelled, which restores its begin, where the block is left
    by an exception.
    """

    def __init__(self, apply: Callable[[edit_pb2.EditBatch], Applied], gesture_id: str) -> None:
        self._send = apply
        self._gesture_id = gesture_id

    def _batch(self, phase: edit_pb2.GesturePhase, changes: Sequence[edit_pb2.Edit] = ()) -> Applied:
        return self._send(edit_pb2.EditBatch(gesture_id=self._gesture_id, gesture_phase=phase, edits=changes))

    def apply(self, changes: Sequence[edit_pb2.Edit]) -> Applied:
        """Several of latticed.edits in place of the update before."""
        return self._batch(edit_pb2.GESTURE_PHASE_UPDATE, changes)

    def commit(self) -> Applied:
        """Ends it; the last update stays."""
        return self._batch(edit_pb2.GESTURE_PHASE_COMMIT)

    def cancel(self) -> Applied:
        """Ends it and restores its begin."""
        return self._batch(edit_pb2.GESTURE_PHASE_CANCEL)

    def __enter__(self) -> Gesture[Applied]:
        return self

    def __exit__(self, kind: Type[BaseException] | None, *error: object) -> None:
        if kind is None:
            self.commit()
        else:
            self.cancel()


class EditCalls(PointEdits[Applied]):
    """A scene, which returns an EditResult, or a stream, which returns a sequence to wait for.

    Control points are named by their indices (Lattice.indices), or by a mask of the shape (nw, nv, nu).
    """

    @abstractmethod
    def _apply(self, batch: edit_pb2.EditBatch) -> Applied:
        """Fills in scene, editor, sequence and, where it is 0, structure, and sends the batch."""

    def apply(self, changes: Sequence[edit_pb2.Edit], expected_revision: int | None = None) -> Applied:
        """Applies several of latticed.edits at once, all or none, as one revision and one step of undo.

        expected_revision: only if the scene is at this revision, or REVISION_CHANGED.
        """
        batch = edit_pb2.EditBatch(edits=changes)
        if expected_revision is not None:
            batch.expected_revision = expected_revision
        return self._apply(batch)

    def insert_knot(self, axis: str, value: float) -> Applied:
        """Adds a knot to axis "u", "v" or "w": one control point more on it, and the same shape."""
        return self.apply([edits.insert_knot(axis, value)])

    def reset(self, to: str = "identity") -> Applied:
        """Puts all control points back: "identity" to the mesh at rest, "initial" to those of the begin."""
        return self.apply([edits.reset(to)])

    def undo(self, whose: str = "mine") -> Applied:
        """Reverts the last step: of this editor, "mine", or of anybody, "scene"."""
        return self.apply([edits.undo(whose)])

    def redo(self) -> Applied:
        """Applies the step again that this editor undid last."""
        return self.apply([edits.redo()])

    def gesture(self) -> Gesture[Applied]:
        """Edits that are one step of undo: a drag, for instance. See Gesture."""
        return Gesture(self._apply, uuid.uuid4().hex)
