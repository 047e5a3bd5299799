"""What the app's tests share: a small protocol, and an app whose worker is faked."""

import gc
from collections.abc import Iterator
from pathlib import Path

import pytest

from arl_tui import language
from arl_tui.app import gaps
from arl_tui.session_app import ArlApp
from core.feedback.keys import KeyConfig
from core.numerics.clock import NS_PER_S
from core.session.protocol import Protocol, ScreenConfig, SessionConfig
from tests.arl_tui.driving import app_for
from tests.arl_tui.fakes import FakeLink
from tests.conftest import WORTH_COMPILING_AHEAD


@pytest.fixture(autouse=True, scope="session")
def _after_the_compiler(request: pytest.FixtureRequest) -> None:
    """Play games compiled in a run of all tests; a file that is run by itself compiles what it needs."""
    if len(request.session.items) > WORTH_COMPILING_AHEAD:
        request.getfixturevalue("compiled")


@pytest.fixture(autouse=True)
def no_gaps(monkeypatch: pytest.MonkeyPatch) -> None:
    """A busy machine may stand still for a second: only tests about that are to notice it."""
    monkeypatch.setattr(gaps, "LONGEST_NS", 3600 * NS_PER_S)


@pytest.fixture
def notices_gaps(no_gaps: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Standing still for a second is a gap, as in a session."""
    monkeypatch.setattr(gaps, "LONGEST_NS", NS_PER_S)


@pytest.fixture(autouse=True)
def _frozen_after_each_test() -> Iterator[None]:
    """Take what a test leaves behind out of later collections.

    Each app leaves some 20,000 objects that live on. Each session collects everything several times; after
    some hundred tests that took half of all time.
    """
    yield
    gc.collect()
    gc.freeze()


@pytest.fixture
def nothing_frozen() -> Iterator[None]:
    """As in a program of its own; the tests have frozen what they hold together (`tests/conftest.py`)."""
    gc.unfreeze()
    yield
    gc.freeze()


@pytest.fixture(autouse=True)
def colours_of_a_common_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pages look the same wherever the tests run: with 16 colours or none there are textures."""
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.setenv("COLORTERM", "truecolor")
    monkeypatch.delenv("NO_COLOR", raising=False)


@pytest.fixture(autouse=True)
def words_of_the_code() -> None:
    """The language and the keys are the process's: no test begins with those of another."""
    language.change_keys({})
    language.use("en")


@pytest.fixture
def protocol() -> Protocol:
    return Protocol(
        keys=KeyConfig(max_presses_per_episode=2),
        session=SessionConfig(episodes=2, unseen_between=3, watched_steps=4),
        screen=ScreenConfig(tick_ms=20, pause_between_episodes_s=0.1, count_down_s=0),
    )


@pytest.fixture
def link() -> FakeLink:
    return FakeLink()


@pytest.fixture
def app(protocol: Protocol, link: FakeLink, tmp_path: Path) -> ArlApp:
    return app_for(protocol, link, tmp_path)
