# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The base of streams of updates. A thread reads, the newest update is kept, and a broken rpc is reopened."""
from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod
from typing import Any, Callable, Dict, Iterator, Optional, Type, TypeVar

import grpc

from latticed.connection import Connection
from latticed.errors import LatticedError
from latticed.lattice import Lattice
from latticed.presence import Presence
from latticed.retries import Attempts
from latticed.surface import Surface
from latticed.update import Update
from latticed.v1 import event_pb2, scene_pb2
from latticed.view import View

# A stream that has lived so long has worked, also without an update, as while nothing changes.
_WORKS_SECONDS = 1.0

Self = TypeVar("Self", bound="UpdateStream")


class UpdateStream(ABC):
    """Updates of a scene. Only the newest is kept: it replaces an older one that nobody has taken.

        with scene.watch() as stream:
            for update in stream:
                show(update.points)

    A stream lives until it is closed; a with block closes it. After a break, or after a goaway of the server,
    it opens itself again and resumes. It tries for the seconds that latticed.connect was told: 30. Any number of
    threads may use it. The next call raises an error of the server as LatticedError.
    """

    def __init__(
        self, connection: Connection, watch: scene_pb2.WatchRequest, view: View, scene_default: View
    ) -> None:
        self._connection = connection
        self._scene_default = scene_default
        self._watch = watch  # its resume_token is always the newest
        self._watch.view.CopyFrom(self._options(view))
        self._surface = Surface()
        self._changed = threading.Condition()  # guards all that follow
        self._call: Any = None
        self._latest: Optional[Update] = None
        self._completed = 0  # complete updates so far, and how many of them were returned or skipped
        self._handed_out = 0
        self._attempts = Attempts(connection.reachability)
        self._hello_at: Optional[float] = None  # time.monotonic() of the present rpc's hello
        self._reconnections = 0
        self._error: Optional[Exception] = None
        self._paused = False
        self._shown: Optional[Presence] = None
        self._others: Dict[str, Presence] = {}
        self._closing = False
        self._ended = False
        self._hello: Any = event_pb2.Hello()
        self._reader = threading.Thread(target=self._run, name="latticed stream", daemon=True)

    @property
    def lattice(self) -> Lattice:
        """The lattice after the newest reported edit of any editor."""
        assert self._surface.lattice is not None  # it comes before the first update, for which _start waits
        return self._surface.lattice

    @property
    def latest(self) -> Update:
        """The newest complete update."""
        with self._changed:
            assert self._latest is not None
            return self._latest

    @property
    def others(self) -> Dict[str, Presence]:
        """The presence of other editors that show it, by editor_id."""
        with self._changed:
            return dict(self._others)

    @property
    def reconnections(self) -> int:
        """How often the stream has opened itself again."""
        return self._reconnections

    def next_update(self, timeout: Optional[float] = None) -> Optional[Update]:
        """Waits for an update that is newer than the last returned one; None once the stream has ended.

        TimeoutError after `timeout` seconds."""
        with self._changed:
            self._wait(lambda: self._completed > self._handed_out, timeout)
            if self._completed == self._handed_out:
                return None
            return self._hand_out()

    def __iter__(self) -> Iterator[Update]:
        while True:
            update = self.next_update()
            if update is None:
                return
            yield update

    def close(self) -> None:
        """Ends the stream at once. Waiting calls return."""
        with self._changed:
            self._closing = True
            if self._call is not None:
                self._call.cancel()
            self._changed.notify_all()
        if self._reader.is_alive() and self._reader is not threading.current_thread():
            self._reader.join()

    def __enter__(self: Self) -> Self:
        return self

    def __exit__(self, kind: Type[BaseException] | None, *error: object) -> None:
        self.close()

    def _options(self, view: View) -> Any:
        return view.for_stream(self._scene_default, self._connection.encoding_choice)

    def _start(self) -> None:
        """Starts the reading thread and waits for the first update. The lattice is known then."""
        self._reader.start()
        try:
            with self._changed:
                self._wait(lambda: self._latest is not None, None)
                if self._latest is None:
                    raise LatticedError.data_loss("the server ended the stream before its first update")
        except BaseException:
            self.close()
            raise

    # For subclasses. The reading thread calls all but _wait and _hand_out.

    @abstractmethod
    def _open(self) -> Any:
        """Starts the rpc. Called with _changed held."""

    def _end_requests(self) -> None:
        """The server ends the rpc: half-closes it, if the client writes requests."""

    def _begin(self) -> None:
        """Called when the hello of an rpc has come."""

    @abstractmethod
    def _acknowledge(self, update_id: int) -> None:
        """Acknowledges an update to the server."""

    @abstractmethod
    def _answer_heartbeat(self) -> None:
        """Sends a heartbeat, so that the server knows that this watcher lives."""

    def _take_result(self, result: Any) -> None:
        """Handles an edit_result."""

    def _complete(self, update: Update, end: Any) -> None:
        """Handles a complete update. Called with _changed held."""
        self._attempts.succeeded()
        self._watch.resume_token = end.resume_token
        self._latest = update
        self._completed += 1

    def _hand_out(self) -> Update:
        """Returns the newest update and marks it as returned. Called with _changed held."""
        assert self._latest is not None
        self._handed_out = self._completed
        return self._latest

    def _wait(self, done: Callable[[], bool], timeout: Optional[float]) -> None:
        """Waits until `done` or the stream's end. Raises the stream's error. Called with _changed held."""
        if not self._changed.wait_for(lambda: done() or self._ended, timeout):
            raise TimeoutError(f"nothing came within {timeout} seconds")
        if not done() and self._error is not None:
            raise self._error

    # The reading thread.

    def _run(self) -> None:
        error: Optional[Exception] = None
        try:
            pause = self._read_one_rpc()
            while pause is not None and not self._pause(pause):
                self._reconnections += 1
                pause = self._read_one_rpc()
        except Exception as trouble:  # waiting calls raise any error, also a closed channel's ValueError
            error = trouble
        with self._changed:
            self._error, self._ended = error, True
            self._changed.notify_all()

    def _pause(self, seconds: float) -> bool:
        """Pauses, and returns whether the stream is closing."""
        is_connected = False

        def connected() -> None:
            nonlocal is_connected
            with self._changed:
                is_connected = True
                self._changed.notify_all()

        channel = self._connection.stream_channel
        with self._connection.reachability.connecting(connected, channel), self._changed:
            self._changed.wait_for(lambda: self._closing or is_connected, seconds)
            return self._closing

    def _read_one_rpc(self) -> Optional[float]:
        """Reads an rpc to its end. Returns the seconds to wait before the next rpc; None: it was the last."""
        goaway: Any = None
        with self._changed:
            if self._closing:
                return None
            self._hello_at = None
            call = self._call = self._open()
        try:
            for event in call:
                if event.WhichOneof("event") == "goaway":
                    goaway = event.goaway
                    self._end_requests()
                else:
                    self._take(event)
        except grpc.RpcError as rpc_error:
            if goaway is None:
                return self._pause_after(LatticedError.from_rpc(rpc_error, self._connection.address))
        finally:
            call.cancel()
            self._surface.drop_partial_update()
        if goaway is None:
            return None
        headers = dict(call.initial_metadata() or ())
        return self._pause_of(goaway, str(headers.get("latticed-request-id", "")))

    def _pause_of(self, goaway: Any, request_id: str) -> Optional[float]:
        """The seconds that the server asks for, or the error that it names; a proxy may replace the call's own."""
        if goaway.status.code != 0:
            return self._pause_after(LatticedError.from_status(goaway.status, request_id))
        return goaway.retry_after.seconds + 1e-9 * goaway.retry_after.nanos

    def _pause_after(self, error: LatticedError) -> Optional[float]:
        with self._changed:
            if self._closing:
                return None
            if self._hello_at is not None and time.monotonic() - self._hello_at > _WORKS_SECONDS:
                self._attempts.succeeded()
            pause = self._attempts.pause_after(error)
            if pause is None:
                raise error
            return pause

    def _take_presence(self, presence: Any) -> None:
        with self._changed:
            if presence.left:
                self._others.pop(presence.editor_id, None)
            else:
                self._others[presence.editor_id] = Presence.from_proto(presence)
            self._changed.notify_all()

    def _take(self, event: Any) -> None:
        arm = event.WhichOneof("event")
        if arm == "hello":
            self._hello = event.hello
            self._hello_at = time.monotonic()
            with self._changed:
                self._others.clear()  # the server sends the presence of all editors after hello
            self._begin()
        elif arm == "presence":
            self._take_presence(event.presence)
        elif arm == "heartbeat":
            self._answer_heartbeat()
        elif arm == "edit_result":
            self._take_result(event.edit_result)
        else:
            update = self._surface.apply(event)
            if update is not None:
                with self._changed:
                    self._complete(update, event.update_end)
                    self._changed.notify_all()
                self._acknowledge(event.update_end.update_id)
