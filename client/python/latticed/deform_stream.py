# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Editing and watching in one stream."""
from __future__ import annotations

import queue
from collections import OrderedDict, deque
from typing import Any, Deque, Dict, Iterator, Optional, Sequence, Type, Union

import grpc

from latticed.camera import Camera
from latticed.connection import Connection
from latticed.edit_calls import EditCalls
from latticed.edit_result import EditResult
from latticed.errors import LatticedError
from latticed.presence import Presence
from latticed.update import Update
from latticed.update_stream import UpdateStream
from latticed.v1 import edit_pb2, event_pb2, scene_pb2
from latticed.view import View

_MOST_ANSWERS = 1024
# The server that ends the stream did not take the edit. It stays unanswered, and is sent again to the next server.
_FOR_NEXT_SERVER = ("DRAINING", "SCENE_MOVED")


class Requests:
    """A queue of requests. A thread of gRPC reads it until finish. Any thread may write."""

    def __init__(self, watch: scene_pb2.WatchRequest) -> None:
        self._queue: queue.SimpleQueue[Optional[scene_pb2.DeformRequest]] = queue.SimpleQueue()
        self.send(watch=watch)

    def send(self, **message: Any) -> None:
        """Writes one field of DeformRequest."""
        self._queue.put(scene_pb2.DeformRequest(**message))

    def finish(self) -> None:
        """No more requests: half-closes the stream, and ends grpc's thread."""
        self._queue.put(None)

    def __iter__(self) -> Iterator[scene_pb2.DeformRequest]:
        return iter(self._queue.get, None)


class DeformStream(UpdateStream, EditCalls[int]):
    """A stream of edits, which return at once, and of updates; made by Scene.deform.

        with scene.deform() as stream:
            edit = stream.move(stream.lattice.indices[-1], (0.5, 0, 0))
            update = stream.wait(edit)

    Every edit returns its sequence. After a break the stream opens itself again and sends unanswered edits
    again; by their sequences the server applies each once. The stream is its own editor: its undo reverts
    its own edits, not those of its Scene object.

    The end of the block waits until every edit is answered, and raises the first refusal that neither wait
    nor result has raised. An exception in the block ends the stream at once.
    """

    def __init__(
        self, connection: Connection, watch: scene_pb2.WatchRequest, view: View, default: View
    ) -> None:
        super().__init__(connection, watch, view, default)
        self._requests = Requests(watch)
        self._half_closed = False
        self._last_sequence = 0
        self._unanswered: Deque[edit_pb2.EditBatch] = deque()
        self._answers: OrderedDict[int, Union[EditResult, LatticedError]] = OrderedDict()
        self._unseen_refusals: Dict[int, LatticedError] = {}
        self._resent = 0  # the last sequence that was sent twice

    @property
    def editor_id(self) -> str:
        """Names this stream's edits to other watchers."""
        return str(self._watch.editor_id)

    def wait(self, sequence: int, timeout: Optional[float] = None) -> Update:
        """Waits for an update that holds the edit, and returns the newest update.

        Raises LatticedError if the edit was refused (the stream keeps the last 1,024 answers); TimeoutError
        after `timeout` seconds; ValueError for a sequence that was never sent; LatticedError CANCELLED if the
        stream has ended."""
        with self._changed:
            self._check_sent(sequence)
            self._wait(
                lambda: isinstance(self._answers.get(sequence), LatticedError)
                or (self._latest is not None and self._latest.applied_sequence >= sequence),
                timeout,
            )
            # A refusal comes first: the update may hold an edit with a higher sequence.
            self._raise_refusal(sequence)
            if self._latest is None or self._latest.applied_sequence < sequence:
                raise LatticedError(grpc.StatusCode.CANCELLED, "the stream ended before the edit was seen")
            return self._hand_out()

    def result(self, sequence: int, timeout: Optional[float] = None) -> EditResult:
        """Waits for the answer to the edit, which comes before its update. The stream keeps the last 1,024
        answers. Raises as wait; CANCELLED if the answer was lost with a connection or is no longer kept."""
        with self._changed:
            self._check_sent(sequence)
            self._wait(lambda: all(batch.sequence != sequence for batch in self._unanswered), timeout)
            self._raise_refusal(sequence)
            answer = self._answers.get(sequence)
            if not isinstance(answer, EditResult):
                raise LatticedError(
                    grpc.StatusCode.CANCELLED, "the edit's answer was lost with its connection"
                )
            return answer

    def set_view(self, view: View) -> None:
        """Changes the view, from the next update on."""
        options = self._options(view)
        with self._changed:
            self._watch.view.CopyFrom(options)
            self._requests.send(control=scene_pb2.ControlWatchRequest(view=options))

    def pause(self, paused: bool = True) -> None:
        """Stops updates, but not edits and their results. paused=False lets updates go on."""
        with self._changed:
            self._paused = paused
            self._requests.send(control=scene_pb2.ControlWatchRequest(pause=paused))

    def show(
        self,
        name: str = "",
        colour: int = 0,
        selected: Sequence[int] = (),
        camera: Optional[Camera] = None,
        following: str = "",
        lattice: int = 0,
    ) -> None:
        """Shows others who this editor is and what it has selected, and its camera, until the stream ends: see Presence."""
        presence = Presence(name, colour, tuple(selected), camera, following, lattice)
        message = presence.to_proto()
        with self._changed:
            self._shown = presence
            self._requests.send(presence=message)

    def finish(self) -> None:
        """No more edits: the stream ends after the update that holds the last one."""
        with self._changed:
            if not self._half_closed:
                self._half_closed = True
                self._requests.finish()

    def close(self) -> None:
        super().close()
        self._requests.finish()

    def __exit__(self, kind: Type[BaseException] | None, *error: object) -> None:
        try:
            if kind is None:
                self._wait_for_answers()
        finally:
            self.close()

    def _wait_for_answers(self) -> None:
        with self._changed:
            if not self._closing:
                self._wait(lambda: not self._unanswered, None)
            if self._unseen_refusals:
                raise next(iter(self._unseen_refusals.values()))

    def _apply(self, batch: edit_pb2.EditBatch) -> int:
        with self._changed:
            if self._error is not None:
                raise self._error
            if self._half_closed or self._closing or self._ended:
                raise RuntimeError("the stream takes no more edits")
            if batch.structure_id == 0:
                batch.structure_id = self.lattice.structure_id
            self._last_sequence += 1
            batch.sequence = self._last_sequence
            self._unanswered.append(batch)
            self._requests.send(edit=batch)
            return self._last_sequence

    def _check_sent(self, sequence: int) -> None:
        if not 0 < sequence <= self._last_sequence:
            raise ValueError(f"edit {sequence} was never sent: the last one was {self._last_sequence}")

    def _raise_refusal(self, sequence: int) -> None:
        self._unseen_refusals.pop(sequence, None)
        answer = self._answers.get(sequence)
        if isinstance(answer, LatticedError):
            raise answer

    def _open(self) -> Any:
        self._requests.finish()  # ends the requests of the previous rpc
        self._requests = Requests(self._watch)
        if self._shown is not None:
            self._requests.send(presence=self._shown.to_proto())
        for batch in self._unanswered:
            self._requests.send(edit=batch)
            self._resent = batch.sequence
        if self._paused:
            self._requests.send(control=scene_pb2.ControlWatchRequest(pause=True))
        if self._half_closed:
            self._requests.finish()
        metadata = self._connection.metadata(self._watch.scene)
        return self._connection.streams.Deform(iter(self._requests), metadata=metadata)

    def _end_requests(self) -> None:
        self._requests.finish()

    def _acknowledge(self, update_id: int) -> None:
        self._requests.send(control=scene_pb2.ControlWatchRequest(acked_update_id=update_id))

    def _answer_heartbeat(self) -> None:
        self._requests.send(heartbeat=event_pb2.Heartbeat())

    def _complete(self, update: Update, end: Any) -> None:
        super()._complete(update, end)
        # An editor that sent edits before this stream continues above its old sequences.
        self._last_sequence = max(self._last_sequence, update.applied_sequence)

    def _take_result(self, result: Any) -> None:
        refusal = LatticedError.from_status(result.status) if result.status.code != 0 else None
        if refusal is not None and refusal.reason in _FOR_NEXT_SERVER:
            return
        with self._changed:
            while self._unanswered and self._unanswered[0].sequence <= result.sequence:
                self._unanswered.popleft()
            if refusal is None:
                self._answers[result.sequence] = EditResult.from_proto(result)
            else:
                self._refuse(result.sequence, refusal)
            while len(self._answers) > _MOST_ANSWERS:
                self._unseen_refusals.pop(self._answers.popitem(last=False)[0], None)
            self._changed.notify_all()

    def _refuse(self, sequence: int, refusal: LatticedError) -> None:
        # The edit was sent twice, and the server handled a later one before the connection broke. It handled
        # this one too. The answer is lost, because the server keeps only an editor's last answer.
        if refusal.reason == "OUT_OF_ORDER" and sequence <= self._resent:
            return
        self._answers[sequence] = self._unseen_refusals[sequence] = refusal
