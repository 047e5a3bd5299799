"""What the guard writes after a crash arrives whole."""

import os
import threading

from arl_tui.app.terminal_guard import write_all


def test_a_long_text_arrives_whole_where_the_terminal_takes_a_part_at_a_time() -> None:
    theirs, ours = os.pipe()
    os.set_blocking(ours, False)  # as the app's input thread may have left it
    text = b"line of a trace\r\n" * 50_000
    read: list[bytes] = []

    def reading() -> None:
        while part := os.read(theirs, 4096):
            read.append(part)

    reader = threading.Thread(target=reading)
    reader.start()
    write_all(ours, text)
    os.close(ours)
    reader.join(10.0)
    os.close(theirs)
    assert b"".join(read) == text
