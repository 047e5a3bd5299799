"""What a check has found, and what follows for a session and for a calibration."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

Verdict = Literal["ok", "beware", "stop"]
Purpose = Literal["session", "calibration"]
PURPOSES: tuple[Purpose, ...] = ("session", "calibration")


@dataclass(frozen=True, slots=True)
class Finding:
    """One line of the report."""

    topic: str
    """What was looked at, in a word or two."""
    found: str
    """What was found: no names and no paths."""
    verdict: Verdict = "ok"
    """`stop`: the purposes in `stops` cannot go on. `beware`: they can, and something may be worse for it."""
    todo: str = ""
    """What to do about it; "" where the verdict is `ok`."""
    stops: tuple[Purpose, ...] = PURPOSES
    """What a verdict of `stop` stops."""
    private: str = ""
    """A path, or what else names a person or a machine; left out of reports."""

    def __post_init__(self) -> None:
        if self.verdict != "ok" and not self.todo:
            raise ValueError(f"{self.topic}: say what to do about {self.found!r}")


def stopped(findings: Iterable[Finding], purpose: Purpose) -> list[Finding]:
    """Return the findings that stop a purpose."""
    return [finding for finding in findings if finding.verdict == "stop" and purpose in finding.stops]


def lines(findings: Sequence[Finding], *, report: bool) -> list[str]:
    """Return the findings as text, one or two lines each.

    Args:
        findings: in the order of the report.
        report: leave out everything private.
    """
    width = max((len(finding.topic) for finding in findings), default=0)
    text = []
    for finding in findings:
        private = f" {finding.private}" if finding.private and not report else ""
        text.append(f"{finding.verdict:6}  {finding.topic:{width}}  {finding.found}{private}")
        if finding.todo:
            text.append(f"{'':6}  {'':{width}}  -> {finding.todo}")
    return text


def conclusions(findings: Sequence[Finding]) -> list[str]:
    """Return go or no go for each purpose, with the reasons."""
    said = []
    for purpose in PURPOSES:
        reasons = ", ".join(finding.topic for finding in stopped(findings, purpose))
        said.append(f"{purpose.capitalize()}: {f'no go ({reasons})' if reasons else 'go'}")
    return said
