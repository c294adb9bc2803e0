# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# attacks.py PORT CUT_PORT CA ADMIN SCENE: hostile clients attack two proxies on localhost: the one at PORT, and
# the one at CUT_PORT, which after 2 s cuts clients that read nothing. ADMIN is the host:port of the server's
# metrics; the server has the scene. Each attack has its own client address and process. Meanwhile an honest
# client makes calls, and each must be answered.
import multiprocessing
import re
import sys
import time
import urllib.request

from hpack import field
from http2 import (
    CONTINUATION,
    DATA,
    END_HEADERS,
    END_STREAM,
    HEADERS,
    PING,
    RST_STREAM,
    Connection,
    frame,
    head,
    message,
)

INFO = "ServerService/GetServerInfo"
MOST_S = 20  # longest time of one attack
FLOOD_S = 2
ANSWER_S = 2  # longest time of an answer to the honest client
CANCEL = (8).to_bytes(4, "big")
CLOSED = (ConnectionError, OSError)


def expect(condition, what):
    if not condition:
        raise SystemExit(f"attacks.py: {what}")


class Attack:
    def __init__(self, port, ca, source):
        self.port, self.ca, self.source = port, ca, source

    def connect(self, **options):
        return Connection(self.port, self.ca, self.source, **options)

    def flood(self, connection, frames):
        """Sends the frames repeatedly and reads nothing. Returns False if the proxy closed the connection."""
        end = time.monotonic() + FLOOD_S
        connection.socket.settimeout(FLOOD_S)
        try:
            while time.monotonic() < end:
                connection.send(frames)
        except TimeoutError:  # the proxy has stopped reading
            return True
        except CLOSED:
            return False
        return True


def long_headers(attack):
    """Sends a header field of a megabyte in many frames, and then many long fields in one frame."""
    connection = attack.connect()
    endless = b"\0\x01x\x7f\xff\xff\xff\x7f"  # a field "x" of 2^28 bytes
    connection.send(frame(HEADERS, 0, 1, head(INFO) + endless))
    more = frame(CONTINUATION, 0, 1, b"y" * 16_000)
    try:
        connection.send(more * 64)
    except CLOSED:
        pass
    expect(connection.is_closed(), "a header without end is taken")
    many = [(f"x-{i}", "y" * 100) for i in range(70)]
    expect(attack.connect().call(INFO, more=many) == 3, "70 long fields are taken")


def continuations(attack):
    """Sends a header that never ends, in empty frames and in small ones."""
    for payload in (b"", field("x", "y")):
        connection = attack.connect()
        connection.send(frame(HEADERS, 0, 1, head(INFO)))
        expect(
            not attack.flood(connection, frame(CONTINUATION, 0, 1, payload) * 1_000)
            or connection.is_closed(),
            "a flood of CONTINUATION frames goes on",
        )


def rapid_reset(attack):
    """Begins calls and cancels them at once. Opens a new connection when the proxy closes one."""
    end = time.monotonic() + FLOOD_S
    refused = 0
    while time.monotonic() < end:
        try:
            connection = attack.connect()
            while time.monotonic() < end:
                for _ in range(100):
                    stream = connection.begin("SceneService/Deform")
                    connection.send(frame(RST_STREAM, 0, stream, CANCEL))
        except CLOSED:
            refused += 1
            time.sleep(0.02)
    expect(refused > 0, "calls are begun and reset at any rate")


def calls_never_begun(attack):
    """Sends headers of calls but no byte of their messages. None of these calls may reach the server."""
    connections = [attack.connect() for _ in range(20)]
    streams = [[c.begin("SceneService/ApplyEdits") for _ in range(90)] for c in connections]
    for connection, begun in zip(connections, streams):
        for stream in begun:
            connection.ending(stream)


def slow_readers(attack):
    """Opens watches and reads no events. The watches must end, also at the server."""
    request = message(b"\x0a" + bytes([len(attack.scene)]) + attack.scene.encode())
    connection = attack.connect(window=0)
    streams = [connection.begin("SceneService/Watch") for _ in range(50)]
    for stream in streams:
        connection.send(frame(DATA, END_STREAM, stream, request))
    for stream in streams:
        connection.ending(stream)


def long_trailers(attack):
    """Sends trailers that are longer than gRPC accepts."""
    for _ in range(8):
        connection = attack.connect()
        stream = connection.begin("SceneService/Deform")
        connection.send(frame(DATA, 0, stream, message(b"")))
        trailers = b"\0\x01x\x7f\xb1\x6c" + b"y" * 14_000
        connection.send(frame(HEADERS, END_STREAM | END_HEADERS, stream, trailers))
        connection.is_closed(0.2)


def pings(attack):
    """Sends PINGs and does not read their answers."""
    attack.flood(attack.connect(), frame(PING, 0, 0, bytes(8)) * 1_000)


def connections(attack):
    """Opens more connections than one address may have, and makes no call on them."""
    held, refused = [], 0
    for _ in range(200):
        try:
            held.append(attack.connect())
        except CLOSED:
            refused += 1
    expect(len(held) <= 128 and refused >= 72, f"{len(held)} connections of one address are open")
    expect(all(connection.is_closed() for connection in held), "connections that say nothing stay")


def value(admin, metric):
    with urllib.request.urlopen(f"http://{admin}/metrics", timeout=10) as answer:
        found = re.search(rf"^{re.escape(metric)} (\S+)$", answer.read().decode(), re.M)
    return float(found[1]) if found else 0.0


def finished_watches(admin):
    method = 'latticed_rpc_duration_seconds_count{method="SceneService/Watch"}'
    return value(admin, method)


def beside(name, run, attack, honest_port):
    """Runs the attack. Meanwhile the honest client makes calls, with a new connection every 12 calls."""
    process = multiprocessing.Process(target=run, args=(attack,), daemon=True)
    process.start()
    start, answers, slowest = time.monotonic(), 0, 0.0
    connection = Connection(honest_port, attack.ca)
    while process.is_alive() or answers == 0:
        expect(time.monotonic() - start < MOST_S, f"{name}: not over after {MOST_S} s")
        if answers % 12 == 11:
            connection.close()
            connection = Connection(honest_port, attack.ca)
        begun = time.monotonic()
        expect(connection.call(INFO) == 0, f"{name}: an honest call is refused")
        slowest = max(slowest, time.monotonic() - begun)
        answers += 1
        time.sleep(0.04)
    connection.close()
    seconds = time.monotonic() - start
    print(
        f"{name}: {seconds:.1f} s, {answers} honest answers, the slowest after {slowest * 1000:.0f} ms",
        flush=True,
    )
    expect(process.exitcode == 0, f"{name} failed")
    expect(slowest < ANSWER_S, f"{name}: an honest answer took {slowest:.1f} s")


def main(port, cut_port, ca, admin, scene):
    attacks = [
        long_headers,
        continuations,
        rapid_reset,
        calls_never_begun,
        long_trailers,
        pings,
        connections,
    ]
    edits = 'latticed_rpc_started_total{method="SceneService/ApplyEdits"}'
    before = value(admin, edits)
    for number, run in enumerate(attacks):
        beside(run.__name__, run, Attack(int(port), ca, f"127.0.1.{number + 1}"), int(port))
    expect(value(admin, edits) == before, "a call came through")
    reader = Attack(int(cut_port), ca, "127.0.1.99")
    reader.scene = scene
    before = finished_watches(admin)
    beside("slow_readers", slow_readers, reader, int(cut_port))
    end = time.monotonic() + 60
    while finished_watches(admin) < before + 50:
        expect(time.monotonic() < end, "the server keeps watches that the proxy has cut")
        time.sleep(0.1)


if __name__ == "__main__":
    main(*sys.argv[1:])
