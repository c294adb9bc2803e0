# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Watching without edits, for which a read token suffices."""
from __future__ import annotations

from typing import Any

from latticed.errors import LatticedError
from latticed.update_stream import UpdateStream
from latticed.v1 import scene_pb2
from latticed.view import View

_CONTROL_SECONDS = 10.0


class WatchStream(UpdateStream):
    """See UpdateStream; made by Scene.watch."""

    def set_view(self, view: View) -> None:
        """What updates show from the next one on."""
        options = view.for_watching(self._scene_default)
        with self._changed:
            self._watch.view.CopyFrom(options)
        self._control(scene_pb2.ControlWatchRequest(view=options))

    def pause(self, paused: bool = True) -> None:
        """Stops updates, or lets them go on."""
        self._control(scene_pb2.ControlWatchRequest(pause=paused))

    def _open(self) -> Any:
        metadata = self._connection.metadata(self._watch.scene)
        return self._connection.scenes.Watch(self._watch, metadata=metadata)

    def _acknowledge(self, update_id: int) -> None:
        self._try_to_control(scene_pb2.ControlWatchRequest(acked_update_id=update_id))

    def _answer_heartbeat(self) -> None:
        self._try_to_control(scene_pb2.ControlWatchRequest())

    def _try_to_control(self, request: scene_pb2.ControlWatchRequest) -> None:
        try:
            self._control(request)
        except LatticedError:
            pass  # a stream that has broken opens itself again, and one that has not goes on

    def _control(self, request: scene_pb2.ControlWatchRequest) -> None:
        request.scene, request.watch_id = self._watch.scene, self._hello.watch_id

        def control(message: Any, metadata: Any) -> Any:
            return self._connection.scenes.ControlWatch(message, metadata=metadata, timeout=_CONTROL_SECONDS)

        self._connection.call_once(control, request, self._watch.scene)
