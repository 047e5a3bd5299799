"""Tables of a configuration whose types are not all known here: what a game is set up by is declared by the
game.

A closed set of types is a union of structs. An open one is a subclass of `OpenTable`: the structs of its
types inherit from it, and it names them by their tags when they are asked for.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar

import msgspec

TAG = "type"
"""Key that says which of several tables is meant."""
OWN_PLACE = " - at `$"
"""How msgspec ends a message with the place in what was read."""


class OpenTable:
    """Base of a table whose types are declared elsewhere."""

    __slots__ = ()

    if TYPE_CHECKING:
        __struct_config__: ClassVar[msgspec.structs.StructConfig]

    @classmethod
    def structs(cls) -> Mapping[str, type[msgspec.Struct]]:
        """Return the struct of each type by its tag. The mapping is live: it shows what is declared at the
        time.
        """
        raise NotImplementedError


def decode_open_table(kind: type, value: Any) -> Any:
    """Return what an open table holds: the `dec_hook` of msgspec for configurations.

    Args:
        kind: type of the field.
        value: plain types, as in TOML, JSON or MessagePack; of a struct that is written as an array, a list.

    Raises:
        ValueError: the table is of no known type, or a value in it cannot be used.
        NotImplementedError: the field is no open table.
    """
    if not issubclass(kind, OpenTable):
        raise NotImplementedError(f"a setting cannot be of the type {kind}")
    if isinstance(value, kind):
        return value
    structs = kind.structs()
    if isinstance(value, Mapping):
        tag = value.get(TAG)
    else:
        tag = value[0] if isinstance(value, list | tuple) and value else None
    if not isinstance(tag, str) or tag not in structs:
        raise ValueError(f"expected a table of one of the types {', '.join(structs)}, got {tag!r}")
    try:
        return msgspec.convert(value, structs[tag], dec_hook=decode_open_table)
    except msgspec.ValidationError as error:
        # msgspec adds the place of this table; two places in one message would be read in the wrong order.
        reason, _, place = str(error).partition(OWN_PLACE)
        within = place.strip("`.")
        raise ValueError(f"{reason} (in {within})" if within else reason) from error
