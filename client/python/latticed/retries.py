# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Calls that are made again while a server does not answer.

The pause after failure n is min(100 ms * 2**(n - 1), 1 s) * r with r uniform in [0.75, 1.25], so at most 1.25 s. It ends
earlier when the channel has connected again. The factor r keeps the clients of a server that died from coming back all at
once. It is not uniform in [0, 1], because short pauses would only load a server that starts.
"""
import logging
import random
import threading
import time
from contextlib import contextmanager
from typing import Any, Callable, Iterator, List, Optional, TypeVar

import grpc

from latticed.errors import LatticedError

# If a proxy cuts a call, gRPC reports CANCELLED, or UNKNOWN if the stream ends without a status. For a broken
# transport it reports INTERNAL.
_MAY_RETRY = (
    grpc.StatusCode.CANCELLED,
    grpc.StatusCode.INTERNAL,
    grpc.StatusCode.UNAVAILABLE,
    grpc.StatusCode.UNKNOWN,
)
_ERRORS_OF_SERVERS = (grpc.StatusCode.INTERNAL, grpc.StatusCode.UNKNOWN)
# gRPC tells these causes only in its messages: something else is at the address, or TLS does not fit.
_PERMANENT = ("http1.x server", "wrong version number", "empty address list", "CERTIFICATE_VERIFY_FAILED")
_FIRST_PAUSE = 0.1
_LONGEST_PAUSE = 1.0
_MOST_DOUBLINGS = 10
_TOLD_AFTER = 2  # failures; one is usual where a proxy cuts connections

Result = TypeVar("Result")

_log = logging.getLogger("latticed")


def may_retry(error: LatticedError) -> bool:
    """Whether another attempt at the call may succeed. Not where a server itself answered INTERNAL or UNKNOWN."""
    if error.code in _ERRORS_OF_SERVERS and error.request_id:
        return False
    return error.code in _MAY_RETRY and not any(cause in error.message for cause in _PERMANENT)


def pause_after(failures: int) -> float:
    """The pause in seconds after the given number of failures in a row, 1 or more."""
    doublings = min(failures - 1, _MOST_DOUBLINGS)
    return min(_FIRST_PAUSE * 2.0**doublings, _LONGEST_PAUSE) * random.uniform(0.75, 1.25)


class Reachability:
    """What the calls and streams of a client know of its server. The logger "latticed" says when the server does not
    answer and when it does again. Any number of threads may use it."""

    def __init__(self, channel: grpc.Channel, address: str, retry_for: float) -> None:
        self._channel = channel
        self.address = address
        self.retry_for = retry_for
        self._lock = threading.Lock()
        self._lost = False
        self._closed = False

    def lost(self) -> None:
        """Called when the client tries again."""
        if self._becomes(True):
            _log.warning("server %s unreachable, trying for %g s …", self.address, self.retry_for)

    def found(self) -> None:
        """Called when the server has answered."""
        if self._becomes(False):
            _log.warning("server %s answers again", self.address)

    def gave_up(self) -> None:
        """Called when the time is over. The caller raises the error."""
        self._becomes(False)

    @contextmanager
    def connecting(
        self, connected: Callable[[], None], channel: Optional[grpc.Channel] = None
    ) -> Iterator[None]:
        """A block in which `connected` is called when the channel, which the last call told to connect, has connected;
        not if it is connected from the begin. `channel`: the one of streams; None: the one of all other calls.

        Without it a connection that came up in a pause is seen up to 5 s later: gRPC handles the events of its
        sockets in threads that wait for calls or for the channel's state, and otherwise only so often."""
        states: List[Any] = []

        def changed(state: Any) -> None:
            states.append(state)
            if state is grpc.ChannelConnectivity.READY and len(states) > 1:  # the first is the present one
                connected()

        if self._closed:
            yield
            return
        channel = channel or self._channel
        channel.subscribe(changed)
        try:
            yield
        finally:
            channel.unsubscribe(changed)

    def close(self) -> None:
        """Called before the channel is closed: it has no state from then on."""
        self._closed = True

    def _becomes(self, lost: bool) -> bool:
        """Returns whether that is a change."""
        with self._lock:
            changes, self._lost = self._lost != lost, lost
            return changes


class Attempts:
    """The failures in a row of one call or stream. One thread at a time may use it."""

    def __init__(self, server: Reachability) -> None:
        self._server = server
        self._failures = 0
        self._first_failure = 0.0

    def pause_after(self, error: LatticedError) -> Optional[float]:
        """Called after a failure. Returns the seconds to wait before the next attempt; None if another cannot
        help, or would begin more than retry_for seconds after the first failure."""
        if not may_retry(error):
            self.succeeded()  # the server has answered
            return None
        now = time.monotonic()
        self._failures += 1
        if self._failures == 1:
            self._first_failure = now
        pause = pause_after(self._failures)
        if now + pause > self._first_failure + self._server.retry_for:
            self._server.gave_up()
            return None
        if self._failures >= _TOLD_AFTER:
            self._server.lost()
        return pause

    def succeeded(self) -> None:
        """Called after a success. The next failure is the first again."""
        self._failures = 0
        self._server.found()


def with_retries(server: Reachability, call: Callable[[], Result]) -> Result:
    """Makes an idempotent call until it succeeds, or Attempts has no other attempt. Converts grpc.RpcError to
    LatticedError."""
    attempts = Attempts(server)
    while True:
        try:
            result = once(server.address, call)
        except LatticedError as error:
            pause = attempts.pause_after(error)
            if pause is None:
                raise
        else:
            attempts.succeeded()
            return result
        connected = threading.Event()
        with server.connecting(connected.set):
            connected.wait(pause)


def once(address: str, call: Callable[[], Result]) -> Result:
    """Makes a call to the server at an address. Converts grpc.RpcError to LatticedError."""
    try:
        return call()
    except grpc.RpcError as error:
        raise LatticedError.from_rpc(error, address) from error
