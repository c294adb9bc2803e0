# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""A real server on a free port of the loopback."""
import os
import re
import subprocess
import tempfile
import time
from pathlib import Path

BUILD = Path(os.environ["LATTICED_BUILD"])
ROOT = Path(os.environ["LATTICED_ROOT"])
LATTICECTL = BUILD / "client/cpp/latticectl"


class ServerProcess:
    """Starts a server, and stops it without a drain delay at the end of a with block. port 0: a free one."""

    def __init__(self, *arguments, port=0):
        self._log = tempfile.NamedTemporaryFile("r", prefix="latticed-", suffix=".txt")
        command = f"{BUILD}/server/latticed --listen 127.0.0.1:{port} --backend cpu --drain-delay 0s".split()
        self._process = subprocess.Popen(
            [*command, *arguments], stdout=self._log.fileno(), stderr=self._log.fileno()
        )
        self.port = self._wait_for_port()

    @property
    def address(self):
        return f"127.0.0.1:{self.port}"

    @property
    def log(self):
        return Path(self._log.name).read_text()

    def _wait_for_port(self):
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline and self._process.poll() is None:
            found = re.search(r"serving address=127\.0\.0\.1:(\d+)", self.log)
            if found:
                return int(found[1])
            time.sleep(0.02)
        self.stop()
        raise RuntimeError(f"no server:\n{self.log}")

    def kill(self):
        """Ends the process as a power cut would."""
        self._process.kill()
        self._process.wait(timeout=60)

    def stop(self):
        self._process.terminate()
        self._process.wait(timeout=60)
        self._log.close()

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.stop()
