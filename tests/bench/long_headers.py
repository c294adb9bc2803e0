# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# long_headers.py LATTICED: what headers without end cost a server: memory at its peak, processor time,
# and how many connections are left when all is sent. HTTP/2 by hand, as many_connections.py.
import os
import pathlib
import re
import subprocess
import sys
import time
from concurrent import futures

from many_connections import HEADERS, Connection, frame, head

CONTINUATION = 9
FRAME = 16_384
# RFC 7541: a field that the table keeps, under number 62, and a field of 2^28 bytes.
NUMBER, NUMBERED = b"\xbe", b"\x40\x01x\x01y"
ENDLESS = b"\0\x01x\x7f\xff\xff\xff\x7f"
WAIT_S = 3  # for what the server has not read yet


def send(port, fields, piece, count):
    """A header of so many pieces on a connection of its own; whether it is still there."""
    connection = Connection(port)
    try:
        connection.socket.sendall(frame(HEADERS, 0, 1, head("SceneService/ApplyEdits") + fields))
        for _ in range(count):
            connection.socket.sendall(frame(CONTINUATION, 0, 1, piece))
        connection.socket.settimeout(WAIT_S)
        while connection.hear():
            pass
        return False
    except TimeoutError:
        return True
    except OSError:
        return False


def main(program):
    flags = ["--listen", "127.0.0.1:0", "--insecure", "--backend", "cpu", "--drain-delay", "0s"]
    for what, connections, mebibytes, fields, piece in (
        ("fields by number", 40, 2, NUMBERED, NUMBER * FRAME),
        ("one field", 6, 20, ENDLESS, b"y" * FRAME),
    ):
        server = subprocess.Popen(
            [program, *flags], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        lines = (re.search(r"serving address=127\.0\.0\.1:(\d+)", line) for line in server.stdout)
        port = int(next(filter(None, lines))[1])
        start = time.monotonic()
        with futures.ThreadPoolExecutor(connections) as pool:
            count = mebibytes * 2**20 // FRAME
            sent = [pool.submit(send, port, fields, piece, count) for _ in range(connections)]
            left = sum(one.result() for one in sent)
        seconds = time.monotonic() - start
        process = pathlib.Path(f"/proc/{server.pid}")
        peak = int(re.search(r"VmHWM:\s+(\d+)", (process / "status").read_text())[1]) // 1024
        ticks = sum(map(int, (process / "stat").read_text().rsplit(")", 1)[1].split()[11:13]))
        print(
            f"{connections} connections, {mebibytes} MiB of {what} each: {left} left after"
            f" {seconds:.1f} s, {peak} MB at the peak, {ticks / os.sysconf('SC_CLK_TCK'):.2f} s of processor time"
        )
        server.terminate()
        server.wait()


if __name__ == "__main__":
    main(sys.argv[1])
