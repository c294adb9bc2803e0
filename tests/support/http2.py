# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# HTTP/2 frames written by hand, over TLS or plain TCP: a gRPC client that can break every rule.
import socket
import ssl
import time

from hpack import Decoder, field

DATA, HEADERS, RST_STREAM, SETTINGS, PING, WINDOW_UPDATE, CONTINUATION = 0, 1, 3, 4, 6, 8, 9
ACK, END_STREAM, END_HEADERS = 1, 1, 4
INITIAL_WINDOW_SIZE, TRUE_BINARY_METADATA = 4, 0xFE03
PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"
EMPTY_MESSAGE = bytes(5)
PATIENCE_S, TICK_S = 10, 0.1
MOST_FRAME_BYTES = 16_384


def frame(kind, flags, stream, payload=b""):
    return len(payload).to_bytes(3, "big") + bytes([kind, flags]) + stream.to_bytes(4, "big") + payload


def message(payload):
    """An uncompressed gRPC message."""
    return b"\0" + len(payload).to_bytes(4, "big") + payload


def messages(data):
    """The payloads of the whole messages in `data`."""
    found, at = [], 0
    while len(data) >= at + 5:
        end = at + 5 + int.from_bytes(data[at + 1 : at + 5], "big")
        if len(data) < end:
            break
        found.append(bytes(data[at + 5 : end]))
        at = end
    return found


def head(method, more=(), scheme="https"):
    """The header block of a call, with `more` fields. A method that does not begin with / is of latticed.v1."""
    fields = {
        ":method": "POST",
        ":scheme": scheme,
        ":path": method if method.startswith("/") else "/latticed.v1." + method,
        ":authority": "localhost",
        "te": "trailers",
        "content-type": "application/grpc",
    }
    return b"".join(field(*pair) for pair in [*fields.items(), *more])


class Connection:
    """A connection from the address `source`, over TLS if there is a `ca`. `window` is the initial flow-control
    window of each answer; with 0 the connection takes no bytes of answers. `token` goes with each call."""

    def __init__(self, port, ca=None, source="127.0.0.1", window=65_535, token=None):
        self.socket = socket.create_connection(("127.0.0.1", port), PATIENCE_S, (source, 0))
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if ca:
            context = ssl.create_default_context(cafile=ca)
            context.set_alpn_protocols(["h2"])
            self.socket = context.wrap_socket(self.socket, server_hostname="localhost")
        self.scheme = "https" if ca else "http"
        self.fields = [("authorization", "Bearer " + token)] if token else []
        self.next_stream = 1
        self.heard = bytearray()
        self.decoder = Decoder()
        self.status = {}  # by stream: the grpc-status of calls that have one
        self.trailers = {}  # by stream: all fields that came
        self.data = {}  # by stream: what came of the answer's messages, if `keeps_data`
        self.keeps_data = True
        self.ended = set()
        self.takes_data = window > 0
        # Bytes that the other side takes: by stream, and in all (stream 0).
        self.initial_window = 65_535
        self.windows = {0: 65_535}
        settings = [(INITIAL_WINDOW_SIZE, window), (TRUE_BINARY_METADATA, 1)]
        payload = b"".join(name.to_bytes(2, "big") + value.to_bytes(4, "big") for name, value in settings)
        self.send(PREFACE + frame(SETTINGS, 0, 0, payload))

    def send(self, frames):
        self.socket.sendall(frames)

    def reply(self, frames):
        """Sends frames that the other side needs only if it is still there."""
        try:
            self.socket.settimeout(PATIENCE_S)
            self.socket.sendall(frames)
        except OSError:
            pass

    def begin(self, method, more=(), flags=END_HEADERS):
        """Sends the header of a call. Returns its stream."""
        stream = self.next_stream
        self.next_stream += 2
        self.windows[stream] = self.initial_window
        self.send(frame(HEADERS, flags, stream, head(method, [*self.fields, *more], self.scheme)))
        return stream

    def call(self, method, request=EMPTY_MESSAGE, more=()):
        """Makes a whole call. Returns its grpc-status."""
        stream = self.begin(method, more)
        self.send_data(stream, request)
        return self.ending(stream)

    def send_data(self, stream, data, flags=END_STREAM):
        """Sends data as the other side takes it, until that is all or the call has ended."""
        at = 0
        deadline = time.monotonic() + PATIENCE_S
        while True:
            size = min(len(data) - at, self.windows[0], self.windows[stream], MOST_FRAME_BYTES)
            if size > 0 or at == len(data):
                last = at + size == len(data)
                self.send(frame(DATA, flags if last else 0, stream, data[at : at + size]))
                at += size
                self.windows[0] -= size
                self.windows[stream] -= size
                deadline = time.monotonic() + PATIENCE_S
                if last:
                    return
            elif time.monotonic() > deadline or not self.hear():
                raise ConnectionError(f"nobody takes the data of call {stream}")
            if stream in self.ended:
                return

    def ending(self, stream, patience=PATIENCE_S):
        """Waits for the end of a call. Returns its grpc-status."""
        deadline = time.monotonic() + patience
        while stream not in self.ended:
            if time.monotonic() > deadline or not self.hear():
                raise ConnectionError(f"the connection closed before call {stream} ended")
        return self.status.get(stream)

    def hear(self, tick=TICK_S):
        """Reads what has come, or waits up to 0.1 s. Returns False once the connection is closed."""
        try:
            self.socket.settimeout(tick)
            heard = self.socket.recv(1 << 18)
            self.socket.settimeout(PATIENCE_S)
            self.heard += heard
            at = 0
            while len(self.heard) >= at + 9:
                size = 9 + int.from_bytes(self.heard[at : at + 3], "big")
                if len(self.heard) < at + size:
                    break
                stream = int.from_bytes(self.heard[at + 5 : at + 9], "big")
                payload = bytes(self.heard[at + 9 : at + size])
                self.take(self.heard[at + 3], self.heard[at + 4], stream, payload)
                at += size
            del self.heard[:at]
        except TimeoutError:
            self.socket.settimeout(PATIENCE_S)
            return True
        except OSError:
            return False
        return bool(heard)

    def take(self, kind, flags, stream, payload):
        if kind == SETTINGS and not flags & ACK:
            self.take_settings(payload)
        elif kind == PING and not flags & ACK:
            self.reply(frame(PING, ACK, 0, payload))
        elif kind == WINDOW_UPDATE:
            window = self.windows.get(stream, self.initial_window)
            self.windows[stream] = window + int.from_bytes(payload, "big")
        elif kind == HEADERS:
            fields = self.decoder.decode(payload)
            self.trailers.setdefault(stream, {}).update(fields)
            if b"grpc-status" in fields:
                self.status[stream] = int(fields[b"grpc-status"])
        elif kind == DATA and payload:
            if self.keeps_data:
                self.data.setdefault(stream, bytearray()).extend(payload)
            if self.takes_data:
                more = len(payload).to_bytes(4, "big")
                self.reply(frame(WINDOW_UPDATE, 0, 0, more) + frame(WINDOW_UPDATE, 0, stream, more))
        if kind == RST_STREAM or (kind in (HEADERS, DATA) and flags & END_STREAM):
            self.ended.add(stream)

    def take_settings(self, payload):
        for at in range(0, len(payload), 6):
            if int.from_bytes(payload[at : at + 2], "big") == INITIAL_WINDOW_SIZE:
                size = int.from_bytes(payload[at + 2 : at + 6], "big")
                for stream in self.windows:
                    self.windows[stream] += (size - self.initial_window) if stream else 0
                self.initial_window = size
        self.reply(frame(SETTINGS, ACK, 0))

    def is_closed(self, seconds=PATIENCE_S):
        """Whether the other side closes the connection within that time."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            if not self.hear():
                return True
        return False

    def close(self):
        self.socket.close()
