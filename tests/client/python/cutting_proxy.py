# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""A TCP proxy that can break all its connections, silently drop what is sent on them, or be slow."""
import socket
import threading
import time


class CuttingProxy:
    """Forwards its own loopback port to another. `rate`: bytes a second of each direction; 0: as fast as it goes."""

    def __init__(self, port, rate=0):
        self._target = ("127.0.0.1", port)
        self._rate = rate
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._lock = threading.Lock()
        self._sockets = []
        self._deaf = set()  # sockets whose answers are dropped
        self._dead = set()  # sockets that neither carry anything nor close
        self.connections = 0
        self.requests = 0  # pieces that clients have sent
        threading.Thread(target=self._accept, daemon=True).start()

    @property
    def address(self):
        return f"127.0.0.1:{self._listener.getsockname()[1]}"

    def cut(self):
        with self._lock:
            for end in self._sockets:
                try:
                    end.shutdown(socket.SHUT_RDWR)
                except OSError:
                    pass  # the other end has already closed it
            self._sockets.clear()

    def lose_answers(self):
        """Drops the answers of the present connections; later connections work."""
        with self._lock:
            self._deaf |= set(self._sockets)

    def silence(self):
        """The present connections carry nothing more in either direction, and neither end is told; later ones work."""
        with self._lock:
            self._dead |= set(self._sockets)

    def close(self):
        self._listener.close()
        self.cut()

    def _accept(self):
        while True:
            try:
                near, _ = self._listener.accept()
            except OSError:
                return
            far = socket.socket()
            if self._rate:  # a line holds little; the buffers of this machine would hold megabytes
                far.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 16_384)
            far.connect(self._target)
            with self._lock:
                self.connections += 1
                self._sockets += [near, far]
            for source, sink, is_answer in ((near, far, False), (far, near, True)):
                threading.Thread(target=self._forward, args=(source, sink, is_answer), daemon=True).start()

    def _forward(self, source, sink, is_answer):
        try:
            while data := source.recv(8192):
                if source in self._dead or (is_answer and sink in self._deaf):
                    continue
                if self._rate:
                    time.sleep(len(data) / self._rate)
                sink.sendall(data)
                self.requests += not is_answer
        except OSError:
            pass
        if source in self._dead:
            return
        for end in (source, sink):
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
