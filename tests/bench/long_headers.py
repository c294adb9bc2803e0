# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# long_headers.py LATTICED: what headers without end cost a server, as many of the longest as it takes,
# and more calls than the settings allow: memory at its peak, processor time, and how many connections are left when all is sent. HTTP/2
# by hand, as many_connections.py.
import functools
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time
from concurrent import futures

from many_connections import HEADERS, Connection, frame, head

CONTINUATION = 9
FRAME = 16_384
# RFC 7541: a field that the table keeps, under number 62, and a field of 2^28 bytes.
NUMBER, NUMBERED = b"\xbe", b"\x40\x01x\x01y"
ENDLESS = b"\0\x01x\x7f\xff\xff\xff\x7f"
WAIT_S = 3  # for what the server has not read yet
CALLS, FIELDS = 128, 200  # as many as it takes


def still_there(connection):
    connection.socket.settimeout(WAIT_S)
    try:
        while connection.hear():
            pass
    except TimeoutError:
        return True
    return False


def send(port, fields, piece, count):
    """A header of so many pieces on a connection of its own; whether it is still there."""
    connection = Connection(port, acknowledges=False)  # nothing may come between the pieces
    try:
        connection.socket.sendall(frame(HEADERS, 0, 1, head("SceneService/ApplyEdits") + fields))
        for _ in range(count):
            connection.socket.sendall(frame(CONTINUATION, 0, 1, piece))
        return still_there(connection)
    except OSError:
        return False


def begin(port, fields, calls, acknowledges):
    """So many calls with these fields on a connection of its own; whether it is still there."""
    connection = Connection(port, acknowledges)
    connection.socket.settimeout(WAIT_S)  # one that the server has closed may take no more
    try:
        connection.begin("SceneService/ApplyEdits", calls, fields)
        return still_there(connection)
    except OSError:
        return False


def measure(program, what, connections, task):
    """`task` of a server's port, on so many threads."""
    flags = ["--listen", "127.0.0.1:0", "--insecure", "--backend", "cpu", "--drain-delay", "0s"]
    log = tempfile.NamedTemporaryFile("r")  # no pipe: a server waits for who does not read that
    with open(log.name, "a", encoding="utf-8") as end:  # of its own, which reading does not move
        server = subprocess.Popen([program, *flags], stdout=end, stderr=subprocess.STDOUT)
    try:
        text = ""
        while not (serves := re.search(r"serving address=127\.0\.0\.1:(\d+)", text)):
            if server.poll() is not None:
                raise SystemExit(text)
            time.sleep(0.1)
            text += log.read()
        port = int(serves[1])
        start = time.monotonic()
        with futures.ThreadPoolExecutor(connections) as pool:
            left = sum(pool.map(task, [port] * connections))
        seconds = time.monotonic() - start
        process = pathlib.Path(f"/proc/{server.pid}")
        peak = int(re.search(r"VmHWM:\s+(\d+)", (process / "status").read_text())[1]) // 1024
        ticks = sum(map(int, (process / "stat").read_text().rsplit(")", 1)[1].split()[11:13]))
    finally:
        server.terminate()
        server.wait()
    print(
        f"{connections} connections, {what} each: {left} left after {seconds:.1f} s,"
        f" {peak} MB at the peak, {ticks / os.sysconf('SC_CLK_TCK'):.2f} s of processor time"
    )


def main(program):
    for what, connections, mebibytes, fields, piece in (
        ("fields by number", 40, 2, NUMBERED, NUMBER * FRAME),
        ("one field", 6, 20, ENDLESS, b"y" * FRAME),
    ):
        count = mebibytes * 2**20 // FRAME
        task = functools.partial(send, fields=fields, piece=piece, count=count)
        measure(program, f"{mebibytes} MiB of {what}", connections, task)
    fields = NUMBERED + NUMBER * FIELDS
    task = functools.partial(begin, fields=fields, calls=CALLS, acknowledges=True)
    measure(program, f"{CALLS} calls of {FIELDS} fields", 400, task)
    for connections in (1, 8):
        calls = 60_000 // connections
        task = functools.partial(begin, fields=b"", calls=calls, acknowledges=False)
        measure(program, f"{calls} calls at once", connections, task)


if __name__ == "__main__":
    main(sys.argv[1])
