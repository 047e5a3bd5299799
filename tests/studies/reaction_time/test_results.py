"""The pages of results, made of a small set: each number is from the data at hand."""

import gzip
import re
from pathlib import Path

import pytest

from core.numerics.streams import stream
from studies.reaction_time.held_out import HeldOutScore
from studies.reaction_time.read import Columns
from studies.reaction_time.results import DataSet, delay_of, families_page, fit_data_set, main, pooling_page


@pytest.fixture(scope="module")
def few(tmp_path_factory: pytest.TempPathFactory):
    """Six people whose times are shifted gammas, and one row that is to be left out."""
    folder = tmp_path_factory.mktemp("data")
    (folder / "reaction_time").mkdir()
    lines = ["participant_id\tresponse_time\tcorrectness"]
    for k in range(6):
        times = 0.2 + stream(5, "people", k).gamma(4.0, 0.08, size=30)
        lines += [f"sub-{k:02d}\t{time:.4f}\tcorrect" for time in times]
    lines.append("sub-00\t0.5\tincorrect")
    with gzip.open(folder / "reaction_time" / "made.tsv.gz", "wt", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")
    columns = Columns(rt="response_time", unit="s", keep={"correctness": ("correct",)})
    data_set = DataSet(name="made", source="Made here", licence="none", file="made.tsv.gz", columns=columns)
    return fit_data_set(data_set, folder)


@pytest.mark.jit
def test_the_page_of_families_ranks_them_as_the_fits_do(few) -> None:
    text = families_page([few])
    assert "Made here: 6 people, 180 trials (none)" in text
    best = few.fits_together[0]
    ranked = re.findall(r"^\| ([\w -]+?)(?: \(the paper's\))? \| \**-?[\d,]+\.\d\** \|$", text, re.MULTILINE)
    assert ranked == [fit.family for fit in few.fits_together]
    assert f"**{best.aic:,.1f}**" in text
    counted = re.findall(r"^\| [\w -]+ \| (\d+) \|$", text, re.MULTILINE)
    assert sum(map(int, counted)) == 6
    delay = delay_of(few)
    assert f"made shape {delay.shape:.2f}, scale {delay.scale_s:.3f} s, offset {delay.offset_s:.3f} s" in text


def test_the_page_of_pooling_tells_gains_in_standard_errors() -> None:
    given = {
        "n_fitted": 10,
        "n_people": 6,
        "log_density": 0.5,
        "impossible": 0.0,
        "pinball_ms": 40.0,
        "better_than_alone": 0.5,
        "pinball_gain_se_ms": 0.2,
    }
    scores = tuple(
        HeldOutScore(method=name, pinball_gain_ms=gain, **given)
        for name, gain in (("alone, gamma", 0.0), ("pooled, gamma", 0.5), ("pooled, shifted gamma", -0.1))
    )
    text = pooling_page({(10, "made, 6 people"): scores})
    assert "## made, 6 people: 10 trials each" in text
    assert "pooled, gamma: gain of +2.5 standard errors" in text
    assert "pooled, shifted gamma: gain of -0.5 standard errors" in text


def test_a_folder_without_the_data_is_named_and_nothing_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stopped:
        main([str(tmp_path / "nowhere"), str(tmp_path / "docs")])
    assert stopped.value.code == 2
    assert "nowhere" in capsys.readouterr().err
    assert not (tmp_path / "docs").exists()
