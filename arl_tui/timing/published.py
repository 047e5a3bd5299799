"""What other programs achieve, measured with hardware at screen and key: figures to read ours beside."""

from typing import NamedTuple

SOURCE = (
    "Bridges et al. 2020, PeerJ 8:e9414 (https://peerj.com/articles/9414/), Tables 2 and 3, with a Black Box "
    "Toolkit"
)


class Published(NamedTuple):
    """Reaction times of one program; milliseconds. A range where a table gives several browsers or
    systems.
    """

    program: str
    system: str
    lag: str
    sd: str


FIGURES = (
    Published("Psychtoolbox", "Ubuntu", "12.3", "0.31"),
    Published("PsychoPy", "Ubuntu", "8.4", "0.31"),
    Published("PsychoPy", "Windows 10", "12.1", "0.35"),
    Published("PsychoPy", "macOS", "22.0", "0.40"),
    Published("E-Prime", "Windows 10", "9.3", "0.53"),
    Published("OpenSesame", "Ubuntu", "9.7", "0.45"),
    Published("Expyriment", "Windows 10", "10.8", "2.90"),
    Published("Expyriment", "macOS", "33.8", "4.84"),
    Published("PsychoPy (PsychoJS)", "browsers", "33.5-67.0", "0.20-3.22"),
    Published("jsPsych", "browsers", "15.2-53.7", "0.66-8.37"),
    Published("lab.js", "browsers", "8.2-31.8", "0.97-8.44"),
    Published("Gorilla", "browsers", "23.4-40.9", "0.43-5.30"),
)


def published_lines() -> list[str]:
    """Return the table."""
    rows = [f"{f.program:<22}{f.system:<12}{f.lag:>11}{f.sd:>12}" for f in FIGURES]
    return [f"{'program':<22}{'system':<12}{'RT lag':>11}{'RT sd':>12}", *rows, f"Source: {SOURCE}."]
