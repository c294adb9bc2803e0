# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# HTTP/2 frames written by hand, over TLS: a gRPC client that can break every rule.
import re
import socket
import ssl
import time

DATA, HEADERS, RST_STREAM, SETTINGS, PING, WINDOW_UPDATE, CONTINUATION = 0, 1, 3, 4, 6, 8, 9
ACK, END_STREAM, END_HEADERS = 1, 1, 4
INITIAL_WINDOW_SIZE = 4
EMPTY_MESSAGE = bytes(5)
PATIENCE_S, TICK_S = 10, 0.1


def frame(kind, flags, stream, payload=b""):
    return len(payload).to_bytes(3, "big") + bytes([kind, flags]) + stream.to_bytes(4, "big") + payload


def field(name, value):
    """A literal field without indexing (RFC 7541). Name and value must be shorter than 127 bytes."""
    texts = [name.encode(), value.encode()]
    return b"\0" + b"".join(bytes([len(text)]) + text for text in texts)


def message(payload):
    """An uncompressed gRPC message."""
    return b"\0" + len(payload).to_bytes(4, "big") + payload


def head(method, more=()):
    """The header block of a call of latticed.v1, with `more` fields."""
    fields = {
        ":method": "POST",
        ":scheme": "https",
        ":path": "/latticed.v1." + method,
        ":authority": "localhost",
        "te": "trailers",
        "content-type": "application/grpc",
    }
    return b"".join(field(*pair) for pair in [*fields.items(), *more])


class Connection:
    """A connection from the address `source`. `window` is the initial flow-control window of each answer."""

    def __init__(self, port, ca, source="127.0.0.1", window=65_535):
        context = ssl.create_default_context(cafile=ca)
        context.set_alpn_protocols(["h2"])
        plain = socket.create_connection(("127.0.0.1", port), PATIENCE_S, (source, 0))
        plain.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket = context.wrap_socket(plain, server_hostname="localhost")
        self.next_stream = 1
        self.heard = b""
        self.status = {}  # by stream: the grpc-status of calls that have one
        self.ended = set()
        settings = INITIAL_WINDOW_SIZE.to_bytes(2, "big") + window.to_bytes(4, "big")
        self.send(b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + frame(SETTINGS, 0, 0, settings))

    def send(self, frames):
        self.socket.sendall(frames)

    def begin(self, method, more=(), flags=END_HEADERS):
        """Sends the header of a call. Returns its stream."""
        stream = self.next_stream
        self.next_stream += 2
        self.send(frame(HEADERS, flags, stream, head(method, more)))
        return stream

    def call(self, method, request=EMPTY_MESSAGE, more=()):
        """Makes a whole call. Returns its grpc-status."""
        stream = self.begin(method, more)
        self.send(frame(DATA, END_STREAM, stream, request))
        return self.ending(stream)

    def ending(self, stream):
        deadline = time.monotonic() + PATIENCE_S
        while stream not in self.ended:
            if time.monotonic() > deadline or not self.hear():
                raise ConnectionError(f"the connection closed before call {stream} ended")
        return self.status.get(stream)

    def hear(self):
        """Reads what has come, or waits up to 0.1 s. Returns False once the connection is closed."""
        try:
            self.socket.settimeout(TICK_S)
            heard = self.socket.recv(1 << 16)
            self.socket.settimeout(PATIENCE_S)
            self.heard += heard
            while len(self.heard) >= 9:
                size = 9 + int.from_bytes(self.heard[:3], "big")
                if len(self.heard) < size:
                    break
                stream = int.from_bytes(self.heard[5:9], "big")
                self.take(self.heard[3], self.heard[4], stream, self.heard[9:size])
                self.heard = self.heard[size:]
        except TimeoutError:
            return True
        except OSError:
            return False
        return bool(heard)

    def take(self, kind, flags, stream, payload):
        if kind in (SETTINGS, PING) and not flags & ACK:
            self.send(frame(kind, ACK, 0, payload if kind == PING else b""))
        elif kind == HEADERS:
            # HAProxy writes names and values of fields without Huffman coding.
            status = re.search(rb"grpc-status[\x01-\x02](\d+)", payload)
            if status:
                self.status[stream] = int(status[1])
        if kind == RST_STREAM or (kind in (HEADERS, DATA) and flags & END_STREAM):
            self.ended.add(stream)

    def is_closed(self, seconds=PATIENCE_S):
        """Whether the other side closes the connection within that time."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            if not self.hear():
                return True
        return False

    def close(self):
        self.socket.close()
