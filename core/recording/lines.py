"""What one line of a recording says, whichever version of the format it is of."""

import msgspec

from core.recording import version_1
from core.recording.schema import Line

CHAIN_MARK = b',"chain":"'
"""What stands between what a line says and its chain."""

_decoder = msgspec.json.Decoder(Line)
_decoder_1 = msgspec.json.Decoder(version_1.Changed)


class _Kind(msgspec.Struct):
    """What has to be known of a line before it is decoded."""

    type: str = ""


def record_of(payload: bytes, version: int) -> Line:
    """Return what a line of a file of this version says, in today's terms.

    Raises:
        ValueError: it is none of this version (`msgspec.ValidationError` where a field is wrong).
    """
    kind = msgspec.json.decode(payload, type=_Kind).type
    changed = kind in version_1.CHANGED_TAGS
    if version == 1 and changed:
        before: version_1.Changed = _decoder_1.decode(payload)
        return before.upgraded()
    try:
        record: Line = _decoder.decode(payload)
    except msgspec.ValidationError as error:
        if changed and b'"w_h":' in payload:
            raise ValueError(
                f"{error}: this {kind} is of version 1 of the format (it says `w_h`), and the header says "
                f"version {version} (`trust`, `weight`): the header was changed, or two files were joined"
            ) from error
        raise
    return record


def line_of_file(line: bytes, version: int) -> Line:
    """Return what one sealed line of a recording says, without a check of its chain.

    Args:
        line: a whole line with its chain, without the line end.
        version: of the format, as the header says it.

    Raises:
        ValueError: it is no line of this version.
    """
    payload, mark, _ = line.rpartition(CHAIN_MARK)
    if not mark:
        raise ValueError(f"the line does not end with its chain; found {line[-40:]!r}")
    return record_of(payload + b"}", version)
