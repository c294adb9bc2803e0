# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The server under attack: a process of the real program, and its figures from /proc and /healthz."""
import hashlib
import http.client
import os
import re
import signal
import subprocess
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path

BUILD = Path(os.environ["LATTICED_BUILD"])
PROGRAM = BUILD / "server/latticed"
MEMORY_MB = 256  # --memory
ALICE, MALLORY = "alice-is-honest", "mallory-is-not"  # tokens
START_S, END_S = 60, 30
TICK_S = 0.05


def token_line(token, name, role="edit"):
    return f"{hashlib.sha256(token.encode()).hexdigest()} {role} {name}\n"


@dataclass
class Figures:
    memory_mb: float
    threads: int
    descriptors: int


class Server:
    """Starts a server on free ports. `more` are further options. At the end of a with block it is stopped."""

    def __init__(self, work, *more, memory_mb=MEMORY_MB, limits="", unread_log=False):
        self.tokens = Path(work) / "tokens.txt"
        self.tokens.write_text(token_line(ALICE, "alice") + token_line(MALLORY, "mallory"))
        self._log = tempfile.NamedTemporaryFile(
            "r", dir=work, prefix="latticed-", suffix=".txt", delete=False
        )
        options = ["--backend", "cpu", "--memory", f"{memory_mb}MiB", "--token-file", str(self.tokens)]
        for port in ("listen", "http", "admin"):
            options += [f"--{port}", "127.0.0.1:0"]
        options += ["--drain-delay", "0s", *more]
        self._unread = os.pipe() if unread_log else ()
        output = self._unread[1] if unread_log else self._log.fileno()
        command = ["sh", "-c", f'{limits}\nexec "$0" "$@"', str(PROGRAM), *options]
        self.process = subprocess.Popen(command, stdout=output, stderr=output)
        self.pid = self.process.pid
        self.log_path = self._log.name
        self.find_ports()

    def find_ports(self):
        deadline = time.monotonic() + START_S
        while time.monotonic() < deadline and self.process.poll() is None:
            if self._unread:  # read until it serves, and never again
                with open(self.log_path, "ab") as file:
                    file.write(os.read(self._unread[0], 4096))
            found = re.search(r"serving address=\S+:(\d+) .*http=\S+:(\d+) admin=\S+:(\d+)", self.log)
            if found:
                self.port, self.http, self.admin = map(int, found.groups())
                return
            time.sleep(0.02)
        self.stop()
        raise RuntimeError(f"no server:\n{self.log}")

    @property
    def log(self):
        return Path(self.log_path).read_text(errors="replace")

    def figures(self):
        try:
            status = Path(f"/proc/{self.pid}/status").read_text()
            return Figures(
                int(re.search(r"VmRSS:\s+(\d+)", status)[1]) / 1024,
                int(re.search(r"Threads:\s+(\d+)", status)[1]),
                len(os.listdir(f"/proc/{self.pid}/fd")),
            )
        except (OSError, TypeError):  # it has ended
            return Figures(0, 0, 0)

    def has_ended(self):
        return self.process.poll() is not None

    def forget_highest_memory(self):
        Path(f"/proc/{self.pid}/clear_refs").write_text("5")

    def highest_memory_mb(self):
        try:
            found = re.search(r"VmHWM:\s+(\d+)", Path(f"/proc/{self.pid}/status").read_text())
        except OSError:
            found = None
        return int(found[1]) / 1024 if found else 0

    def health(self):
        """Asks /healthz. Returns its status and how long it took; status 0 if there was no answer in 5 s."""
        begun = time.monotonic()
        try:
            connection = http.client.HTTPConnection("127.0.0.1", self.admin, timeout=5)
            connection.request("GET", "/healthz")
            status = connection.getresponse().status
            connection.close()
        except (OSError, http.client.HTTPException):
            status = 0
        return status, time.monotonic() - begun

    def signal(self, number):
        self.process.send_signal(number)

    def stop(self):
        """Ends the process. Returns its exit code; -9 if SIGTERM did not end it in time."""
        self.process.terminate()
        try:
            self.process.wait(END_S)
        except subprocess.TimeoutExpired:
            self.process.send_signal(signal.SIGKILL)
            self.process.wait()
        self._log.close()
        for end in self._unread:
            os.close(end)
        self._unread = ()
        return self.process.returncode

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.stop()


class Watch:
    """Looks at a server all the time in a thread: its highest figures, and whether /healthz answers."""

    def __init__(self, server):
        self.server = server
        self.threads = self.descriptors = 0
        self.slowest_health_s, self.bad_health = 0.0, []
        server.forget_highest_memory()
        self._ends = threading.Event()
        self._threads = [threading.Thread(target=run) for run in (self._look, self._ask)]
        for thread in self._threads:
            thread.start()

    def _look(self):
        while not self._ends.wait(TICK_S):
            now = self.server.figures()
            self.threads = max(self.threads, now.threads)
            self.descriptors = max(self.descriptors, now.descriptors)

    def _ask(self):
        while not self._ends.wait(0.25):
            status, seconds = self.server.health()
            self.slowest_health_s = max(self.slowest_health_s, seconds)
            if status != 200:
                self.bad_health.append(status)

    def end(self):
        self._ends.set()
        for thread in self._threads:
            thread.join()
        self.memory_mb = self.server.highest_memory_mb()
        return self
