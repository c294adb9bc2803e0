# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""What an attack is, and how it reaches its target. Attacks run in processes of their own."""
import re
import time
import urllib.request
from dataclasses import dataclass, field

from http2 import Connection
from server import MALLORY

CODES = "OK CANCELLED UNKNOWN INVALID_ARGUMENT DEADLINE_EXCEEDED NOT_FOUND ALREADY_EXISTS PERMISSION_DENIED".split()
CODES += (
    "RESOURCE_EXHAUSTED FAILED_PRECONDITION ABORTED OUT_OF_RANGE UNIMPLEMENTED INTERNAL UNAVAILABLE".split()
)
CODES += "DATA_LOSS UNAUTHENTICATED".split()
CLOSED = (ConnectionError, OSError)
SOURCE = "127.0.1.1"  # an address of the attackers' own
TIDY_SOURCE = "127.0.1.200"  # the proxy may refuse connections of SOURCE after an attack

every_attack = []


@dataclass
class Target:
    """Where an attack goes. `port` is the proxy's if there is a `ca`."""

    port: int
    http: int
    admin: int
    pid: int
    ca: str
    scene: str  # of the honest client
    log: str  # path
    tokens: str  # path
    seconds: float
    is_proxied: bool = False
    is_honest_too: bool = False  # the attack measures what happens to its own clients
    token: str = MALLORY

    def connect(self, source=SOURCE, token=None, **options):
        return Connection(self.port, self.ca, source, token=token or self.token, **options)

    def connect_again(self, seen):
        """Connects once the other side lets us, or raises when the attack is over by far."""
        seen.count("closed")
        end = time.monotonic() + self.seconds + 20
        while True:
            try:
                return self.connect()
            except CLOSED:
                if time.monotonic() > end:
                    raise
                time.sleep(0.5)  # the proxy counts refused connections too

    def connect_without_token(self, source=SOURCE, **options):
        return Connection(self.port, self.ca, source, **options)

    def calls_going_on(self, method):
        """How many calls of a method the server has begun and not ended."""
        with urllib.request.urlopen(f"http://127.0.0.1:{self.admin}/metrics", timeout=5) as answer:
            text = answer.read().decode()
        counts = {
            what: sum(
                float(value)
                for value in re.findall(rf'latticed_rpc_{what}_total{{.*{method}".*}} (\S+)', text)
            )
            for what in ("started", "finished")
        }
        assert counts["started"] > 0, f"no call of {method} in the metrics"
        return int(counts["started"] - counts["finished"])

    def until_end(self):
        """Yields until the time of the attack is over."""
        end = time.monotonic() + self.seconds
        while time.monotonic() < end:
            yield


@dataclass
class Seen:
    """What the attacker saw: counts by word, and what should not have been."""

    counts: dict = field(default_factory=dict)
    wrong: list = field(default_factory=list)

    def count(self, word, more=1):
        self.counts[word] = self.counts.get(word, 0) + more

    def count_status(self, status):
        self.count(CODES[status] if status is not None else "no status")

    def expect(self, condition, what):
        if not condition and what not in self.wrong:
            self.wrong.append(what)

    def __str__(self):
        return ", ".join(f"{number:,} {word}" for word, number in self.counts.items())


@dataclass
class Attack:
    run: object  # function(Target, Seen)
    row: str  # of the table of attacks
    seconds: float = 5
    quick: dict = field(default_factory=dict)  # in CI's set: seconds, by way
    options: tuple = ()  # of the server
    limits: str = ""  # a command of the shell that sets limits of the server's process
    unread_log: bool = False  # the log is a pipe that nobody reads
    leaves_traces: bool = False  # which the server may keep for an hour
    ends_server: bool = False
    only: str = ""  # "direct", "proxied" or "" for both
    unbounded: tuple = ()  # ways in which figures are told, without a limit

    @property
    def name(self):
        return self.run.__name__.replace("_", " ")


def attack(row, **settings):
    """Makes a function an attack of that row."""

    def register(run):
        every_attack.append(Attack(run, row, **settings))
        return run

    return register
