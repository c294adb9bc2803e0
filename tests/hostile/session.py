# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""A server, a proxy if wanted, and honest clients; attacks are measured against them."""
import multiprocessing
import os
import shutil
import tempfile
import time
from pathlib import Path

from attack import Seen, Target
from honest import SCENE, HonestClients
from proxy import Proxy
from server import MEMORY_MB, Server, Watch
from table import Row

REST_S = 10  # after so long everything is back
UNBOUNDED_REST_S = 90  # the same where figures are only told
LATE_S = 40  # longest time from the end of an attack to the end of its process, which may tidy up


def begin(run, target, results):
    """The process of an attack. Floods get less of the processor than the server: on a network they have their own."""
    if not target.is_honest_too:
        os.nice(19)
    seen = Seen()
    try:
        run(target, seen)
    except Exception as error:  # noqa: BLE001  the attacker's own failure is told, not hidden
        seen.wrong.append(f"the attack failed: {type(error).__name__}: {error}")
    results.send(seen)


def run_beside(one, target):
    """Runs the attack in its own process until it is over. Returns what it saw."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=begin, args=(one.run, target, theirs), daemon=True)
    process.start()
    theirs.close()
    seen = Seen()
    if ours.poll(target.seconds + LATE_S):
        try:
            seen = ours.recv()
        except EOFError:
            seen.wrong.append("the attack died")
    else:
        seen.wrong.append("the attack did not end")
    process.kill()
    process.join()
    return seen


class Session:
    """Starts everything for `attacks`, whose options the server gets, and measures `rest_s` seconds without attack."""

    def __init__(self, attacks, way, rest_s):
        self.way, self.rest_s = way, rest_s
        self.work = Path(tempfile.mkdtemp(prefix="latticed-hostile-"))
        self.server = self.proxy = self.honest = None
        options = dict.fromkeys(tuple(attack.options) for attack in attacks)
        try:
            self.server = Server(
                self.work,
                *[word for words in options for word in words],
                *(["--trust-forwarded-for"] if way == "proxied" else []),
                limits="\n".join(attack.limits for attack in attacks),
                unread_log=any(attack.unread_log for attack in attacks),
            )
            self.proxy = Proxy(self.work, self.server) if way == "proxied" else None
            address = f"[::1]:{self.proxy.port}" if self.proxy else f"127.0.0.1:{self.server.port}"
            self.honest = HonestClients(address, self.proxy and self.proxy.ca)
            time.sleep(1)  # the first calls are slower
            self.honest.take()
            time.sleep(rest_s)
            self.rest, self.at_rest = self.server.figures(), self.honest.take()
        except BaseException:
            self.stop()
            raise

    def stop(self):
        """Ends everything. Returns the exit code of the server."""
        if self.honest:
            self.honest.stop()
        if self.proxy:
            self.proxy.stop()
        code = self.server.stop() if self.server else 0
        shutil.rmtree(self.work, ignore_errors=True)
        return code

    def measure(self, attack, seconds):
        """Attacks for so many seconds. Returns the row."""
        row = Row(attack.row, attack.name, self.way, self.rest, self.at_rest)
        row.is_bounded = self.way not in attack.unbounded
        target = Target(
            port=self.proxy.port if self.proxy else self.server.port,
            http=self.proxy.port if self.proxy else self.server.http,
            admin=self.server.admin,
            pid=self.server.pid,
            ca=self.proxy.ca if self.proxy else None,
            scene=SCENE,
            log=self.server.log_path,
            tokens=str(self.server.tokens),
            seconds=seconds,
            is_proxied=self.proxy is not None,
            is_honest_too=attack.ends_server,
        )
        self.honest.take()
        watch = Watch(self.server)
        row.seen = run_beside(attack, target)
        row.highest, row.during = watch.end(), self.honest.take()
        if not attack.ends_server:
            self.come_to_rest(row)
        row.judge(MEMORY_MB, self.server.has_ended(), attack.ends_server)
        return row

    def come_to_rest(self, row):
        ended = time.monotonic()
        longest = REST_S if row.is_bounded else UNBOUNDED_REST_S
        while time.monotonic() < ended + longest and not row.is_at_rest(self.server.figures()):
            time.sleep(0.25)
        row.rest_after_s = time.monotonic() - ended
        self.honest.take()
        time.sleep(self.rest_s / 2)
        row.after, row.at_end = self.server.figures(), self.honest.take()
