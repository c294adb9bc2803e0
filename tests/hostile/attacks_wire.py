# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Row 10: bytes that are no requests, and callers who guess."""
import base64
import socket
import ssl
import time
from pathlib import Path

from attack import CLOSED, CODES, SOURCE, attack
from calls import Refused, unary
from http2 import DATA, END_STREAM, frame, message
from latticed.v1 import mesh_pb2, scene_pb2, server_pb2

INFO = "ServerService/GetServerInfo"
GUESSES_PER_S, MOST_JUDGED_PER_S = 1_500, 100
PROXIED_PER_S = 300  # the proxy closes the connections of an address that makes 500 calls a second
OVERRIDE = "\u202e"  # right to left


def every_rpc():
    for file in (mesh_pb2, scene_pb2, server_pb2):
        for service in file.DESCRIPTOR.services_by_name.values():
            yield from (f"{service.name}/{method.name}" for method in service.methods)


@attack("10", quick={"direct": 0.5}, seconds=4)
def unparsable_messages(target, seen):
    connection, wrong = target.connect(), {}
    for _ in target.until_end():
        for rpc in every_rpc():
            try:
                status = connection.call(rpc, message(b"\xff" * 20))
                seen.count_status(status)
                if status not in (3, None):
                    wrong.setdefault(CODES[status], set()).add(rpc)
                time.sleep(
                    0.003 if target.is_proxied else 0
                )  # the proxy takes 500 calls a second of an address
            except CLOSED:
                connection = target.connect_again(seen)
    for code, rpcs in wrong.items():
        seen.expect(False, f"{len(rpcs)} rpcs, such as {min(rpcs)}, answer garbage with {code}")


HEADS = {
    "an unknown coding": "Host: localhost\r\nTransfer-Encoding: xchunked\r\n",
    "two hosts": "Host: localhost\r\nHost: evil.example\r\nContent-Length: 5\r\n",
    "two lengths": "Host: localhost\r\nContent-Length: 5\r\nContent-Length: 6\r\n",
    "length and coding": "Host: localhost\r\nContent-Length: 5\r\nTransfer-Encoding: chunked\r\n",
}


# gRPC ends a process that starts a call whose metadata is not printable.
BINARY_TOKENS = [b"\x8c", b"mallory\n", b"mallory\x7f", "\u202emallory".encode()]


def http_status(target, request):
    """Sends this head, and the end of a chunked body. Returns the status of the answer, or 0 if there is none."""
    plain = socket.create_connection(("127.0.0.1", target.http), 5, (SOURCE, 0))
    if target.ca:
        context = ssl.create_default_context(cafile=target.ca)
        plain = context.wrap_socket(plain, server_hostname="localhost")
    with plain:
        plain.sendall(request.encode() + b"0\r\n\r\n")
        answer = plain.recv(4096)
    return int(answer.split()[1]) if answer.startswith(b"HTTP/1.") else 0


@attack("10", seconds=3)
def heads_of_two_meanings(target, seen):
    for _ in target.until_end():
        for what, fields in HEADS.items():
            try:
                status = http_status(
                    target,
                    f"POST /latticed.v1.{INFO} HTTP/1.1\r\n"
                    f"Content-Type: application/grpc-web+proto\r\n{fields}\r\n",
                )
            except CLOSED:
                status = 0
            seen.count(f"HTTP {status}" if status else "closed")
            # HAProxy takes the coding and drops the length, as RFC 9112 says.
            allowed = (400, 0, 401, 200) if what == "length and coding" and target.is_proxied else (400, 0)
            seen.expect(status in allowed, f"{what}: HTTP {status}")
            time.sleep(0.02)


@attack("10", seconds=3, quick={"direct": 1})
def sockets_with_binary_tokens(target, seen):
    for _ in target.until_end():
        for token in BINARY_TOKENS:
            offered = base64.urlsafe_b64encode(token).decode().rstrip("=")
            status = http_status(
                target,
                "GET /ws/latticed.v1.SceneService/Deform HTTP/1.1\r\nHost: localhost\r\n"
                "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                f"Sec-WebSocket-Protocol: latticed.v1, bearer.{offered}\r\n\r\n",
            )
            seen.count(f"HTTP {status}")
            seen.expect(status == 400, f"a token of {token}: HTTP {status}")
            time.sleep(0.02)


@attack("10", quick={"direct": 1})
def wrong_tokens(target, seen):
    """1,500 guesses a second, 300 with the proxy. A caller of the same address who has a token is answered."""
    wrong = [target.connect(token=f"guess-{number}") for number in range(8)]
    right = target.connect()
    begun, sent, slowest = time.monotonic(), 0, 0.0
    per_s = PROXIED_PER_S if target.is_proxied else GUESSES_PER_S
    for _ in target.until_end():
        for number, connection in enumerate(wrong):
            due = (time.monotonic() - begun) * per_s
            try:
                for _ in range(
                    min(16, int(due) - sent, 90 - connection.next_stream // 2 + len(connection.ended))
                ):
                    stream = connection.begin(INFO)
                    connection.send(frame(DATA, END_STREAM, stream, message(b"")))
                    sent += 1
                connection.hear(0.001)
            except CLOSED:
                wrong[number] = target.connect(token=f"guess-{number}")
        time.sleep(0.005)
        asked = time.monotonic()
        seen.expect(right.call(INFO) == 0, "a call with a token is refused")
        slowest = max(slowest, time.monotonic() - asked)
    seen.count("guesses", sent)
    for connection in wrong:
        for status in connection.status.values():
            seen.count_status(status)
    seconds = time.monotonic() - begun
    judged = seen.counts.get("UNAUTHENTICATED", 0) / seconds
    seen.expect(judged <= MOST_JUDGED_PER_S, f"{judged:,.0f} guesses a second are judged")
    seen.expect(slowest < 1, f"a call with a token took {slowest:.1f} s")


@attack("10", seconds=2, options=["--log-level", "debug"])
def names_that_turn_the_log(target, seen):
    connection = target.connect()
    name = OVERRIDE + "gnp.exe\n2026 info forged"
    header = mesh_pb2.MeshHeader(name=name, format=99, total_bytes=1)
    requests = [
        ("MeshService/BeginUpload", mesh_pb2.BeginUploadRequest(header=header)),
        ("MeshService/GetMesh", mesh_pb2.GetMeshRequest(mesh=name)),
        ("SceneService/GetScene", scene_pb2.GetSceneRequest(scene=name)),
        ("SceneService/CreateScene", scene_pb2.CreateSceneRequest(scene_id=name, mesh=name)),
        ("SceneService/Watch", scene_pb2.WatchRequest(scene=name, editor_id=name)),
    ]
    for _ in target.until_end():
        for method, request in requests:
            try:
                unary(connection, method, request)
                seen.count("OK")
            except Refused as error:
                seen.count_status(error.status)
        time.sleep(0.1)
    log = Path(target.log).read_text(errors="replace")
    seen.expect(OVERRIDE not in log, "the log has a right-to-left override")
    seen.expect("\n2026 info forged" not in log, "the log has a forged line")
