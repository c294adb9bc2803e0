# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Rows 1 and 2: compressed messages and reflection streams. And PINGs, resets and silent connections."""
import struct
import time
import zlib

from attack import CLOSED, attack
from http2 import DATA, PING, RST_STREAM, frame, message

HEALTH = "/grpc.health.v1.Health/Check"
REFLECTION = "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo"
CANCEL = (8).to_bytes(4, "big")
BOMB_MB = 960  # inflated; about 1 MB compressed, as much as a message may have
LIST_SERVICES = message(b"\x3a\x01*")
STREAMS = 960


def bomb():
    """gzip of zeros. Its blocks are equal, so one is compressed and repeated."""
    zeros = bytes(16 << 20)
    deflate = zlib.compressobj(9, zlib.DEFLATED, -15)
    block = deflate.compress(zeros) + deflate.flush(zlib.Z_FULL_FLUSH)
    checksum, times = 0, BOMB_MB // 16
    for _ in range(times):
        checksum = zlib.crc32(zeros, checksum)
    end = struct.pack("<II", checksum, (BOMB_MB << 20) & 0xFFFFFFFF)
    return b"\x1f\x8b\x08\0\0\0\0\0\0\xff" + block * times + b"\x03\0" + end


@attack("1", quick={"direct": 1, "proxied": 1}, seconds=4)
def gzip_bombs(target, seen):
    payload = bomb()
    compressed = b"\x01" + len(payload).to_bytes(4, "big") + payload
    for _ in target.until_end():
        for connect, method in (
            (target.connect, "SceneService/GetScene"),
            (target.connect_without_token, HEALTH),
        ):
            try:
                status = connect().call(method, compressed, [("grpc-encoding", "gzip")])
                seen.count_status(status)
                seen.expect(status == 12, f"{method} answers a compressed message with status {status}")
            except CLOSED:
                seen.count("closed")


def open_streams(target, number, per_connection=96):
    connections = []
    for at in range(0, number, per_connection):
        connection = target.connect_without_token(f"127.0.1.{1 + len(connections) // 4}")
        connections.append(connection)
        for _ in range(min(per_connection, number - at)):
            stream = connection.begin(REFLECTION)
            connection.send(frame(DATA, 0, stream, LIST_SERVICES))
    return connections


@attack("2", options=["--reflection"])
def reflection_streams_at_once(target, seen):
    connections = open_streams(target, STREAMS)
    for _ in target.until_end():
        for connection in connections:
            connection.hear(0.01)
    seen.count("streams", STREAMS)
    seen.count("ended by the server", sum(len(connection.ended) for connection in connections))


@attack("2", options=["--reflection"], unbounded=["direct"])
def reflection_streams_opened_and_reset(target, seen):
    connection = None
    for _ in target.until_end():
        try:
            connection = connection or target.connect_without_token()
            for _ in range(90):
                stream = connection.begin(REFLECTION)
                connection.send(frame(DATA, 0, stream, LIST_SERVICES))
                connection.send(frame(RST_STREAM, 0, stream, CANCEL))
                seen.count("streams")
        except CLOSED:
            seen.count("closed")
            connection = None
            time.sleep(0.02)


@attack("pings", unbounded=["direct"])
def unread_pings(target, seen):
    connection = None
    pings = frame(PING, 0, 0, bytes(8)) * 1000
    for _ in target.until_end():
        try:
            connection = connection or target.connect()
            connection.socket.settimeout(0.5)
            connection.send(pings)
            seen.count("PINGs", 1000)
        except TimeoutError:
            seen.count("stalls")
        except CLOSED:
            seen.count("closed")
            connection = None
            time.sleep(0.02)


@attack("resets", quick={"proxied": 1.5}, unbounded=["direct"])
def rapid_resets(target, seen):
    connection = None
    for _ in target.until_end():
        try:
            connection = connection or target.connect()
            for _ in range(100):
                stream = connection.begin("SceneService/Deform")
                connection.send(frame(RST_STREAM, 0, stream, CANCEL))
            seen.count("streams", 100)
        except CLOSED:
            seen.count("closed")
            connection = None
            time.sleep(0.02)


@attack("resets", seconds=40, options=["--reflection"])
def streams_that_close_at_once(target, seen):
    """Opens 960 streams, closes them all, and waits: are honest calls answered just after?"""
    for _ in target.until_end():
        connections = open_streams(target, STREAMS)
        for connection in connections:
            connection.close()
        seen.count("rounds")
        time.sleep(1.5)


@attack("4e", seconds=12)
def idle_connections(target, seen):
    """450 connections: a third say nothing, a third only the preface, a third that and their settings."""
    import socket

    from http2 import PREFACE, SETTINGS

    held = []
    for number in range(450):
        try:
            plain = socket.create_connection(("127.0.0.1", target.port), 5, ("127.0.1.1", 0))
            if number % 3:
                plain.sendall(PREFACE if number % 3 == 1 else PREFACE + frame(SETTINGS, 0, 0))
            held.append(plain)
        except OSError:
            seen.count("refused")
    for _ in target.until_end():
        time.sleep(0.1)
    for number, connection in enumerate(held):
        connection.setblocking(False)
        try:
            while connection.recv(4096):
                pass
            seen.count("closed")
        except BlockingIOError:
            seen.count("open")
            seen.expect(
                number % 3 == 2 or target.is_proxied,  # the proxy keeps them for 60 s, and 128 of an address
                "a connection without settings stays open for 12 s",
            )
        except OSError:
            seen.count("closed")


@attack("4g", quick={"direct": 1}, seconds=4, only="direct")
def silent_admin_connections(target, seen):
    import socket

    held = []
    for _ in range(200):
        try:
            held.append(socket.create_connection(("127.0.0.1", target.admin), 2, ("127.0.1.1", 0)))
        except OSError:
            seen.count("refused")
    seen.count("connections", len(held))
    for _ in target.until_end():
        time.sleep(0.1)
