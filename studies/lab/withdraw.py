"""Participants who leave. Withdrawal removes everything of one participant, and leaves a tombstone without
identity; who drops out keeps their files.
"""

import shutil
from pathlib import Path

from studies.lab.config import Study
from studies.lab.enrolment import NotNow
from studies.lab.folder import exports_folder, participant_folder
from studies.lab.ledger import DroppedOut, Ledger, Withdrawn
from studies.lab.notes import forget
from studies.lab.progress import Participant, progress
from studies.lab.running import NAME, only_sitting


def withdraw(ledger: Ledger, code: str) -> Withdrawn:
    """Remove a participant's files, and replace the code in the ledger by a number.

    The order of work makes a kill harmless: while the code stands in the ledger, withdrawing again finishes
    the work. Tables that mix participants are removed as a whole; `arl export` makes them anew.

    Args:
        ledger: of the study.
        code: of the participant.

    Returns:
        The tombstone.

    Raises:
        NotNow: nobody with this code takes part, or a sitting of theirs is running.
        OSError: a file cannot be removed; the ledger still holds the code.
    """
    known = check_takes_part(ledger, code)
    folder = participant_folder(ledger.folder, code)
    with only_sitting(folder, code):
        removed = _remove(folder) + _remove(exports_folder(ledger.folder))
    number = 1 + sum(person.withdrawn for person in known.values())
    tombstone = Withdrawn(code=f"withdrawn-{number}", files_removed=removed)
    forget(ledger.folder, code, tombstone.code)
    ledger.replace_code(code, tombstone.code, last=tombstone)
    return tombstone


def check_takes_part(ledger: Ledger, code: str) -> dict[str, Participant]:
    """Return all participants of a study by code.

    Raises:
        NotNow: nobody with this code takes part.
    """
    known = progress(ledger.lines()).participants
    if code not in known or known[code].withdrawn:
        raise NotNow(f"nobody with the code {code} takes part in this study: check the code")
    return known


def drop_out(study: Study, ledger: Ledger, code: str, reason: str) -> None:
    """Count a participant as dropped out; their files are kept.

    Args:
        study: whose timeline it is.
        ledger: of the study.
        code: of the participant.
        reason: for the ledger.

    Raises:
        NotNow: nobody with this code takes part, or they have finished, or dropped out before.
    """
    person = check_takes_part(ledger, code)[code]
    if person.next_sitting(study) == len(study.sittings):
        raise NotNow(
            f"{code} has finished and keeps the place. `arl study withdraw` removes the data of one who "
            "withdraws"
        )
    if person.dropped_out is not None:
        raise NotNow(f"{code} counts as dropped out already ({person.dropped_out})")
    ledger.append(DroppedOut(code=code, reason=reason))


def _remove(folder: Path) -> int:
    """Remove a folder; return how many files it held."""
    if not folder.exists():
        return 0
    count = sum(path.is_file() and path.name != NAME for path in folder.rglob("*"))
    shutil.rmtree(folder)
    return count
