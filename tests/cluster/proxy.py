"""A connection that tests can cut: it forwards one port to another until it drops all."""

import contextlib
import socket
import threading


class Proxy:
    """Forward connections to `port` of this machine to `target`, both ways."""

    def __init__(self, target):
        self.target = target
        self.server = socket.create_server(("127.0.0.1", 0))
        self.port = self.server.getsockname()[1]
        self.lock, self.open, self.made = threading.Lock(), [], 0
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        with contextlib.suppress(OSError):
            while True:
                near, _ = self.server.accept()
                far = socket.create_connection(self.target)
                with self.lock:
                    self.made += 1
                    self.open += [near, far]
                for one, other in ((near, far), (far, near)):
                    threading.Thread(target=self._pass_on, args=(one, other), daemon=True).start()

    def _pass_on(self, one, other):
        with contextlib.suppress(OSError):
            while data := one.recv(1 << 16):
                other.sendall(data)
        self._end(one, other)

    def drop(self):
        """Cut all connections and return how many there were. New ones pass."""
        with self.lock:
            cut, self.open = self.open, []
        self._end(*cut)
        return len(cut) // 2

    def close(self):
        self.server.close()
        self.drop()

    @staticmethod
    def _end(*sockets):
        for each in sockets:
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
            each.close()
