"""The delay of judging of the typical participant of a folder: runs in a process of its own, as fits do."""

import sys
from pathlib import Path

import msgspec

from arl_tui.calibration.plan import newest_complete
from arl_tui.participants import FEEDBACK_LAG, GroupDelay
from core.feedback.delays import GammaDelay


class GroupOrder(msgspec.Struct, frozen=True, kw_only=True):
    """What is to be fitted."""

    recordings: str
    game: str


def fit_group(order: GroupOrder) -> GroupDelay:
    """Return the middle of the group's delays: what a participant without trials is expected to need.

    Raises:
        FitError: fewer than five participants have finished the task.
        TrialFileError: a trial file is damaged.
    """
    from studies.reaction_time.exclusion import ExclusionPolicy, select
    from studies.reaction_time.pooling import pool, typical
    from studies.reaction_time.read import read_rows

    paths = sorted(newest_complete(Path(order.recordings), FEEDBACK_LAG, order.game))
    samples, _ = select(read_rows(paths), ExclusionPolicy())
    group, _ = pool(samples)
    shape, scale_s, offset_s = typical(group)
    return GroupDelay(
        delay=GammaDelay(shape=shape, scale_s=scale_s, offset_s=offset_s),
        n_people=len(samples),
        files=tuple(path.name for path in paths),
    )


def main() -> None:
    """Read an order from the standard input, write the delay to the standard output, both JSON."""
    order = msgspec.json.decode(sys.stdin.buffer.read(), type=GroupOrder)
    try:
        found = fit_group(order)
    except (ValueError, OSError) as error:
        sys.exit(str(error))
    sys.stdout.buffer.write(msgspec.json.encode(found))


if __name__ == "__main__":
    main()
