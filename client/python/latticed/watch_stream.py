# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Watching without edits, for which a token of role read suffices."""
from __future__ import annotations

from typing import Any, Optional, Sequence

import grpc

from latticed.camera import Camera
from latticed.errors import LatticedError
from latticed.presence import Presence
from latticed.retries import once
from latticed.update_stream import UpdateStream
from latticed.v1 import scene_pb2
from latticed.view import View

_CONTROL_SECONDS = 10.0


class WatchStream(UpdateStream):
    """See UpdateStream; made by Scene.watch."""

    def set_view(self, view: View) -> None:
        """Changes the view, from the next update on."""
        options = self._options(view)
        self._control(scene_pb2.ControlWatchRequest(view=options))
        with self._changed:
            self._watch.view.CopyFrom(options)

    def pause(self, paused: bool = True) -> None:
        """Stops updates. paused=False lets them go on."""
        self._paused = paused
        self._control(scene_pb2.ControlWatchRequest(pause=paused))

    def show(
        self,
        name: str = "",
        colour: int = 0,
        selected: Sequence[int] = (),
        camera: Optional[Camera] = None,
        following: str = "",
        lattice: int = 0,
    ) -> None:
        """Shows others who this watch's editor is, until the stream ends: see Presence. Needs role edit."""
        presence = Presence(name, colour, tuple(selected), camera, following, lattice)
        message = presence.to_proto()
        self._shown = presence
        self._control(scene_pb2.ControlWatchRequest(presence=message))

    def _open(self) -> Any:
        metadata = self._connection.metadata(self._watch.scene)
        return self._connection.streams.Watch(self._watch, metadata=metadata)

    def _begin(self) -> None:
        if self._paused:
            self._control(scene_pb2.ControlWatchRequest(pause=True))
        if self._shown is not None:
            self._control(scene_pb2.ControlWatchRequest(presence=self._shown.to_proto()))

    def _acknowledge(self, update_id: int) -> None:
        self._control(scene_pb2.ControlWatchRequest(acked_update_id=update_id))

    def _answer_heartbeat(self) -> None:
        self._control(scene_pb2.ControlWatchRequest())

    def _control(self, request: scene_pb2.ControlWatchRequest) -> None:
        request.scene, request.watch_id = self._watch.scene, self._hello.watch_id
        metadata = self._connection.metadata(self._watch.scene)
        try:
            once(
                self._connection.address,
                lambda: self._connection.streams.ControlWatch(
                    request, metadata=metadata, timeout=_CONTROL_SECONDS
                ),
            )
        except LatticedError as error:
            # Other errors are ignored: a broken stream opens itself again with the newest view, and an intact
            # one goes on.
            if error.code in (grpc.StatusCode.INVALID_ARGUMENT, grpc.StatusCode.RESOURCE_EXHAUSTED):
                raise
