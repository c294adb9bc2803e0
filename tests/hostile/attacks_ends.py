# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Rows 6 and 9: a log that nobody reads, signals, and limits of the process."""
import os
import signal
import time
from pathlib import Path

from attack import CLOSED, CODES, attack
from http2 import message, messages
from latticed.v1 import edit_pb2, event_pb2, scene_pb2
from server import ALICE, MALLORY, token_line

INFO = "ServerService/GetServerInfo"
EDITORS, EDITS_PER_S = 36, 4
END_S = 15


@attack("6", seconds=3, options=["--log-level", "debug"], unread_log=True)
def a_log_that_nobody_reads(target, seen):
    """Refusals fill the pipe of the log. SIGTERM must end the process all the same, as after every attack."""
    connection = target.connect_without_token()
    for _ in target.until_end():
        for method in ("MeshService/GetMesh", "SceneService/GetScene", INFO):
            seen.count_status(connection.call(method))
        time.sleep(
            0.002 if not target.is_proxied else 0.01
        )  # the proxy takes 500 calls a second of an address


class Editor:
    """Drags in a Deform stream, until the server says that it goes away. Knows which edits were answered."""

    def __init__(self, connection, scene, number):
        self.connection, self.scene, self.number = connection, scene, number
        self.sent, self.answers, self.hears_end = 0, {}, False
        self.stream = connection.begin("SceneService/Deform")
        view = scene_pb2.WatchRequest(scene=scene, editor_id=f"editor-{number}", max_unacked_updates=1)
        view.view.segments = 1  # edits and their answers matter here, not surfaces
        self.send(scene_pb2.DeformRequest(watch=view))

    def send(self, request):
        self.connection.send_data(self.stream, message(request.SerializeToString()), 0)

    def edit(self):
        self.hear()
        if self.hears_end or self.stream in self.connection.ended:
            return
        self.sent += 1
        batch = edit_pb2.EditBatch(scene=self.scene, editor_id=f"editor-{self.number}", sequence=self.sent)
        batch.structure_id = 1
        move = batch.edits.add().move_control_points
        move.indices.append(self.number)
        move.offset.y = 0.001
        self.send(scene_pb2.DeformRequest(edit=batch))

    def hear(self):
        data = self.connection.data.get(self.stream, bytearray())
        for payload in messages(data):
            del data[: 5 + len(payload)]
            event = event_pb2.SceneEvent.FromString(payload)
            if event.HasField("edit_result"):
                self.answers[event.edit_result.sequence] = event.edit_result.status.code
                self.hears_end |= event.edit_result.status.code == 14
            elif event.HasField("goaway"):
                self.hears_end = True


@attack("9", quick={"direct": 1}, seconds=2, ends_server=True)
def sigterm_beside_36_editors(target, seen):
    connections = [target.connect() for _ in range(6)]
    editors = [Editor(connections[number % 6], target.scene, number) for number in range(EDITORS)]
    begun, signalled, rounds = time.monotonic(), 0.0, 0
    while time.monotonic() < begun + target.seconds + END_S:
        if not signalled and time.monotonic() > begun + target.seconds:
            os.kill(target.pid, signal.SIGTERM)
            signalled = time.monotonic()
        for connection in connections:
            connection.hear(0.002)
        try:
            if time.monotonic() > begun + rounds / EDITS_PER_S:
                rounds += 1
                for editor in editors:
                    editor.edit()
        except CLOSED:
            pass
        if all(editor.stream in editor.connection.ended for editor in editors):
            break
        if signalled and not any(connection.hear(0.002) for connection in connections):
            break
    for editor in editors:
        editor.hear()
        status = editor.connection.status.get(editor.stream)
        seen.count("stream ends " + (CODES[status] if status is not None else "without a status"))
        seen.expect(
            status == 0, "a stream ends " + (CODES[status] if status is not None else "without a status")
        )
        seen.count("edits", editor.sent)
        seen.count("applied", sum(code == 0 for code in editor.answers.values()))
        seen.count("refused", sum(code != 0 for code in editor.answers.values()))
        seen.count("unknown", editor.sent - len(editor.answers))
    unknown = seen.counts["unknown"]
    seen.expect(unknown == 0, f"whether {unknown} edits were applied is unknown")
    seen.count("ms to the end", round((time.monotonic() - signalled) * 1000))


def is_known(target, token):
    return target.connect(token=token).call(INFO) == 0


def hang_up(target, seen):
    """Sends SIGHUP, and waits until the server says what has come of it."""

    def said():
        log = Path(target.log).read_text(errors="replace")
        return log.count("were read again") + log.count("could be read again")

    before, end = said(), time.monotonic() + END_S
    os.kill(target.pid, signal.SIGHUP)
    while said() == before and time.monotonic() < end:
        time.sleep(0.05)
    seen.expect(said() > before, "SIGHUP is not heard")


@attack("9", seconds=3)
def sighup(target, seen):
    """The token file changes, and SIGHUP makes the server read it again."""
    new = "newcomers-token"
    tokens = Path(target.tokens)
    tokens.write_text(token_line(ALICE, "alice") + token_line(new, "newcomer"))
    hang_up(target, seen)
    seen.expect(os.path.exists(f"/proc/{target.pid}/exe"), "SIGHUP kills the server")
    seen.expect(is_known(target, new), "a new token is not known after SIGHUP")
    seen.expect(not is_known(target, MALLORY), "a removed token is known after SIGHUP")
    tokens.write_text("this is no token file\n")
    hang_up(target, seen)
    seen.expect(
        is_known(target, new), "after SIGHUP with a bad file the tokens of the last good one are not known"
    )
    seen.count("signals", 2)


@attack("9", seconds=2, options=["--log-level", "debug"], limits="ulimit -f 16")
def a_log_of_the_largest_size(target, seen):
    """The log's file may have 8 kB; SIGXFSZ follows."""
    connection = target.connect()
    for _ in target.until_end():
        seen.count_status(connection.call("SceneService/GetScene"))


@attack("9", seconds=4, limits="ulimit -n 64", unbounded=("direct", "proxied"))
def few_descriptors(target, seen):
    """100 connections to a server that may have 64 descriptors: each is answered or closed, and none hangs."""
    # The proxy tries four times to reach a server that is full, for 5 s each.
    longest = 20 if target.is_proxied else 2
    held = []
    for number in range(100):
        begun = time.monotonic()
        try:
            connection = target.connect(f"127.0.1.{1 + number // 25}")
            held.append(connection)
            seen.count_status(connection.call(INFO))
        except CLOSED:
            seen.count("closed")
        seen.expect(time.monotonic() - begun < longest, f"a newcomer waits for more than {longest} s")
        if time.monotonic() > begun + 2:
            break
    for _ in target.until_end():
        time.sleep(0.1)
    for connection in held:
        connection.close()
