"""Which key recordings are signed with: the file that the environment variable ARL_SIGNING_KEY names."""

import os
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from core.recording.signature import Sign

KEY_VARIABLE = "ARL_SIGNING_KEY"


class NoKey(ValueError):
    """The key that the environment names cannot be used; the message says why."""


def signer_in_use() -> "Sign | None":
    """Return what signs new recordings; None where they are not signed.

    Raises:
        NoKey: a key is named and cannot be used.
    """
    named = os.environ.get(KEY_VARIABLE, "")
    if not named:
        return None
    from core.recording.signature import SigningError, signer  # not for those who do not sign

    try:
        return signer(Path(named))
    except (SigningError, OSError) as error:
        raise NoKey(
            f"recordings are to be signed ({KEY_VARIABLE}), and the key cannot be used: {error}"
        ) from error
