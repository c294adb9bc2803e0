# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""HAProxy with docker/haproxy.cfg in front of a server, with addresses of this machine."""
import re
import socket
import subprocess
import time
from pathlib import Path

CONFIGURATION = Path(__file__).resolve().parents[2] / "docker/haproxy.cfg"
READY_S = 60


def make_certificate(work):
    """Writes ca.pem, and latticed.pem with the key, for localhost."""
    names = "subjectAltName=DNS:localhost,IP:127.0.0.1"
    command = f"openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=localhost -addext {names}".split()
    subprocess.run(
        [*command, "-keyout", work / "key.pem", "-out", work / "ca.pem"], check=True, capture_output=True
    )
    text = (work / "ca.pem").read_text() + (work / "key.pem").read_text()
    (work / "latticed.pem").write_text(text)


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Proxy:
    """The honest client comes from the address ::1, attackers from addresses of 127.0.0.0/8. Each address has
    limits of its own. Clients have 2 s, not 10 s, to send headers and the first bytes of a message."""

    def __init__(self, work, server):
        self.port = free_port()
        self.ca = str(work / "ca.pem")
        if not (work / "ca.pem").exists():
            make_certificate(work)
        text = CONFIGURATION.read_text()
        bind = re.search(r"bind 0\.0\.0\.0:443 (.*)", text)[1]
        text = text.replace(
            f"bind 0.0.0.0:443 {bind}", f"bind 127.0.0.1:{self.port} {bind}\n  bind ::1:{self.port} {bind}"
        )
        text = text.replace("/etc/haproxy", str(work)).replace("port 9090", f"port {server.admin}")
        text = text.replace(" latticed:50151", f" 127.0.0.1:{server.port}")
        text = text.replace(" latticed:8080", f" 127.0.0.1:{server.http}")
        text = re.sub(r"(timeout http-request|wait-for-body time) 10s", r"\1 2s", text)
        (work / "haproxy.cfg").write_text(text)
        self._log = open(work / "haproxy.txt", "w")
        self._process = subprocess.Popen(
            ["haproxy", "-db", "-f", work / "haproxy.cfg"], stdout=self._log, stderr=self._log
        )
        self.wait()

    def wait(self):
        deadline = time.monotonic() + READY_S
        while time.monotonic() < deadline:
            try:
                socket.create_connection(("127.0.0.1", self.port), 1).close()
                return
            except OSError:
                time.sleep(0.02)
        raise RuntimeError(f"HAProxy did not start: {Path(self._log.name).read_text()}")

    def stop(self):
        self._process.kill()
        self._process.wait()
        self._log.close()
