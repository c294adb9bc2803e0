# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""A channel to one server, with the metadata that every call carries."""
from __future__ import annotations

import logging
import os
from functools import partial
from pathlib import Path
from typing import Any, Callable, List, Optional, Tuple, Union

import grpc

from latticed.encoding_choice import EncodingChoice, measured_choice
from latticed.errors import LatticedError
from latticed.retries import Reachability, once, with_retries
from latticed.v1 import (
    backup_pb2_grpc,
    mesh_pb2_grpc,
    points_pb2_grpc,
    scene_pb2_grpc,
    server_pb2,
    server_pb2_grpc,
    share_pb2_grpc,
)

# PEM, as bytes or as the path of a file.
Pem = Union[bytes, str, "os.PathLike[str]"]

_OPTIONS = [
    # By default gRPC pauses 1 s before it reconnects, and later up to two minutes. Calls fail meanwhile, so its
    # pauses are shorter than ours: each of our attempts is then one to connect.
    ("grpc.initial_reconnect_backoff_ms", 100),
    ("grpc.max_reconnect_backoff_ms", 500),
    # How long one attempt to connect may take: by default 20 s, which an unplugged network would cost.
    ("grpc.min_reconnect_backoff_ms", 3000),
]
# Pings notice a silently lost connection.
_PATIENT = [("grpc.keepalive_time_ms", 30000), ("grpc.keepalive_timeout_ms", 10000)]
# Of streams, on which the server sends heartbeats every 0.6 s: a silence of 0.8 s is suspicious, and a ping must be
# answered in 0.7 s. A busy line, slow as it may be, is not silent. Other calls have no heartbeats, and while a slow line is
# busy with an upload, nothing comes back for seconds. So they have a channel of their own.
_ATTENTIVE = [
    ("grpc.keepalive_time_ms", 800),
    ("grpc.keepalive_timeout_ms", 700),
    # Where heartbeats are rarer, pings go on: gRPC would stop after two.
    ("grpc.http2.max_pings_without_data", 0),
]


_LOG = logging.getLogger("latticed")
_PROBE_SECONDS = 5.0


def _read(pem: Pem | None) -> bytes | None:
    return pem if pem is None or isinstance(pem, bytes) else Path(pem).read_bytes()


class Connection:
    """Stubs and metadata. Any number of threads may use it."""

    def __init__(
        self,
        address: str,
        token: str | None,
        tls: bool,
        tls_ca: Pem | None,
        tls_cert: Pem | None,
        tls_key: Pem | None,
        retry_for: float,
    ) -> None:
        self.address = address
        self._token = token
        if tls or tls_ca is not None or tls_cert is not None:
            credentials = grpc.ssl_channel_credentials(_read(tls_ca), _read(tls_key), _read(tls_cert))
            open_channel = partial(grpc.secure_channel, address, credentials)
        else:
            open_channel = partial(grpc.insecure_channel, address)
        self._channels = [open_channel(options=_OPTIONS + more) for more in (_PATIENT, _ATTENTIVE)]
        self._channel, self.stream_channel = self._channels
        self._choice: Optional[EncodingChoice] = None
        self.reachability = Reachability(self._channel, address, retry_for)
        self.server: Any = server_pb2_grpc.ServerServiceStub(self._channel)  # type: ignore[no-untyped-call]
        self.meshes: Any = mesh_pb2_grpc.MeshServiceStub(self._channel)  # type: ignore[no-untyped-call]
        self.scenes: Any = scene_pb2_grpc.SceneServiceStub(self._channel)  # type: ignore[no-untyped-call]
        self.shares: Any = share_pb2_grpc.ShareServiceStub(self._channel)  # type: ignore[no-untyped-call]
        self.backups: Any = backup_pb2_grpc.BackupServiceStub(self._channel)  # type: ignore[no-untyped-call]
        self.points: Any = points_pb2_grpc.PointSetServiceStub(self._channel)  # type: ignore[no-untyped-call]
        # For Deform, Watch and ControlWatch.
        self.streams: Any = scene_pb2_grpc.SceneServiceStub(self.stream_channel)  # type: ignore[no-untyped-call]

    def metadata(self, scene: str = "") -> List[Tuple[str, str]]:
        """The metadata of a call; `scene` is its routing key, or empty where the call names no scene."""
        pairs = [("latticed-scene", scene)] if scene else []
        if self._token:
            pairs.append(("authorization", f"Bearer {self._token}"))
        return pairs

    def call(self, method: Callable[..., Any], request: Any, scene: str = "") -> Any:
        """Makes an idempotent unary call, again while the server does not answer: see Attempts."""
        return with_retries(self.reachability, lambda: method(request, metadata=self.metadata(scene)))

    def call_once(self, method: Callable[..., Any], request: Any, scene: str = "") -> Any:
        """Makes a unary call with one attempt, for deletions: a second attempt would find nothing."""
        return once(self.address, lambda: method(request, metadata=self.metadata(scene)))

    def encoding_choice(self) -> EncodingChoice:
        """Measured at the first call that succeeds; Draco until then. The logger "latticed" says it."""
        if self._choice is None:
            try:
                self._choice = measured_choice(self._probe)
            except LatticedError as error:
                return EncodingChoice("draco", f"the line could not be measured: {error}")
            _LOG.info("points come by %s where no encoding is named: %s", *self._choice)
        return self._choice

    def _probe(self, size: int) -> Any:
        request = server_pb2.GetServerInfoRequest(probe_bytes=size)
        return once(
            self.address,
            lambda: self.server.GetServerInfo(request, metadata=self.metadata(), timeout=_PROBE_SECONDS),
        )

    def close(self) -> None:
        """Ends all calls."""
        self.reachability.close()
        for channel in self._channels:
            channel.close()
