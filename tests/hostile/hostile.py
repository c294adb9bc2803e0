# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Attacks latticed, with and without HAProxy in front, and prints one row for each attack (README.md).

Only attacks with one of the words in their name, or with that row, run. The exit status is 1 if a limit was exceeded.
"""
import argparse
import sys
import time
from pathlib import Path

import attacks_ends
import attacks_memory
import attacks_shares
import attacks_transport
import attacks_wire
import attacks_work
import table
from attack import every_attack
from session import Session

# They register their attacks.
MODULES = (attacks_transport, attacks_memory, attacks_shares, attacks_work, attacks_wire, attacks_ends)
WAYS = ("direct", "proxied")
REST_S, QUICK_REST_S = 3, 1.6


def order(attack):
    """By row. What ends the server comes last of those that share it, after what leaves something behind."""
    digits = "".join(filter(str.isdigit, attack.row))
    return attack.ends_server, attack.leaves_traces, int(digits or 99), attack.row


def plan(arguments):
    """Which attacks share a server: (way, [(attack, seconds)…]). In the quick set all of a way do."""
    ways = [way for way in WAYS if getattr(arguments, way)] or WAYS
    chosen = [
        one
        for one in sorted(every_attack, key=order)
        if not arguments.words or any(word == one.row or word in one.name for word in arguments.words)
    ]
    if arguments.quick:
        groups = [(way, [(one, one.quick[way]) for one in chosen if way in one.quick]) for way in ways]
        return [(way, attacks) for way, attacks in groups if attacks]
    return [(way, [(one, one.seconds)]) for one in chosen for way in ways if one.only in ("", way)]


def say(row):
    print(table.line(row.cells()), flush=True)


def run(groups):
    print(table.line(table.COLUMNS))
    begun, total, rows = time.monotonic(), sum(len(attacks) for _, attacks in groups), []
    for way, attacks in groups:
        measured = run_group(way, attacks)
        for at, (row, attack) in enumerate(zip(measured, attacks)):
            if row.is_only_slow():  # perhaps something else ran on this machine: the second run counts
                say(row)
                measured[at] = run_group(way, [attack])[0]
                measured[at].name += " (again)"
        for row in measured:
            say(row)
        rows += measured
        if sys.stderr.isatty():
            print(f"{len(rows)} of {total}, {time.monotonic() - begun:.0f} s", file=sys.stderr)
    return rows


def run_group(way, attacks):
    """Measures attacks against one server. Fewer rows come back if one of them has ended it."""
    session = Session([one for one, _ in attacks], way, REST_S if len(attacks) == 1 else QUICK_REST_S)
    rows = []
    try:
        for one, seconds in attacks:
            rows.append(session.measure(one, seconds))
            if session.server.has_ended():
                break
    finally:
        code = session.stop()
    if code != 0:
        rows[-1].wrong.append(f"the server ended with {code}")
    return rows


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--quick", action="store_true", help="the set for CI: less time, one server for all attacks"
    )
    parser.add_argument("--direct", action="store_true", help="without HAProxy only")
    parser.add_argument("--proxied", action="store_true", help="with HAProxy only")
    parser.add_argument(
        "--markdown", type=Path, metavar="FILE", help="replaces the table at the end of this file"
    )
    parser.add_argument("words", nargs="*", metavar="WORD")
    arguments = parser.parse_args()
    if arguments.quick:  # beside other tests, and on one server, which keeps what the attacks have made
        table.NOISE_MS, table.REST_MB = 50, 160
    rows = run(plan(arguments))
    if arguments.markdown:
        table.write(arguments.markdown, rows)
    failed = [row for row in rows if row.wrong]
    print(f"{len(rows) - len(failed)} of {len(rows)} attacks were held off")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
