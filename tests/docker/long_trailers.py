# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# long_trailers.py PORT CA: by way of the proxy at that port of localhost, calls with trailers longer than
# the servers take, beside calls of other clients, which must end as if nothing had been. HTTP/2 by hand,
# for gRPC's clients send no trailers.
import ssl
import sys

from many_connections import DATA, END_HEADERS, END_STREAM, HEADERS, Connection, frame

CLIENTS = 8  # of each kind: each of the proxy's threads has connections of its own
METHOD, STREAM = "ServerService/GetServerInfo", "SceneService/Deform"
# RFC 7541: a field "x" of 14,000 bytes.
TRAILERS = frame(HEADERS, END_STREAM | END_HEADERS, 3, b"\0\x01x\x7f\xb1\x6c" + b"y" * 14_000)


def ending(connection, stream):
    """The kind of frame that ends it: HEADERS, if it is an answer of gRPC's."""
    while connection.ended[0] != stream:
        if not connection.hear():
            sys.exit(f"the proxy closed a connection before stream {stream} ended")
    return connection.ended[1]


def client(port, context, method):
    """Has had an answer, so that it may share a connection to the server, and begins a call."""
    connection = Connection(
        port,
        wrap=lambda plain: context.wrap_socket(plain, server_hostname="localhost"),
        authority="localhost",
    )
    connection.call(METHOD)
    if ending(connection, 1) != HEADERS:
        sys.exit("no answer by way of the proxy")
    connection.begin(method)
    return connection


def main(port, ca):
    context = ssl.create_default_context(cafile=ca)
    context.set_alpn_protocols(["h2"])
    others = [client(int(port), context, METHOD) for _ in range(CLIENTS)]
    for _ in range(CLIENTS):
        connection = client(int(port), context, STREAM)
        connection.socket.sendall(TRAILERS)
        ending(connection, 3)
    for connection in others:
        connection.socket.sendall(frame(DATA, END_STREAM, 3, bytes(5)))
    answered = sum(ending(connection, 3) == HEADERS for connection in others)
    if answered < CLIENTS:
        sys.exit(f"of {CLIENTS} calls beside trailers that are too long {answered} were answered")


if __name__ == "__main__":
    main(*sys.argv[1:])
