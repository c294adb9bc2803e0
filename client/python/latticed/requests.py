# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The requests that a client writes to a Deform stream."""
from __future__ import annotations

import queue
from typing import Iterator, Optional

from latticed.v1 import edit_pb2, event_pb2, scene_pb2


class Requests:
    """A queue that grpc reads from a thread of its own until finish. Any number of threads may write."""

    def __init__(self, watch: scene_pb2.WatchRequest) -> None:
        self._queue: queue.SimpleQueue[Optional[scene_pb2.DeformRequest]] = queue.SimpleQueue()
        self._queue.put(scene_pb2.DeformRequest(watch=watch))

    def edit(self, batch: edit_pb2.EditBatch) -> None:
        self._queue.put(scene_pb2.DeformRequest(edit=batch))

    def control(self, control: scene_pb2.ControlWatchRequest) -> None:
        self._queue.put(scene_pb2.DeformRequest(control=control))

    def presence(self, presence: event_pb2.Presence) -> None:
        self._queue.put(scene_pb2.DeformRequest(presence=presence))

    def heartbeat(self) -> None:
        self._queue.put(scene_pb2.DeformRequest(heartbeat=event_pb2.Heartbeat()))

    def finish(self) -> None:
        """No more requests: half-closes the stream, and lets grpc's thread go."""
        self._queue.put(None)

    def __iter__(self) -> Iterator[scene_pb2.DeformRequest]:
        return iter(self._queue.get, None)
