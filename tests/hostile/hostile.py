# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Attacks latticed, with and without HAProxy in front, and prints one row for each attack (README.md).

usage: hostile.py [--quick] [--markdown FILE] [--direct | --proxied] [WORD…]

Only attacks with one of the words in their name or row run. The exit status is 1 if a limit was exceeded.
"""
import argparse
import multiprocessing
import os
import sys
import tempfile
import time
from pathlib import Path

import attacks_ends
import attacks_memory
import attacks_shares
import attacks_transport
import attacks_wire
import attacks_work
import table
from attack import Seen, Target, every_attack
from honest import SCENE, HonestClients
from proxy import Proxy
from server import MEMORY_MB, Server, Watch

# They register their attacks.
MODULES = (attacks_transport, attacks_memory, attacks_shares, attacks_work, attacks_ends, attacks_wire)
REST_S = 10  # after so long everything is back
STARTED_S = 20  # longest time from the end of an attack to the end of its process


def begin(run, target, results):
    """The process of an attack. It gets less of the processor than the server: on a network it has its own."""
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
    seen = Seen()
    if ours.poll(target.seconds + STARTED_S):
        try:
            seen = ours.recv()
        except EOFError:
            seen.wrong.append("the attack died")
    else:
        seen.wrong.append("the attack did not end")
    process.kill()
    process.join()
    return seen


def measure(one, way, quick):
    """Attacks a fresh server. Returns the row."""
    with tempfile.TemporaryDirectory(prefix="latticed-hostile-") as folder:
        work = Path(folder)
        with Server(work, *one.options, limits=one.limits, unread_log=one.unread_log) as server:
            proxy = Proxy(work, server) if way == "proxied" else None
            honest = HonestClients(
                f"[::1]:{proxy.port}" if proxy else f"127.0.0.1:{server.port}", proxy and proxy.ca
            )
            try:
                return measure_with(one, way, quick, server, proxy, honest)
            finally:
                honest.stop()
                if proxy:
                    proxy.stop()


def measure_with(one, way, quick, server, proxy, honest):
    time.sleep(1)  # the first calls are slower
    honest.take()
    time.sleep(2 if quick else 4)
    row = table.Row(one.row, one.name, way, is_bounded=way not in one.unbounded)
    row.rest, row.at_rest = server.figures(), honest.take()
    target = Target(
        port=proxy.port if proxy else server.port,
        http=proxy.port if proxy else server.http,
        admin=server.admin,
        pid=server.pid,
        ca=proxy.ca if proxy else None,
        scene=SCENE,
        log=server.log_path,
        tokens=str(server.tokens),
        seconds=one.quick_s if quick else one.seconds,
        is_proxied=proxy is not None,
    )
    watch = Watch(server)
    row.seen = run_beside(one, target)
    row.highest, row.during = watch.end(), honest.take()
    if not one.ends_server:
        come_to_rest(row, server, honest, 1.5 if quick else 3)
    row.judge(MEMORY_MB, server.has_ended(), one.ends_server)
    code = server.stop()
    if code != 0:
        row.wrong.append(f"the process ended with {code}")
    return row


def come_to_rest(row, server, honest, seconds):
    ended = time.monotonic()
    time.sleep(1)
    while time.monotonic() < ended + REST_S and not row.is_at_rest(server.figures()):
        time.sleep(0.25)
    row.rest_s = time.monotonic() - ended
    honest.take()
    time.sleep(seconds)
    row.after, row.at_end = server.figures(), honest.take()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--markdown", type=Path)
    parser.add_argument("--direct", action="store_true")
    parser.add_argument("--proxied", action="store_true")
    parser.add_argument("words", nargs="*")
    arguments = parser.parse_args()
    ways = [way for way in ("direct", "proxied") if getattr(arguments, way)] or ["direct", "proxied"]
    chosen = [
        (one, way)
        for one in every_attack
        for way in ways
        if (not arguments.quick or one.quick_s)
        and one.only in ("", way)
        and (not arguments.words or any(word == one.row or word in one.name for word in arguments.words))
    ]
    rows = []
    for number, (one, way) in enumerate(chosen):
        print(f"[{number + 1}/{len(chosen)}] {one.name}, {way}", flush=True)
        rows.append(measure(one, way, arguments.quick))
        print(rows[-1].line(), flush=True)
    if arguments.markdown:
        table.write(arguments.markdown, rows)
    failed = [row for row in rows if row.wrong]
    print(f"{len(rows) - len(failed)} of {len(rows)} attacks were held off")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
