"""Which episode comes next, and what a weight that falls is asked about."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.combination.config import SCHEMES, Annealed, Linear
from core.combination.schedule import EpisodesSoFar, NextEpisode, next_episode
from core.session.protocol import SessionConfig
from tests.data_folder import REPOSITORY

FALLING = [kind for kind in SCHEMES.values() if "decay" in kind.__struct_fields__]


def test_every_scheme_with_a_decay_says_what_its_weight_falls_with():
    assert len(FALLING) == 4
    assert all(kind().per == "watched-game" for kind in FALLING)
    assert all("per" not in kind.__struct_fields__ for kind in SCHEMES.values() if kind not in FALLING)


@pytest.mark.parametrize("kind", FALLING)
def test_a_schedule_goes_by_watched_games_or_by_episodes(kind):
    so_far = EpisodesSoFar(910, 10)
    assert next_episode(kind(per="watched-game"), so_far) == NextEpisode(number=910, scheduled=10)
    assert next_episode(kind(per="episode"), so_far) == NextEpisode(number=910, scheduled=910)


def test_other_schemes_are_asked_about_the_episode():
    assert next_episode(Linear(), EpisodesSoFar(910, 10)) == NextEpisode(910, 910)


@given(st.lists(st.booleans(), max_size=30))
def test_episodes_are_counted_one_by_one(watched):
    so_far = EpisodesSoFar()
    for one in watched:
        so_far = so_far.after(watched=one)
    assert so_far == EpisodesSoFar(len(watched), sum(watched))


def test_the_page_on_annealing_prints_the_weights_of_a_default_session():
    between = SessionConfig().unseen_between
    page = (REPOSITORY / "docs" / "decisions" / "annealing.md").read_text(encoding="utf-8")
    for per in ("episode", "watched-game"):
        scheme = Annealed(per=per)
        weights = []
        for game in (1, 2, 3, 4, 5, 10, 20, 50):
            so_far = EpisodesSoFar((game - 1) * (1 + between), game - 1)
            weights.append(scheme.episode_weights(0.0, next_episode(scheme, so_far).scheduled).w_h)
        assert f'| `per = "{per}"` | {" | ".join(f"{weight:.2g}" for weight in weights)} |' in page


@pytest.mark.parametrize(("episodes", "watched"), [(-1, 0), (3, -1), (3, 4)])
def test_impossible_counts_are_refused(episodes, watched):
    with pytest.raises(ValueError, match="0 <= watched <= episodes"):
        EpisodesSoFar(episodes, watched)
