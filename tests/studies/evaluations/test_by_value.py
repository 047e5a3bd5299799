"""A density of the delay for each value, from evaluations; and whose presses a report counts."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from arl_tui.cli import main
from core.feedback.delays import GammaDelay
from core.numerics.streams import stream
from core.session.protocol_reading import load_protocol
from studies.evaluations.by_value import fit_per_value
from studies.evaluations.presses import Press

TRUE = {-2.0: GammaDelay(2.5, 0.34), 0.0: GammaDelay(3.0, 0.5), 2.0: GammaDelay(2.5, 0.34)}


def presses(n: int = 400) -> list[Press]:
    found = []
    for value, delay in TRUE.items():
        for time_s in stream(1, f"delays of {value:g}").gamma(delay.shape, delay.scale_s, n):
            found.append(
                Press(participant="A", file="f", time_s=0.0, value=value, delay_s=float(time_s), burst=0)
            )
    return found


@pytest.mark.statistical
def test_the_densities_of_the_values_are_found_again():
    """400 delays each: the median of a gamma density is known to 5 %, some of it cut off by the limits."""
    fitted = fit_per_value(presses())
    assert [each.value for each in fitted.values] == [-2.0, 0.0, 2.0]
    for each in fitted.values:
        median_s = np.median(
            stream(2, "median").gamma(TRUE[each.value].shape, TRUE[each.value].scale_s, 20_000)
        )
        assert float(each.delay.cdf(median_s)) == pytest.approx(0.5, abs=0.06)


def test_a_value_with_few_presses_goes_by_all_and_too_few_are_refused():
    some = [press for press in presses(30) if press.value != 0.0] + presses(5)[5:10]
    assert [each.value for each in fit_per_value(some).values] == [-2.0, 2.0]
    with pytest.raises(ValueError, match="at least 20 presses"):
        fit_per_value(presses(3))


def test_what_is_printed_is_a_protocols_credit_rule(tmp_path: Path):
    table = tmp_path / "evaluations.csv"
    rows = ["participant_id,time_s,value,delay_s"]
    rows += [f"A,{10 * k},{press.value:g},{press.delay_s:.4f}" for k, press in enumerate(presses(60), 1)]
    table.write_text("\n".join(rows) + "\n")
    run = CliRunner()
    imported = run.invoke(main, ["import", "evaluations", str(table), "--recordings", str(tmp_path / "r")])
    assert imported.exit_code == 0, imported.output
    (path,) = (tmp_path / "r").rglob("*.jsonl")
    printed = run.invoke(main, ["presses", "--delays-by-value", str(path)])
    assert printed.exit_code == 0, printed.output
    protocol_file = tmp_path / "p.toml"
    protocol_file.write_text(printed.output[printed.output.index("[agent.credit.delay]") :])
    fitted = load_protocol(protocol_file).agent.credit.delay
    assert [each.value for each in fitted.values] == [-2.0, 0.0, 2.0]
