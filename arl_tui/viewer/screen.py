"""The viewer's screen: game, credit, values, timeline, and the keys that move through a session."""

import math
import threading
from typing import ClassVar, Literal

import numpy as np
from textual import events
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.screen import Screen
from textual.widgets import Input

from arl_tui.drawing_rate import FRAME_S
from arl_tui.palette import palette_for
from arl_tui.themes import theme_in_use
from arl_tui.viewer.asked import question_lines
from arl_tui.viewer.boards import MarkedBoard, MarkedPitch
from arl_tui.viewer.drawing import NEAR_NS, decision_lines, feedback_lines, status_line
from arl_tui.viewer.game_view import GameView
from arl_tui.viewer.help import ViewerHelp
from arl_tui.viewer.looks import Look
from arl_tui.viewer.panels import key_line
from arl_tui.viewer.pictures import Pictures, PitchPictures, pictures_of
from arl_tui.viewer.reading import Viewing
from arl_tui.viewer.rows import BOLD, Rows
from arl_tui.viewer.timeline import Facts, Timeline, clock_text
from core.numerics.clock import Clock, MonotonicClock
from studies.session_view.index import open_index
from studies.session_view.session import Kind, Moment
from studies.session_view.tags import Tag
from studies.session_view.transport import Transport

ROOMY = 32
"""From so many lines on the timeline takes the whole width below the game."""
KEYS = (
    ("space", "play"), ("← →", "step"), ("[ ]", "press"), ("↑ ↓", "game"), ("+ -", "speed"), ("c", "rule"),
    ("w", "what-if"), ("n", "differs"), ("1-9", "tag"), ("h", "all keys"), ("q", "quit"),
)  # fmt: skip
Asking = Literal["press", "note", ""]


def _move(keys: str, kind: Kind, by: int) -> Binding:
    direction = "next" if by > 0 else "previous"
    return Binding(keys, f"move('{kind}', {by})", f"{direction} {kind}", id=f"viewer.{direction}-{kind}")


class ViewerScreen(Screen[str], inherit_bindings=False):
    """Draws what was on screen at the transport's time, and everything that is known of it."""

    BINDING_GROUP_TITLE = "Viewing"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("space", "play", "Play or pause", id="viewer.play"),
        _move("full_stop", "frame", 1),
        _move("comma", "frame", -1),
        _move("right", "step", 1),
        _move("left", "step", -1),
        _move("right_square_bracket", "press", 1),
        _move("left_square_bracket", "press", -1),
        _move("down", "game", 1),
        _move("up", "game", -1),
        Binding("shift+right", "scrub(1)", "Scrub on", id="viewer.scrub-on"),
        Binding("shift+left", "scrub(-1)", "Scrub back", id="viewer.scrub-back"),
        Binding("pagedown", "scrub(10)", "Scrub far on", id="viewer.scrub-far-on"),
        Binding("pageup", "scrub(-10)", "Scrub far back", id="viewer.scrub-far-back"),
        Binding("home", "end(-1)", "To the beginning", id="viewer.home"),
        Binding("end", "end(1)", "To the end", id="viewer.end"),
        Binding("plus,equals_sign", "speed(1)", "Faster", id="viewer.faster"),
        Binding("minus", "speed(-1)", "Slower", id="viewer.slower"),
        Binding("z", "zoom(2)", "Look closer", id="viewer.closer"),
        Binding("x", "zoom(0.5)", "Look from further away", id="viewer.further"),
        Binding("j", "ask('press')", "Go to a press by its number", id="viewer.jump"),
        Binding("c", "rule(1)", "Next credit rule", id="viewer.rule"),
        Binding("C", "rule(-1)", "Previous credit rule", id="viewer.rule-back"),
        Binding("m", "marks", "Marks on the game", id="viewer.marks"),
        Binding("w", "what_if", "What another rule would have made of it", id="viewer.what-if"),
        Binding("n", "difference(1)", "Next decision that differs", id="viewer.next-difference"),
        Binding("N", "difference(-1)", "Previous decision that differs", id="viewer.previous-difference"),
        *[
            Binding(str(digit), f"tag('{digit}')", f"Tag {digit}", id=f"viewer.tag-{digit}")
            for digit in range(1, 10)
        ],
        Binding("t", "ask('note')", "Note on the tag at hand", id="viewer.note"),
        Binding("d", "untag", "Remove the tag at hand", id="viewer.untag"),
        Binding("T", "next_tag", "Next tag", id="viewer.next-tag"),
        Binding("e", "export", "Write tagged moments as CSV", id="viewer.export"),
        Binding("p", "picture", "Save the screen as SVG and PNG", id="viewer.picture"),
        Binding("h,f1,question_mark", "guide", "All keys", id="viewer.help"),
        Binding("q,escape,ctrl+q,ctrl+c", "leave", "Leave", id="viewer.leave"),
    ]

    def __init__(
        self, viewing: Viewing, pictures: Pictures, *, clock: Clock | None = None, colours: str | None = None
    ) -> None:
        """Prepare.

        Args:
            viewing: the recording, and what is known of it.
            pictures: draws its game.
            clock: of the one who looks.
            colours: that can be shown ("truecolor", "256", "standard"); what the terminal has by default.
        """
        super().__init__()
        self.viewing = viewing
        self.session = viewing.session
        self.transport = Transport(self.session, clock or MonotonicClock())
        self.marks = True
        """Credited pieces, candidates and bars are drawn on the game."""
        self.broken: Exception | None = None
        """Why the rest of a long recording cannot be read."""
        self._pictures = self._drawn_by(pictures)
        self._colours = colours
        self._asking: Asking = ""
        self._said = ""
        self._drawn: tuple[object, ...] = ()
        self._board: MarkedBoard | None = None
        self._pitch: MarkedPitch | None = None

    # --- layout ---------------------------------------------------------------------------------------------

    def compose(self) -> ComposeResult:
        """Lay out the game on the left, everything else beside and below it."""
        colours = self._colours or self.app.console.color_system
        palette = palette_for(
            "standard",
            colours,
            no_color=self.app.no_color and self._colours is None,
            theme=theme_in_use(),
        )
        self._game = GameView(self.viewing, palette)
        self._board, self._pitch = self._game.board, self._game.pitch
        unit, facts = self.viewing.unit, Facts(self.session)
        with Horizontal(id="upper"):
            yield self._game.widget
            with Vertical(id="right"):
                yield Rows(id="status")
                yield Timeline(self.session, facts, unit, tall=False, id="timeline-right")
                yield Rows(id="credit")
                yield Rows(id="thought")
        yield Timeline(self.session, facts, unit, id="timeline-below")
        yield Rows(id="foot")

    def on_mount(self) -> None:
        """Begin to draw."""
        if self._pitch is not None:
            self.add_class("-keepaway")
        threading.Thread(target=self.viewing.warm_up, daemon=True).start()
        self.set_interval(FRAME_S, self.draw)
        self.call_after_refresh(self.draw)

    def on_resize(self, event: events.Resize) -> None:
        """Put the timeline where there is room."""
        self.set_class(event.size.height >= ROOMY, "-roomy")
        self._drawn = ()
        self.call_after_refresh(self.draw)

    @property
    def timeline(self) -> Timeline:
        """The timeline that is shown."""
        name = "#timeline-below" if self.has_class("-roomy") else "#timeline-right"
        return self.query_one(name, Timeline)

    # --- drawing --------------------------------------------------------------------------------------------

    def draw(self) -> None:
        """Draw what is due; nothing where nothing has changed."""
        if not self.is_current:
            return
        if self.viewing.whole is not None and self.viewing.whole.done:
            self._look_at_all()
        time_ns = self.transport.tick()
        key = (
            time_ns,
            self.transport.playing,
            self.transport.speed,
            self.viewing.state,
            self.marks,
            self._said,
            self.timeline.stretch,
            None if self.viewing.whole is None else round(self.viewing.whole.share, 2),
        )
        if key == self._drawn:
            return
        self._drawn = key
        moment = self.session.at(time_ns)
        look = self._pictures.at(moment)
        self._game.draw(moment, look, marks=self.marks)
        self._draw_text(moment, look)
        timeline = self.timeline
        timeline.differences = self.viewing.differences
        timeline.tags = self.viewing.tags.all
        timeline.draw(time_ns)

    def _look_at_all(self) -> None:
        """Go on with the whole recording, whose index is there now; leave where it is damaged."""
        whole, self.viewing.whole = self.viewing.whole, None
        assert whole is not None, "looked at before"
        try:
            whole.check()
            self.session.look_at(open_index(self.viewing.path))
        except Exception as error:  # noqa: BLE001 - whatever it is, the viewer ends, and the command names it
            self.broken = error
            self.dismiss("")
            return
        self.viewing.look_again()
        self._pictures = self._drawn_by(pictures_of(self.session))
        facts = Facts(self.session)
        for timeline in self.query(Timeline):
            timeline.renew(facts)

    def _drawn_by(self, pictures: Pictures) -> Pictures:
        if isinstance(pictures, PitchPictures):
            self.viewing.drawn_receivers = lambda: pictures.receivers
        return pictures

    def _draw_text(self, moment: Moment, look: Look) -> None:
        self.query_one("#status", Rows).show([status_line(self.viewing, self.transport, moment)])
        width = self.query_one("#credit", Rows).size.width
        lines = question_lines(self.viewing, moment)
        self.query_one("#credit", Rows).show(
            lines or feedback_lines(self.viewing, moment, width, roomy=self.has_class("-roomy"))
        )
        self.query_one("#thought", Rows).show(
            decision_lines(self.viewing, moment, width, roomy=self.has_class("-roomy"))
        )
        said = self._said or (look.words if look.view is not None else "")
        foot = self.query_one("#foot", Rows)
        foot.show([[(said, BOLD)] if said else key_line(KEYS, foot.size.width)])

    # --- keys -----------------------------------------------------------------------------------------------

    def say(self, text: str) -> None:
        """Write a sentence in place of the keys; it goes with the next key."""
        self._said = text
        self.draw()

    def on_key(self) -> None:
        """Take back what was said."""
        self._said = ""

    def action_play(self) -> None:
        """Play or pause."""
        self.transport.toggle()

    def action_move(self, kind: Kind, by: int) -> None:
        """Pause and go to the next or previous frame, step, press or game."""
        self.transport.move(kind, by)
        self.draw()

    def action_scrub(self, by: int) -> None:
        """Go on by hundredths of the stretch that is shown."""
        self.transport.seek(self.transport.time_ns + by * self.timeline.stretch.length_ns / 100)
        self.draw()

    def action_end(self, which: int) -> None:
        """Go to the beginning or to the end."""
        self.transport.seek(-math.inf if which < 0 else math.inf)
        self.draw()

    def action_speed(self, by: int) -> None:
        """Play faster or slower."""
        self.transport.faster(by)

    def action_zoom(self, factor: float) -> None:
        """Show a shorter or longer stretch on the timeline."""
        self.timeline.zoom(factor, self.transport.time_ns)
        self.draw()

    def action_rule(self, by: int) -> None:
        """Share the press out by another rule."""
        self.viewing.next_rule(by)
        self.draw()

    def action_marks(self) -> None:
        """Draw marks on the game, or none."""
        self.marks = not self.marks
        self.draw()

    def action_what_if(self) -> None:
        """Begin or end the side by side, with the credit rule that is on the strip or what the command
        named.
        """
        self.say(self.viewing.toggle_what_if())

    def action_difference(self, by: int) -> None:
        """Go to the next decision that both agents take differently."""
        times = self.viewing.differences
        at = self.transport.time_ns
        row = int(np.searchsorted(times, at, side="right")) if by > 0 else int(np.searchsorted(times, at)) - 1
        if 0 <= row < len(times):
            self.transport.playing = False
            self.transport.seek(int(times[row]))
            self.draw()
        else:
            where = "behind" if by > 0 else "before"
            self.say(
                f"No decision {where} this one differs"
                if self.viewing.other is not None
                else "w begins a what-if"
            )

    # --- tags -----------------------------------------------------------------------------------------------

    def action_tag(self, digit: str) -> None:
        """Mark this moment."""
        self.viewing.tags.add(Tag(self.transport.time_ns, digit))
        self.say(f"Tagged {digit}; t writes a note")

    def action_untag(self) -> None:
        """Remove the tag at hand."""
        tag = self.viewing.tags.near(self.transport.time_ns, NEAR_NS)
        if tag is not None:
            self.viewing.tags.remove(tag)
        self.say("No tag within a second" if tag is None else f"Removed tag {tag.tag}")

    def action_next_tag(self) -> None:
        """Go to the next tag, behind the last one to the first."""
        tags = self.viewing.tags.all
        at = self.transport.time_ns
        following = next((tag for tag in tags if tag.time_ns > at), tags[0] if tags else None)
        if following is None:
            self.say("No tags yet: 1-9 mark a moment")
        else:
            self.transport.seek(following.time_ns)
            self.draw()

    def action_export(self) -> None:
        """Write the tagged moments as CSV."""
        self.say(self.viewing.export_tags())

    def action_picture(self) -> None:
        """Save the screen."""
        from arl_tui.viewer.screenshot import save_screen

        self.say(save_screen(self.app, self.viewing.path, self.transport.time_ns - self.session.start_ns))

    # --- questions ------------------------------------------------------------------------------------------

    def action_ask(self, what: Asking) -> None:
        """Ask for a number or a note in a line at the bottom."""
        if self._asking:
            return
        self._asking = what
        self.transport.playing = False
        prompt = (
            "Number of the press"
            if what == "press"
            else "Note on this moment (Enter keeps it, Escape does not)"
        )
        answer = Input(placeholder=prompt, max_length=400)
        self.mount(answer)
        answer.focus()

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Act on the answer."""
        what, self._asking = self._asking, ""
        event.input.remove()
        self.set_focus(None)
        if what == "press":
            number = int(event.value) if event.value.strip().isdecimal() else 0
            if not self.transport.go_to_press(number):
                self.say(f"There are presses 1 to {len(self.session.times('press'))}")
        elif event.value.strip():
            self._keep_note(event.value.strip())
        self.draw()

    def _keep_note(self, note: str) -> None:
        at = self.transport.time_ns
        tag = self.viewing.tags.near(at, NEAR_NS)
        if tag is not None:
            self.viewing.tags.remove(tag)
        self.viewing.tags.add(Tag(at if tag is None else tag.time_ns, "n" if tag is None else tag.tag, note))

    def action_guide(self) -> None:
        """Show all keys."""
        self.transport.playing = False
        self.app.push_screen(ViewerHelp())

    def action_leave(self) -> None:
        """Take a question back, or leave."""
        if self._asking:
            self._asking = ""
            self.query_one(Input).remove()
            self.set_focus(None)
            return
        at = clock_text(self.transport.time_ns - self.session.start_ns)
        self.dismiss(f"Left at {at}")

    def on_timeline_sought(self, message: Timeline.Sought) -> None:
        """Go to where the mouse is."""
        self.transport.seek(message.time_ns)
        self.draw()
