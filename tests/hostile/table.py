# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The row of an attack: its figures, the limits that it must keep, and how it is written down."""
import os
import re
import subprocess
import time
from dataclasses import dataclass, field
from pathlib import Path

from attack import Seen
from honest import Window
from server import PROGRAM, Figures

MOST_OF_MEMORY = 1.5  # memory above rest, by --memory
MOST_OF_P95 = 2.0  # p95 during the attack, by p95 at rest
# A p95 below twice this is not judged. With nothing else running it is 2 to 4 ms at rest, and 7 to 12 ms while others
# compile on the same two cores, so a smaller figure says nothing about the server.
NOISE_MS = 10.0
LEAST_SAMPLES = 20
GAP_MS = 1000  # the longest time without any answer to an honest call
NEWCOMER_MS = 2000  # the longest that a newcomer may take
HEALTH_S = 1.0
REST_MB = 72  # freed memory below 64 MiB may stay, and a few tables
REST_DESCRIPTORS = {"direct": 4, "proxied": 8}  # newcomers may be connected; HAProxy keeps connections
MORE_THREADS = 44  # gRPC starts up to 40 of its own (kMaxGrpcThreads), and few of them live at rest
REST_THREADS = 8


@dataclass
class Row:
    number: str
    name: str
    way: str
    rest: Figures
    at_rest: Window
    is_bounded: bool = True
    highest: object = None  # server.Watch
    during: Window = None
    after: Figures = field(default_factory=lambda: Figures(0, 0, 0))
    at_end: Window = field(default_factory=Window)
    rest_after_s: float = 0.0  # from the end of the attack until all was back at rest
    seen: Seen = field(default_factory=Seen)
    wrong: list = field(default_factory=list)

    def is_at_rest(self, now):
        return (
            now.memory_mb <= self.rest.memory_mb + REST_MB
            and now.threads <= self.rest.threads + REST_THREADS
            and now.descriptors <= self.rest.descriptors + REST_DESCRIPTORS[self.way]
        )

    def judge(self, memory_mb, has_ended, ends_server):
        """Notes which limits were exceeded."""
        self.wrong = list(self.seen.wrong)
        if ends_server:
            return
        if has_ended:
            self.wrong.append("the server has ended")
            return
        more_mb = self.highest.memory_mb - self.rest.memory_mb
        self.limit("threads", self.highest.threads, self.rest.threads + MORE_THREADS, "")
        if self.is_bounded:
            self.limit("memory", more_mb, MOST_OF_MEMORY * memory_mb, "MB above rest")
            for kind in ("call", "update"):
                most = MOST_OF_P95 * max(self.at_rest.p95(kind), NOISE_MS)
                self.limit(f"p95 of {kind}s", self.during.p95(kind), most, "ms")
                if len(self.at_end.latencies.get(kind, [])) >= LEAST_SAMPLES:
                    self.limit(f"p95 of {kind}s after it", self.at_end.p95(kind), most, "ms")
            self.limit("time without an answer", self.during.gap_ms, GAP_MS, "ms")
            self.limit("newcomers", self.during.slowest("newcomer"), NEWCOMER_MS, "ms")
            self.limit("/healthz", self.highest.slowest_health_s, HEALTH_S, "s")
            for failure in dict.fromkeys([*self.during.failures, *self.at_end.failures]):
                self.wrong.append(f"honest {failure}")
        if not self.is_at_rest(self.after):
            self.wrong.append("not back at rest")
        if self.highest.bad_health:
            said = self.highest.bad_health
            self.wrong.append(f"/healthz said {said[0] or 'nothing'}, {len(said)} times")

    def is_only_slow(self):
        timing = ("p95", "time without", "newcomers:", "/healthz:", "/healthz said nothing")
        return bool(self.wrong) and all(
            what.startswith(timing) or (what.startswith("honest") and "DEADLINE_EXCEEDED" in what)
            for what in self.wrong
        )

    def limit(self, what, value, most, unit):
        if value > most:
            self.wrong.append(f"{what}: {value:,.0f} {unit}".rstrip() + f", allowed {most:,.0f}")

    def cells(self):
        p95 = [
            " → ".join(f"{window.p95(kind):.1f}" for window in (self.at_rest, self.during, self.at_end))
            for kind in ("call", "update")
        ]
        return [
            self.number,
            self.name,
            self.way,
            f"{self.rest.memory_mb:.0f} → {self.highest.memory_mb:.0f} → {self.after.memory_mb:.0f}",
            f"{self.rest.threads} → {self.highest.threads} → {self.after.threads}",
            f"{self.rest.descriptors} → {self.highest.descriptors} → {self.after.descriptors}",
            *p95,
            f"{self.during.gap_ms:.0f}",
            f"{self.during.slowest('newcomer'):.0f}",
            f"{self.highest.slowest_health_s * 1000:.0f}",
            str(self.seen),
            "; ".join(self.wrong)
            or ("yes" if self.is_bounded else f"no limit; at rest after {self.rest_after_s:.0f} s"),
        ]


COLUMNS = [
    "row",
    "attack",
    "way",
    "memory, MB",
    "threads",
    "descriptors",
    "call, ms",
    "update, ms",
    "gap, ms",
    "newcomer, ms",
    "/healthz, ms",
    "the attacker saw",
    "held off",
]


def line(cells):
    return "| " + " | ".join(cells) + " |"


def write(path, rows):
    """Replaces what follows the heading `## Measured`."""
    text = path.read_text().split("\n## Measured")[0]
    lines = [
        "",
        f"## Measured: {time.strftime('%F')}",
        "",
        f"Commit {commit()}. {processor()}, {os.cpu_count()} threads.",
    ]
    lines += ["", line(COLUMNS), "|" + "---|" * len(COLUMNS), *(line(row.cells()) for row in rows)]
    path.write_text(text + "\n".join(lines) + "\n")


def commit():
    asked = subprocess.run([PROGRAM, "--version"], capture_output=True, text=True, check=True).stdout
    found = re.search(r"\((.*)\)", asked)
    return found[1] if found else "unknown"


def processor():
    found = re.search(r"^model name\s*: (.*)", Path("/proc/cpuinfo").read_text(), re.M)
    return found[1] if found else "an unknown processor"
