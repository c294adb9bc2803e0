# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# farewells.py PORT CA: asks a server behind the proxy at PORT for streams of edits to a scene that it does not have. Each
# stream must say so in a goaway, and end with the server's status when its client half-closes.
import sys

from http2 import DATA, END_STREAM, Connection, frame, message, messages

STREAMS = 20
NOT_FOUND = 5
GOAWAY = 12 << 3 | 2  # first byte of a SceneEvent with its field goaway
WATCH = b"\x0a\x06\x0a\x04none"  # DeformRequest{watch {scene: "none"}}


def main(port, ca):
    connection = Connection(port, ca)
    for _ in range(STREAMS):
        stream = connection.begin("SceneService/Deform")
        connection.send_data(stream, message(WATCH), flags=0)
        while stream not in connection.ended and not connection.data.get(stream):
            connection.hear()
        events = messages(connection.data.get(stream, b""))
        if [event[0] for event in events] != [GOAWAY]:
            raise SystemExit(f"farewells.py: a refused stream said {events}, not goaway")
        connection.send(frame(DATA, END_STREAM, stream))
        status = connection.ending(stream)
        if status != NOT_FOUND:
            raise SystemExit(f"farewells.py: a refused stream ended with grpc-status {status}")
    connection.close()


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2])
