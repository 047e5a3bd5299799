"""What holds of any session: a retracted press leaves no trace, and no mass of a press is lost."""

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.feedback.assigner import CreditAssigner, CreditConfig
from core.feedback.credit import CurrentStep, GammaDelay, PreviousStep, UniformDelay
from tests.core.feedback.test_assigner import features, told

Event = Callable[[CreditAssigner], object]


@st.composite
def configs(draw: st.DrawFn) -> CreditConfig:
    scheme = draw(st.sampled_from(["individual", "aggregate"]))
    return CreditConfig(
        delay=draw(
            st.sampled_from([PreviousStep(), CurrentStep(), UniformDelay(), GammaDelay(), GammaDelay(2, 1)])
        ),
        scheme=scheme,
        silence=draw(st.sampled_from(["no-update", "zero-label"])) if scheme == "aggregate" else "no-update",
        merge_within_s=draw(st.sampled_from([0.0, 0.4])),
    )


@st.composite
def sessions(draw: st.DrawFn) -> list[tuple[int | None, Event]]:
    """Steps, pauses and presses in order of time, and the end."""
    events: list[tuple[int | None, Event]] = []
    now, step, press = 0, -1, 0
    for kind in draw(st.lists(st.sampled_from("sshppp"), max_size=40)):
        now += draw(st.integers(0, 1500)) * 1_000_000
        if kind == "s":
            step += 1
            events.append((None, lambda a, s=step, t=now: a.step_shown(s, t, features(s))))
        elif kind == "h" and step >= 0:
            events.append((None, lambda a, s=step, t=now: a.step_hidden(s, t)))
        elif kind == "p":
            value = draw(st.sampled_from([1.0, -1.0]))
            events.append((press, lambda a, p=press, t=now, v=value: a.add_press(p, t, v)))
            press += 1
    if draw(st.booleans()):
        events.append((None, lambda a, t=now + 1: a.finish(t)))
    return events


@given(configs(), sessions(), st.data())
def test_a_retracted_press_leaves_no_trace(
    config: CreditConfig, events: list[tuple[int | None, Event]], data: st.DataObject
) -> None:
    presses = [press for press, _ in events if press is not None]
    retracted = set(data.draw(st.lists(st.sampled_from(presses), unique=True))) if presses else set()
    with_it, without_it = CreditAssigner(config), CreditAssigner(config)
    for press, event in events:
        event(with_it)
        if press not in retracted:
            event(without_it)
        if press in retracted and data.draw(st.booleans(), label="retracted at once"):
            with_it.retract(press)
            retracted.discard(press)
    for press in retracted:
        with_it.retract(press)
    assert told(list(with_it.samples)) == told(list(without_it.samples))
    assert with_it.account == without_it.account


@given(configs(), sessions())
def test_all_mass_of_a_session_is_in_its_account(
    config: CreditConfig, events: list[tuple[int | None, Event]]
) -> None:
    assigner = CreditAssigner(config)
    for _, event in events:
        event(assigner)
    account = assigner.account
    mass = account.credited + account.before_first + account.in_gaps + account.too_late
    assert mass == pytest.approx(account.presses, abs=1e-9)
    if config.scheme == "individual":
        assert sum(sample.weight for sample in assigner.samples) == pytest.approx(account.credited, abs=1e-9)


@given(sessions())
def test_both_schemes_share_the_same_mass(events: list[tuple[int | None, Event]]) -> None:
    """Sum of weight * label is the same, whether presses stay apart or are added up per step."""
    sums = []
    for scheme in ("individual", "aggregate"):
        assigner = CreditAssigner(CreditConfig(delay=UniformDelay(), scheme=scheme))  # type: ignore[arg-type]
        for _, event in events:
            event(assigner)
        try:
            assigner.finish(10**15)
        except ValueError:
            raise AssertionError("finishing twice is allowed") from None
        sums.append(sum(sample.weight * sample.label for sample in assigner.samples))
    assert sums[0] == pytest.approx(sums[1], abs=1e-9)
