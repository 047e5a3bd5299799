"""Small studies for tests."""

import msgspec

from studies.lab.config import Study


def plain_study(*, conditions=2, assignment=None, seed=1, **other):
    """Return a study as plain tables: consent, one block for each condition, thanks."""
    assignment = assignment or {"type": "latin-square"}
    blocks = conditions if assignment["type"] == "latin-square" else len(assignment.get("orders", [[""]])[0])
    steps = [
        {"type": "consent", "text": "consent.md"},
        *[{"type": "block"}] * blocks,
        {"type": "debriefing", "text": "thanks.md"},
    ]
    return {
        "name": "small",
        "seed": seed,
        "participants": 8,
        "conditions": {f"c{k}": {"agent": {"scheme": {"type": "linear"}}} for k in range(conditions)},
        "assignment": assignment,
        "sittings": [{"name": "day 1", "steps": steps}],
    } | other


def study_of(**changes):
    """Return a study, decoded."""
    return msgspec.convert(plain_study(**changes), Study)
