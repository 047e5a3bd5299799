import subprocess
import sys
from html.parser import HTMLParser

import msgspec
import numpy as np
import pytest

from core.feedback.credit import GammaDelay
from core.numerics.streams import stream
from studies.reaction_time import report
from studies.reaction_time.exclusion import ExclusionPolicy, Row, select
from studies.reaction_time.figures import fit_figure, paper_figure_4, svg_text
from studies.reaction_time.fit import FitSettings, fit_group
from studies.reaction_time.report import (
    html_report,
    read_result,
    text_table,
    write_report,
)

pytestmark = pytest.mark.jit  # fits and intervals of a group: minutes in plain Python
QUICK = FitSettings(families=("gamma", "shifted gamma", "ex-Gaussian"), n_resamples=0)


def study(names=("P01", "<b>&", "P03", "P04", "P05")):
    """Five people with 40 trials; the last trial of each is timed out; a sixth has 3 trials."""
    rows = []
    for i, name in enumerate([*names, "few"]):
        times = 0.2 + stream(4, "report", i).gamma(4.0, 0.07, 40 if name != "few" else 3)
        rows += [Row(participant=name, source=f"a:{j}", rt_s=float(t)) for j, t in enumerate(times)]
        rows.append(Row(participant=name, source="a:99", rt_s=None, status="time-out", waited_s=1.5))
    samples, selection = select(rows, ExclusionPolicy())
    return rows, samples, selection, fit_group(samples, QUICK)


class Page(HTMLParser):
    """Collects what a page loads, its text, and whether its tags nest."""

    VOID = frozenset({"meta", "br", "use", "link", "path"})

    def __init__(self):
        super().__init__()
        self.loaded, self.text, self.open, self.rows = [], [], [], 0

    def handle_starttag(self, tag, attrs):
        self.rows += tag == "tr"
        self.loaded += [
            v for k, v in attrs if k in ("src", "href", "xlink:href") and v and not v.startswith("#")
        ]
        if tag == "meta":
            return
        self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.loaded += [
            v for k, v in attrs if k in ("src", "href", "xlink:href") and v and not v.startswith("#")
        ]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    rows, samples, selection, group = study()
    folder = tmp_path_factory.mktemp("report") / "result"
    arguments = {"task": "simple", "files": ["a.csv"], "rows": rows, "samples": samples}
    result = write_report(folder, selection=selection, group=group, **arguments)
    return folder, result, samples, rows


def test_the_result_is_read_back_as_it_was_found(written):
    folder, result, _, rows = written
    again = read_result(folder / "result.json")
    assert again == result
    assert len(again.selection.verdicts) == len(rows)
    assert again.selection.unusable["few"].startswith("3 usable responses")
    assert isinstance(again.group.participants["P01"].gamma.gamma_delay(), GammaDelay)
    assert set(again.group.pooled) == set(again.group.participants)


def test_every_participant_has_figures_and_every_row_its_verdict(written):
    folder, result, _, rows = written
    assert len(list((folder / "figures").glob("fit_*.png"))) == len(result.group.participants)
    assert len(list((folder / "figures").glob("fit_*.svg"))) == len(result.group.participants)
    assert (folder / "figures" / "fig4_delay.png").read_bytes().startswith(b"\x89PNG")
    assert (folder / "rows.tsv").read_text().count("\n") == len(rows) + 1


def test_the_page_stands_alone_escapes_names_and_warns_that_a_reaction_is_no_evaluation(written):
    folder, _, samples, _ = written
    text = (folder / "report.html").read_text()
    page = Page()
    page.feed(text)
    assert page.open == []
    assert page.loaded == []
    assert "<script" not in text
    assert "<b>&amp;" not in text
    assert any("is not an evaluation" in part for part in page.text)
    assert text.count("<svg") == len(samples) + 1
    assert any("few: not fitted" in part for part in page.text)


def test_a_feedback_lag_report_has_no_such_warning(written):
    _, result, samples, _ = written
    page = html_report(msgspec.structs.replace(result, task="feedback lag"), samples)
    assert "is not an evaluation" not in page


def test_a_report_is_never_overwritten(written):
    folder, result, samples, rows = written
    with pytest.raises(FileExistsError):
        write_report(
            folder,
            task="x",
            files=[],
            rows=rows,
            samples=samples,
            selection=result.selection,
            group=result.group,
        )


def test_a_page_of_many_people_shows_some_figures_and_tells_of_the_others(written, monkeypatch):
    _, result, samples, _ = written
    monkeypatch.setattr(report, "MOST_FIGURES", 2)
    page = html_report(result, samples)
    assert page.count("<svg") == 2 + 1
    assert "3 more participants" in page


def test_the_text_table_has_a_line_per_density_and_per_failure(written):
    _, result, _, _ = written
    lines = text_table(result.group).splitlines()
    assert len(lines) == 1 + 2 * len(result.group.participants)
    assert "interval" in lines[0]


def test_equal_figures_are_equal_files_and_have_their_curves(written):
    _, result, samples, _ = written
    one = result.group.participants["P01"]
    first = svg_text(fit_figure("P01", samples["P01"], one.fits))
    assert first == svg_text(fit_figure("P01", samples["P01"], one.fits))
    left, right = fit_figure("P01", samples["P01"], one.fits).axes
    labels = left.get_legend_handles_labels()[1]
    assert {"gamma", "shifted gamma"} <= set(labels)
    assert len(right.get_lines()) == len(
        labels
    )  # the diagonal, and points for each density but not for the bars


def test_figure_4_shows_the_papers_density():
    axes = paper_figure_4({"P01": GammaDelay(shape=25.0, scale_s=0.02)}).axes[0]
    time_s, density = axes.get_lines()[0].get_data()
    # gamma(2.5, 0.3): peak 1.03 per second at 0.45 s.
    assert float(time_s[np.argmax(density)]) == pytest.approx(0.45, abs=0.003)
    assert float(np.max(density)) == pytest.approx(1.03, abs=0.01)
    assert len(axes.get_lines()) == 2


def test_something_else_than_a_result_is_refused(tmp_path):
    path = tmp_path / "result.json"
    path.write_text("{}")
    with pytest.raises(ValueError, match="not a result"):
        read_result(path)


def test_reading_and_reporting_do_not_load_matplotlib_until_a_figure_is_drawn():
    code = "import sys; import studies.reaction_time.report; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
