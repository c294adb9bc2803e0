# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""A drag, or another run of edits that are one step of undo."""
from __future__ import annotations

from types import TracebackType
from typing import Callable, Sequence, Type

from latticed.point_edits import Applied, PointEdits
from latticed.v1 import edit_pb2


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

    def __exit__(
        self, kind: Type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.commit()
        else:
            self.cancel()
