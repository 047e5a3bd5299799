"""Signatures of recordings: Ed25519 by a key of the experimenter's (optional: `pip install
'arl-tui[signing]'`).

The chain of a recording is a hash: it finds damage, but who changes the file can compute it anew. A
signature in the end line cannot be made without the private key. What it proves, and what not, is said in
`SECURITY.md`.
"""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from core.recording.reader import Recording
from core.system.private_files import create_private, write_all

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey

Sign = Callable[[bytes], bytes]
"""Returns the signature of a message, 64 bytes."""
Verdict = Literal["signed", "not signed", "another key, or changed", "no end line"]


class SigningError(ValueError):
    """A key cannot be used; the message says which, why, and what to do."""


def make_key(path: Path) -> Path:
    """Write a new private key, readable by its owner only, and its public key beside it.

    Args:
        path: of the private key; the public one has `.pub` behind it.

    Returns:
        The path of the public key.

    Raises:
        SigningError: the library is missing.
        FileExistsError: there is a file already; keys are never overwritten.
        OSError: a file cannot be written.
    """
    _need_library()
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
    from cryptography.hazmat.primitives.serialization import (
        Encoding,
        NoEncryption,
        PrivateFormat,
        PublicFormat,
    )

    key = Ed25519PrivateKey.generate()
    public = path.with_name(f"{path.name}.pub")
    if public.exists():
        raise FileExistsError(17, "there is such a file already, and keys are never overwritten", str(public))
    with create_private(path) as file:
        try:
            write_all(file, key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()))
            public.write_bytes(key.public_key().public_bytes(Encoding.PEM, PublicFormat.SubjectPublicKeyInfo))
        except OSError:  # half a key must not stand in the way of a whole one
            path.unlink()
            public.unlink(missing_ok=True)
            raise
    return public


def signer(path: Path) -> Sign:
    """Return what signs with the private key in a file.

    Raises:
        SigningError: the library is missing, or the file holds no such key.
        OSError: it cannot be read.
    """
    _need_library()
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
    from cryptography.hazmat.primitives.serialization import load_pem_private_key

    try:
        key = load_pem_private_key(_beginning(path), password=None)
    except (ValueError, TypeError) as error:
        raise SigningError(
            f"{path}: not a private key without a password: `arl recordings --make-key FILE` makes one"
        ) from error
    if not isinstance(key, Ed25519PrivateKey):
        raise SigningError(f"{path}: a key of another kind than Ed25519: `arl recordings --make-key FILE`")
    signing: Ed25519PrivateKey = key
    return signing.sign


def public_key(path: Path) -> "Ed25519PublicKey":
    """Return the public key in a file.

    Raises:
        SigningError: the library is missing, or the file holds no such key.
        OSError: it cannot be read.
    """
    _need_library()
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey
    from cryptography.hazmat.primitives.serialization import load_pem_public_key

    try:
        key = load_pem_public_key(_beginning(path))
    except ValueError as error:
        raise SigningError(
            f"{path}: not a public key; the file that `arl recordings --make-key` wrote ends in .pub"
        ) from error
    if not isinstance(key, Ed25519PublicKey):
        raise SigningError(f"{path}: a key of another kind than Ed25519")
    return key


def verify(recording: Recording, key: "Ed25519PublicKey") -> Verdict:
    """Return whether a recording was signed with the private part of a key, and not changed since."""
    from cryptography.exceptions import InvalidSignature

    if not recording.complete:
        return "no end line"
    if not recording.signature:
        return "not signed"
    try:
        key.verify(bytes.fromhex(recording.signature), recording.signed)
    except (InvalidSignature, ValueError):
        return "another key, or changed"
    return "signed"


def _beginning(path: Path) -> bytes:
    """Return a file's first bytes, more than a key has: what is named as one may be anything."""
    with path.open("rb") as file:
        return file.read(1 << 16)


def _need_library() -> None:
    try:
        import cryptography  # noqa: F401
    except ImportError as error:
        raise SigningError("signatures need a library: pip install 'arl-tui[signing]'") from error
