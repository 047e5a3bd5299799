"""F2 on the first page tells the experimenter what the session will do; nothing else on it does."""

import dataclasses
from pathlib import Path

import pytest
from textual.widgets import Static

from arl_tui.app.link import Ready
from arl_tui.app.session_setup import SessionSetup
from arl_tui.screens.overview import OverviewPage
from arl_tui.session_app import build_app
from core.session.protocol_reading import protocol_from
from tests.arl_tui.driving import SIZE
from tests.arl_tui.fakes import FakeLink

ANNEALED = protocol_from({"agent": {"scheme": "annealed"}, "session": {"episodes": 3}}, to_run=True)
SETUP = SessionSetup(protocol=ANNEALED, root_seed=5, participant="P01", recordings=Path("r"))


def words(screen: object) -> str:
    assert isinstance(screen, OverviewPage)
    return " ".join(str(line.render()) for line in screen.query(Static))


async def test_the_experimenter_reads_the_weight_in_each_game_and_the_reach() -> None:
    link = FakeLink()
    async with build_app(SETUP, link).run_test(size=SIZE) as pilot:
        await pilot.press("f2")
        await pilot.pause()
        told = words(pilot.app.screen)
        assert "annealed: w_r = 1, w_h 1, 0.98, 0.96 in games 1 to 3" in told
        assert "Reach  not worked out yet" in told
        assert "3 watched" in told
        assert "Credit  previous (rule, asked for by the protocol)" in told
        await pilot.press("f2")
        link.say(Ready(warm_up_ns=1, reach=0.92, step_s=1.6))
        await pilot.press("f2")
        await pilot.pause()
        assert "92% of a press reaches the step it was meant for" in words(pilot.app.screen)


@pytest.mark.parametrize(
    "hidden", [{"study": {"name": "a study"}}, {"simulated": True}], ids=["study", "demonstration"]
)
async def test_a_study_has_no_such_page(hidden: dict[str, object]) -> None:
    setup = dataclasses.replace(SETUP, **hidden)  # type: ignore[arg-type]
    async with build_app(setup, FakeLink()).run_test(size=SIZE) as pilot:
        first = pilot.app.screen
        await pilot.press("f2")
        await pilot.pause()
        assert pilot.app.screen is first


async def test_the_participants_help_does_not_name_the_key() -> None:
    async with build_app(SETUP, FakeLink()).run_test(size=SIZE) as pilot:
        await pilot.press("f1")
        await pilot.pause()
        assert "f2" not in " ".join(str(line.render()).lower() for line in pilot.app.screen.query(Static))
