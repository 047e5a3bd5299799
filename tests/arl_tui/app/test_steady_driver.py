"""Whatever bytes a terminal sends, the reader goes on."""

from hypothesis import given
from hypothesis import strategies as st
from textual import events
from textual.message import Message

from arl_tui.app.steady_driver import InputReader, SteadyFile


def keys_of(*parts: bytes) -> list[str]:
    posted: list[Message] = []
    reader = InputReader(posted.append)
    for part in parts:
        reader.take(part)
    reader.idle()
    return [message.key for message in posted if isinstance(message, events.Key)]


def test_letters_are_keys() -> None:
    assert keys_of(b"j", b"fu") == ["j", "f", "u"]


def test_a_character_that_arrives_in_two_parts_is_one_key() -> None:
    assert keys_of("é".encode()[:1], "é".encode()[1:]) == keys_of("é".encode())


def test_a_latin_1_key_is_a_key_without_a_meaning_and_takes_no_other_with_it() -> None:
    assert keys_of(b"\xe9") == ["replacement_character"]
    assert keys_of(b"\xe9j") == ["replacement_character", "j"]


@given(st.lists(st.binary(max_size=40), max_size=6))
def test_no_bytes_whatever_stop_the_reader(parts: list[bytes]) -> None:
    posted: list[Message] = []
    reader = InputReader(posted.append)
    for part in parts:
        reader.take(part)
        reader.idle()


@given(
    st.lists(st.sampled_from([b"\x1b[", b"<", b"M", b"0", b";", b"9" * 30, b"$y", b"\xff", b"u", b"R", b"t"]))
)
def test_no_sequence_of_control_parts_stops_the_reader(parts: list[bytes]) -> None:
    reader = InputReader(lambda message: None)
    reader.take(b"".join(parts))
    reader.idle()


class Broken:
    """A terminal that has gone."""

    line_buffering = True

    def write(self, text: str) -> int:
        raise OSError(5, "Input/output error")

    def flush(self) -> None:
        raise OSError(5, "Input/output error")


def test_a_terminal_that_takes_nothing_is_reported_and_does_not_fail() -> None:
    told: list[str] = []
    file = SteadyFile(Broken(), lambda: told.append("gone"))
    assert file.write("text") == 4
    file.flush()
    assert told == ["gone", "gone"]
    assert file.line_buffering
