# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# many_connections.py LATTICED CONNECTIONS [RATE]: a server with so many connections, silent at first,
# then with RATE small calls a second on each (1). Prints what all of the server takes of a core, and
# what its thread that guards connections does; then how long one lives beside them that has more
# calls open than it may. HTTP/2 by hand: gRPC's clients break no rules, and would be the bottleneck.
import os
import pathlib
import re
import selectors
import socket
import subprocess
import sys
import time
from concurrent import futures

SETTLE_S, MEASURE_S = 3, 15
GUARD = "call-guard\n"
DATA, HEADERS, RST_STREAM, SETTINGS, PING, WINDOW_UPDATE = 0, 1, 3, 4, 6, 8
ACK, END_STREAM, END_HEADERS = 1, 1, 4
MOST_WINDOW = 2**31 - 1 - 65_535


def frame(kind, flags, stream, payload=b""):
    return len(payload).to_bytes(3, "big") + bytes([kind, flags]) + stream.to_bytes(4, "big") + payload


def head(method, authority="bench"):
    """The fields of a call, RFC 7541: literal, not indexed."""
    fields = {
        ":method": "POST",
        ":scheme": "http",
        ":path": "/latticed.v1." + method,
        ":authority": authority,
        "te": "trailers",
        "content-type": "application/grpc",
    }
    texts = [text.encode() for field in fields.items() for text in field]
    sized = [bytes([len(text)]) + text for text in texts]
    return b"".join(b"\0" + name + value for name, value in zip(sized[::2], sized[1::2]))


class Connection:
    """Makes calls, and hears no more of the answers than it must."""

    def __init__(self, port, acknowledges=True, wrap=lambda plain: plain, authority="bench"):
        plain = socket.create_connection(("127.0.0.1", port))
        plain.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket = wrap(plain)
        self.acknowledges = acknowledges
        self.authority = authority
        self.stream = 1
        self.ended = (0, None)  # the last stream that was ended from there, and by what kind of frame
        self.heard = b""
        self.socket.sendall(
            b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"
            + frame(SETTINGS, 0, 0)
            + frame(WINDOW_UPDATE, 0, 0, MOST_WINDOW.to_bytes(4, "big"))
        )

    def begin(self, method, count=1, more=b""):
        fields = head(method, self.authority) + more
        frames = [frame(HEADERS, END_HEADERS, self.stream + 2 * i, fields) for i in range(count)]
        self.socket.sendall(b"".join(frames))
        self.stream += 2 * count

    def call(self, method):
        self.begin(method)
        self.socket.sendall(frame(DATA, END_STREAM, self.stream - 2, bytes(5)))

    def hear(self):
        """False once the server has closed it."""
        try:
            heard = self.socket.recv(1 << 16)
        except ConnectionResetError:
            heard = b""
        self.heard += heard
        while len(self.heard) >= 9:
            size = 9 + int.from_bytes(self.heard[:3], "big")
            if len(self.heard) < size:
                break
            kind, flags, payload = self.heard[3], self.heard[4], self.heard[9:size]
            if kind == RST_STREAM or (kind in (DATA, HEADERS) and flags & END_STREAM):
                self.ended = (int.from_bytes(self.heard[5:9], "big"), kind)
            self.heard = self.heard[size:]
            if self.acknowledges and kind in (SETTINGS, PING) and not flags & ACK:
                self.socket.sendall(frame(kind, ACK, 0, payload if kind == PING else b""))
        return bool(heard)


def cpu_seconds(pid):
    """Of the process, and of its guard."""
    process = pathlib.Path(f"/proc/{pid}")
    ticks = sum(map(int, (process / "stat").read_text().rsplit(")", 1)[1].split()[11:13]))
    guard = next(t for t in (process / "task").iterdir() if (t / "comm").read_text() == GUARD)
    nanoseconds = int((guard / "schedstat").read_text().split()[0])
    return ticks / os.sysconf("SC_CLK_TCK"), nanoseconds * 1e-9


class Crowd:
    """Connections that make calls at an even pace, each in its turn."""

    def __init__(self, port, count):
        self.connections = [Connection(port) for _ in range(count)]
        self.next = 0
        self.selector = selectors.DefaultSelector()
        for connection in self.connections:
            self.selector.register(connection.socket, selectors.EVENT_READ, connection)

    def drive(self, rate, done):
        """Until done(), with `rate` calls a second on each; how many there were."""
        start, calls = time.monotonic(), 0
        while not done():
            due = int((time.monotonic() - start) * rate * len(self.connections))
            for _ in range(due - calls):
                self.connections[self.next].call("ServerService/GetServerInfo")
                self.next = (self.next + 1) % len(self.connections)
            calls = due
            for key, _ in self.selector.select(0.005):
                if not key.data.hear():
                    sys.exit("the server has closed a connection")
        return calls

    def drive_for(self, rate, seconds):
        end = time.monotonic() + seconds
        return self.drive(rate, lambda: time.monotonic() > end)


def measure(pid, crowd, rate):
    """Prints shares of a core while each connection makes `rate` calls a second."""
    crowd.drive_for(rate, SETTLE_S)
    before, start = cpu_seconds(pid), time.monotonic()
    calls = crowd.drive_for(rate, MEASURE_S)
    after, seconds = cpu_seconds(pid), time.monotonic() - start
    server, guard = ((b - a) / seconds for a, b in zip(before, after))
    print(
        f"{len(crowd.connections)} connections, {calls / seconds:.0f} calls a second:"
        f" of a core the server takes {server:.1%}, its guard {guard:.2%}"
    )


def life(port, calls):
    """Seconds from so many unfinished calls to the end of their connection."""
    connection = Connection(port, acknowledges=False)
    connection.hear()
    start = time.monotonic()
    connection.begin("SceneService/ApplyEdits", calls)
    while connection.hear():
        pass
    return time.monotonic() - start


def main(program, count, rate=1.0):
    flags = ["--listen", "127.0.0.1:0", "--insecure", "--backend", "cpu", "--drain-delay", "0s"]
    server = subprocess.Popen(
        [program, *flags, "--max-connections", str(count + 2)],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    try:
        address = (re.search(r"serving address=127\.0\.0\.1:(\d+)", line) for line in server.stdout)
        port = int(next(filter(None, address))[1])
        with futures.ProcessPoolExecutor(1) as other:
            crowd = Crowd(port, count)
            measure(server.pid, crowd, 0.0)
            measure(server.pid, crowd, rate)
            for calls in (129, 257):
                lives = [other.submit(life, port, calls) for _ in range(5)]
                crowd.drive(rate, lambda: all(one.done() for one in lives))
                seconds = sorted(one.result() for one in lives)
                print(f"{calls} calls open: cut after {seconds[0]:.3f} to {seconds[-1]:.3f} s")
    finally:
        server.terminate()
        server.wait()


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), *map(float, sys.argv[3:]))
