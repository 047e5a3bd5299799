"""Keys of answers to questions: what they must not mean besides."""

from collections.abc import Iterator

from core.configuration.messages import Path
from core.configuration.reading import Problem
from core.session.protocol import Protocol


def keys_used_twice(protocol: Protocol) -> Iterator[Problem]:
    """Yield keys of answers that mean something else while a question is on screen."""
    asking = protocol.agent.asking
    if asking.per_episode == 0:
        return
    if protocol.people:
        yield Problem(
            ("agent", "asking", "per_episode"),
            "expected 0 beside several people: a question has one answer, and one human model learns from it",
            asking.per_episode,
        )
        return
    taken = {"p": "pauses", "h": "shows the help", "q": "stops the session"}
    keys = protocol.keys
    taken[keys.retract] = "is keys.retract"
    if keys.graded:
        taken |= dict.fromkeys(keys.graded, "is one of keys.graded")
    else:
        taken |= {keys.good: "is keys.good", keys.bad: "is keys.bad"}
    for key in asking.answer_keys:
        if key in taken:
            where: Path = ("agent", "asking", "none_key" if key == asking.none_key else "keys")
            yield Problem(where, f"the key {key} {taken[key]}: choose another one for answers", key)
