"""What a protocol will do, in words: games, presses, minutes, weight of the participant in each game."""

import math

from core.combination.config import Coach, EnvironmentOnly, EpisodeWeights, Exponential, FixedWeight, Linear
from core.feedback.delays import describe
from core.feedback.keys import KeyConfig
from core.plugins import plugin_of
from core.session.protocol import Protocol

SHOWN_GAMES = 5
FADED = 0.01
"""A weight below this fraction of the first game's is as good as none."""
ANSWER_S = 4.0
"""What an answer is taken to need, seconds: two or three options are read and compared. (Our choice.)"""
MEASURED = {
    "feedback-lag": "own measured delay of judging this game (task feedback lag)",
    "simple": "own measured delay of a simple reaction (task simple)",
    "pooled": "delay of judging this game, pooled with the others in the folder (task feedback lag)",
}
"""What `delay_of` means for a participant, in words."""


def plan(protocol: Protocol) -> dict[str, str]:
    """Return what a session does, in sentences by topic: games, presses, time, weight, credit."""
    return {
        "Game": f"{protocol.game}; learner {_tag(protocol.learner)}",
        "Games": _games(protocol),
        "Presses": _presses(protocol),
        **_questions(protocol),
        "Time": _time(protocol),
        "Weight": weight_in_words(protocol),
        "Credit": credit_in_words(protocol),
    }


def unseen_games(protocol: Protocol) -> int:
    """Return how many unseen games a whole session has."""
    session = protocol.session
    return session.unseen_before + session.unseen_between * (session.episodes - 1)


def expected_minutes(protocol: Protocol) -> float:
    """Return how long the watched games of a session take, in minutes, without pauses and unseen games."""
    game_s = plugin_of(protocol).expected_game_s(protocol)
    screen = protocol.screen
    games = protocol.session.episodes
    stretches = math.ceil(games / screen.games_per_stretch)
    waiting_s = games * screen.pause_between_episodes_s + stretches * screen.count_down_s
    return (games * game_s + waiting_s) / 60 + question_minutes(protocol)


def expected_questions(protocol: Protocol) -> float:
    """Return how many questions a whole session may be expected to pose, at most.

    Games are taken to be of all their steps. Of these, `share` are unsure enough to be asked about.
    """
    asking, session = protocol.agent.asking, protocol.session
    first = max(0, session.watched_steps - asking.minimum_decisions)
    steps = (min(first, session.watched_steps), *[session.watched_steps] * (session.episodes - 1))
    return sum(min(float(asking.per_episode), asking.share * step) for step in steps)


def question_minutes(protocol: Protocol) -> float:
    """Return how long these questions take, in minutes: `ANSWER_S` each, and the game stands still before."""
    asking = protocol.agent.asking
    each_s = asking.settle_s + min(ANSWER_S, asking.limit_s)
    return expected_questions(protocol) * each_s / 60 if asking.per_episode else 0.0


def weights_of_games(protocol: Protocol) -> list[EpisodeWeights]:
    """Return the weights of each watched game after the first press; those that go by trust at trust 1."""
    session, scheme = protocol.session, protocol.agent.scheme
    found = []
    for game in range(session.episodes):
        episode = session.unseen_before + game * (session.unseen_between + 1)
        number = game if getattr(scheme, "per", "episode") == "watched-game" else episode
        found.append(scheme.episode_weights(1.0, number))
    return found


def weight_in_words(protocol: Protocol) -> str:
    """Return the weight of the participant in each watched game, in words."""
    scheme, trust = protocol.agent.scheme, protocol.agent.bootstrap.trust
    name = _tag(scheme)
    if isinstance(scheme, EnvironmentOnly):
        return f"{name}: 0 in every game; presses are recorded and learned from, and decide nothing"
    if isinstance(scheme, Coach):
        return f"{name}: presses move the learner's policy itself (step size {scheme.step_size:g})"
    if isinstance(scheme, Linear | Exponential):
        rule = (
            f"{trust.w_h:g} in every game" if isinstance(trust, FixedWeight) else "found anew after each game"
        )
        whose = "of each person " if protocol.people else ""
        return (
            f"{name}: w_h {whose}by bootstrap learning ({_tag(trust)}): 0 before the first press, then {rule}"
        )
    what, values = _falling(weights_of_games(protocol))
    text = f"{name}: {what} {_listed(values)}"
    faded = next((game for game, value in enumerate(values, 1) if abs(value) < FADED * abs(values[0])), None)
    if faded is not None:
        text += f"; from game {faded} on below {FADED:.0%} of the first"
    return text


def credit_in_words(protocol: Protocol) -> str:
    """Return by whose delay presses are credited, for every participant."""
    rule = describe(protocol.agent.credit.delay)
    if protocol.delay_of == "rule" and any(person.delay is not None for person in protocol.people):
        own = (
            f"{person.name} {describe(credit.delay)}"
            for person, credit in zip(protocol.people, protocol.credit_of_participants, strict=True)
        )
        return f"as written in the protocol: {', '.join(own)}"
    if protocol.delay_of == "rule":
        return f"{rule}, as written in the protocol, for every participant"
    if protocol.delay_of == "paper":
        return "the paper's gamma:2.5,0.3, for every participant"
    missing = {
        "refuse": "the session does not start",
        "pooled": "the pooled delay of the others (at least five)",
        "paper": "the paper's gamma:2.5,0.3",
    }[protocol.delay_if_missing]
    return f"each participant's {MEASURED[protocol.delay_of]}; for a participant without one: {missing}"


def _falling(weights: list[EpisodeWeights]) -> tuple[str, list[float]]:
    """Return which quantity gives the participant a say, and its value in each game."""
    first = weights[0]
    if first.handover:
        return "probability of the participant's choice", [each.handover for each in weights]
    if first.shaping:
        return "reward per unit of H", [each.shaping for each in weights]
    return f"w_r = {first.w_r:g}, w_h", [each.w_h for each in weights]


def _listed(values: list[float]) -> str:
    if len(set(values)) == 1:
        return f"{values[0]:g} in every game"
    shown = [f"{value:.2g}" for value in values[:SHOWN_GAMES]]
    if len(values) > SHOWN_GAMES:
        shown += ["...", f"{values[-1]:.2g}"] if len(values) > SHOWN_GAMES + 1 else [f"{values[-1]:.2g}"]
    return f"{', '.join(shown)} in games 1 to {len(values)}"


def _games(protocol: Protocol) -> str:
    session = protocol.session
    text = f"{session.episodes} watched, each of at most {session.watched_steps} {plugin_of(protocol).steps}"
    unseen = unseen_games(protocol)
    if unseen:
        between = f"{session.unseen_before} before the first, {session.unseen_between} between two"
        text += f"; {unseen} unseen ({between})"
    return text


def _presses(protocol: Protocol) -> str:
    games = protocol.session.episodes
    if protocol.people:
        return "; ".join(
            f"{person.name}: {_presses_of(keys, games, ' in all,')}"
            for person, keys in zip(protocol.people, protocol.keys_of_people, strict=True)
        )
    keys = protocol.keys
    text = _presses_of(keys, games, " in all;")
    if keys.wrong_press_rate:
        text += f"; asked to press wrongly at {keys.wrong_press_rate:.0%} of the steps"
    return text


def _questions(protocol: Protocol) -> dict[str, str]:
    """Return what the agent asks; nothing where it asks nothing."""
    asking, games = protocol.agent.asking, protocol.session.episodes
    if asking.per_episode == 0:
        return {}
    return {
        "Asking": f"at most {asking.per_episode} in a game, {asking.per_episode * games} in all; about "
        f"{expected_questions(protocol):.0f} expected, {question_minutes(protocol):.1f} minutes; options "
        f"{', '.join(asking.keys[: asking.options])}, none of them {asking.none_key}, {asking.limit_s:g} "
        "seconds each"
    }


def _presses_of(keys: KeyConfig, games: int, in_all: str) -> str:
    """Return how many presses one participant has, and their keys."""
    most = keys.max_presses_per_episode
    letters = f"good {keys.good}, bad {keys.bad}"
    if keys.graded:
        letters = ", ".join(
            f"{value:+g} {key}" if value else f"0 {key}" for key, value in keys.meanings.items()
        )
    return f"at most {most} in a game, {most * games}{in_all} {letters}, take back {keys.retract}"


def _time(protocol: Protocol) -> str:
    minutes = expected_minutes(protocol)
    text = f"about {minutes:.0f} minutes" if minutes >= 1.5 else f"about {60 * minutes:.0f} seconds"
    return text + " of watching" + (", and the time of the unseen games" if unseen_games(protocol) else "")


def _tag(config: object) -> str:
    return str(getattr(config, "__struct_config__").tag)  # noqa: B009 - every configuration here is a struct
