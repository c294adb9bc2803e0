# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The edits as methods, for everything that applies edits."""
from __future__ import annotations

import uuid
from abc import abstractmethod
from typing import Sequence

from latticed import edits
from latticed.gesture import Gesture
from latticed.point_edits import Applied, PointEdits
from latticed.v1 import edit_pb2


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
