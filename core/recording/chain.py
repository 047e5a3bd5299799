"""The running hash that ties every line of a recording to all lines before it."""

import hashlib

CHAIN_DIGITS = 16


class Chain:
    """The hash of all lines so far."""

    def __init__(self) -> None:
        self._hash = hashlib.sha256()

    def seal(self, payload: bytes) -> bytes:
        """Return the line for `payload` (a JSON object): with its chain and a newline."""
        return payload[:-1] + b',"chain":"' + self.advance(payload) + b'"}\n'

    def copy(self) -> "Chain":
        """Return a chain that goes on from here by itself."""
        other = Chain()
        other._hash = self._hash.copy()
        return other

    def go_back_to(self, earlier: "Chain") -> None:
        """Forget what was taken in since `earlier` was copied."""
        self._hash = earlier._hash.copy()

    def to_sign(self, events: int) -> bytes:
        """Return what is signed: the hash of all lines so far, and how many events there are."""
        return b"arl-recording %d events " % events + self._hash.digest()

    def advance(self, payload: bytes) -> bytes:
        """Take in `payload` and return the chain's digits after it."""
        self._hash.update(payload)
        return self._hash.hexdigest()[:CHAIN_DIGITS].encode()
