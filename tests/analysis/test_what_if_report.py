"""What the analysis makes of the tables of `study whatif`."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from analysis.commands.main import app as analysis_app
from analysis.commands.report import write_report
from analysis.recordings import load_recordings
from analysis.sections import what_if
from analysis.statistics.result import EffectResult
from analysis.what_if import WhatIf, load_what_if, pooled
from choosing_study import choosing_study
from report_in_browser import inspect
from study.commands.main import app as study_app
from study.errors import StudyError
from study.whatif_files import Columns, read_head, read_table, write_what_if
from study.whatif_tables import COLUMNS


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six participants whose choices follow the very scorers in their recordings."""
    folder = tmp_path_factory.mktemp("choosing")
    choosing_study(folder, 6, trials=4, timesteps=40)
    return folder


@pytest.fixture(scope="module")
def tables(recordings: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the command writes about them."""
    folder = tmp_path_factory.mktemp("whatif") / "tables"
    scorers = ["--scorer", "own", "--scorer", "lowest_health", "--scorer", "stuck_longest"]
    options = ["--regret-choices", "4", "--draws", "1", "--horizon", "10"]
    given = [str(recordings), "-o", str(folder), *scorers, *options]
    done = CliRunner().invoke(study_app, ["whatif", *given])
    assert done.exit_code == 0, done.output
    assert "choices of 6 participants" in done.output
    return folder


@pytest.fixture(scope="module")
def asked(tables: Path, recordings: Path) -> WhatIf:
    """The same, read back."""
    return load_what_if(tables, load_recordings([recordings]))


def test_own_scorers_beat_chance_and_controls(asked: WhatIf) -> None:
    """With intervals over participants, on choices after the fits alone."""
    own, *others = what_if.scorer_rows(asked)
    assert own.scorer == "own"
    assert own.choices == 6 * 4 * 40
    assert own.agreement.interval is not None
    assert own.agreement.interval.low > own.chance.value
    assert own.gain.interval is not None
    assert own.gain.interval.low > 0.0
    assert own.rank.value < 6.5
    assert {row.scorer for row in others} == {"lowest_health", "stuck_longest"}
    for row in others:
        test = row.against_own
        assert isinstance(test, EffectResult)
        assert test.interval is not None
        assert test.interval.low > 0.0
        assert row.holm_p is not None
        assert row.holm_p < 0.05
        assert row.gain.n == 0


def test_own_scorers_beat_others_in_the_matrix(asked: WhatIf) -> None:
    """The diagonal is what was simulated; every column has its largest value there."""
    found = what_if.matrix(asked)
    assert found is not None
    assert found.kind == "later"
    assert found.owners == found.people == tuple(f"P{n:02d}" for n in range(1, 7))
    assert found.gain.argmax(axis=0).tolist() == list(range(6))
    for test in (found.own_gain, found.own_agreement):
        assert isinstance(test, EffectResult)
        assert test.interval is not None
        assert test.interval.low > 0.0
    assert "more often than others" in what_if.matrix_finding(found)


def test_without_later_choices_the_own_scorers_are_cross_validated(
    recordings: Path, tmp_path: Path
) -> None:
    """Of phase two alone the diagonal is held out if asked for; else it is said to be too good."""
    files = sorted(recordings.glob("*.mcap"))[:2]
    study = load_recordings(files)
    for options, kind in (([], "fitted"), (["--cross-validate", "3"], "cross_validated")):
        folder = tmp_path / kind
        given = [*map(str, files), "-o", str(folder), "--regret-choices", "0", *options]
        assert CliRunner().invoke(study_app, ["whatif", *given]).exit_code == 0
        what = load_what_if(folder, study)
        early = what.tables["matrix"][what.tables["matrix"]["fitted"].astype(bool)]
        frames = {**what.tables, "matrix": early}
        found = what_if.matrix(WhatIf(what.settings, what.versions, frames, what.notes))
        assert found is not None
        assert found.kind == kind
        assert not np.isnan(found.gain).any()
        own = early[early["scorer_of"] == early["participant"]]
        assert bool(own["seen"].any()) == (kind == "fitted")
        assert (own["choices"] == 3 * 40).all()


def test_regret_is_compared_with_the_operators(asked: WhatIf) -> None:
    """The operator comes first; nobody has less than none, and chance has no share of best."""
    rows = what_if.regret_rows(asked)
    assert [row.who for row in rows][:2] == ["operator", "chance"]
    assert all(row.regret.value >= 0.0 for row in rows)
    assert all(row.choices == 24 for row in rows)
    assert rows[0].against_operator is None
    assert isinstance(rows[1].against_operator, EffectResult)


def test_the_report_shows_it(tables: Path, recordings: Path, tmp_path: Path) -> None:
    """A section of its own, the same bytes again; none without the option."""
    page = write_report([recordings], tmp_path / "with", whatif=tables)
    text = page.read_text(encoding="utf-8")
    assert '<section id="what-if"' in text
    assert "names their choices more often than others’ do" in text
    plain = write_report([recordings], tmp_path / "without").read_text(encoding="utf-8")
    assert 'id="what-if"' not in plain
    again = write_report([recordings], tmp_path / "again", whatif=tables)
    assert again.read_bytes() == page.read_bytes()


@pytest.mark.acceptance
def test_browsers_show_it_without_a_violation(
    tables: Path, recordings: Path, tmp_path: Path
) -> None:
    """In Chromium, light, dark and narrow: axe finds nothing, and nothing sticks out."""
    found = inspect(write_report([recordings], tmp_path, whatif=tables))
    assert found["violations"] == {"light": [], "dark": [], "narrow": []}
    assert all(width <= 0 for width in found["wide"].values()), found["wide"]
    assert found["requests"] == []
    assert found["errors"] == []


def test_tables_of_other_recordings_are_refused(
    tables: Path, recordings: Path, study_folder: Path
) -> None:
    """Hashes tell; recordings that are partly the same are named."""
    with pytest.raises(StudyError, match="of none of these recordings"):
        load_what_if(tables, load_recordings([study_folder]))
    files = sorted(recordings.glob("*.mcap"))[:4]
    fewer = load_what_if(tables, load_recordings(files))
    assert any("2 recordings" in note.replace("\u00a0", " ") for note in fewer.notes)
    assert set(fewer.tables["trials"]["participant"]) == {f"P{n:02d}" for n in range(1, 5)}
    assert set(fewer.tables["matrix"]["scorer_of"]) == {f"P{n:02d}" for n in range(1, 5)}


def test_changed_tables_are_refused(tables: Path, tmp_path: Path) -> None:
    """Whatever is changed after the fact does not enter a report."""
    head = read_head(tables)
    for name in COLUMNS:
        assert list(read_table(tables, head, name)) == list(COLUMNS[name])
        assert (tables / f"{name}.csv").stat().st_mode & 0o077 == 0
    trials = (tables / "trials.csv").read_text(encoding="utf-8")
    copy = tmp_path / "copy"
    copy.mkdir()
    for path in tables.iterdir():
        (copy / path.name).write_bytes(path.read_bytes())
    (copy / "trials.csv").write_text(trials.replace("own", "mine"), encoding="utf-8")
    with pytest.raises(StudyError, match="vouches"):
        read_table(copy, read_head(copy), "trials")
    for content in ("[]", "{", json.dumps({"kind": "what_if", "format": 2}), "{}"):
        (copy / "whatif.json").write_text(content, encoding="utf-8")
        with pytest.raises(StudyError):
            read_head(copy)
    result = CliRunner().invoke(
        analysis_app, ["report", str(tables), "-o", str(tmp_path / "r"), "--whatif", str(copy)]
    )
    assert result.exit_code != 0


def test_names_that_spreadsheets_would_run_are_only_names(tmp_path: Path) -> None:
    """They are written with an apostrophe, and read back as they were."""
    names = ["=1+1", "-2", "plain", "'quoted", '@x, "y"', "＝1", "", "a\nb"]
    empty: dict[str, Columns] = {
        name: {column: [] for column in columns} for name, columns in COLUMNS.items()
    }
    empty["recordings"] = {
        column: [3] * len(names) if kind == "whole" else list(names)
        for column, (kind, _, _) in COLUMNS["recordings"].items()
    }
    write_what_if(tmp_path / "t", empty, {}, {})
    text = (tmp_path / "t" / "recordings.csv").read_text(encoding="utf-8")
    assert "\n'=1+1," in text
    assert (
        read_table(tmp_path / "t", read_head(tmp_path / "t"), "recordings") == empty["recordings"]
    )


def test_a_folder_with_other_files_is_left_alone(tmp_path: Path) -> None:
    """Nothing of the user's is overwritten."""
    (tmp_path / "thesis.txt").write_text("mine", encoding="utf-8")
    empty: dict[str, Columns] = {
        name: {column: [] for column in columns} for name, columns in COLUMNS.items()
    }
    with pytest.raises(StudyError, match=r"holds other files \(thesis.txt\)"):
        write_what_if(tmp_path, empty, {}, {})
    with pytest.raises(ValueError, match="declared"):
        write_what_if(tmp_path / "new", {**empty, "trials": {"x": []}}, {}, {})


@given(
    st.lists(
        st.tuples(st.sampled_from("ab"), st.integers(1, 50), st.floats(-5, 5, allow_nan=False)),
        min_size=1,
        max_size=30,
    ),
    st.randoms(use_true_random=False),
)
@settings(max_examples=60)
def test_pooling_does_not_hang_on_the_order_of_rows(
    rows: list[tuple[str, int, float]], random: object
) -> None:
    """To the last bit; and a mean lies among the values."""
    names = ["who", "choices", "value"]
    first = pooled(pd.DataFrame(rows, columns=names), ["who"], ["value"])
    shuffled = list(rows)
    random.shuffle(shuffled)  # type: ignore[attr-defined]
    second = pooled(pd.DataFrame(shuffled, columns=names), ["who"], ["value"])
    pd.testing.assert_frame_equal(first, second, check_exact=True)
    for who, mean in zip(first["who"], first["value"], strict=True):
        mine = [value for name, _, value in rows if name == who]
        assert min(mine) - 1e-9 <= mean <= max(mine) + 1e-9


def test_relabelled_participants_change_nothing_but_names(asked: WhatIf) -> None:
    """The same tables under other ids give the same numbers."""
    turned = {name: frame.copy() for name, frame in asked.tables.items()}
    names = {f"P{n:02d}": f"Q{7 - n}" for n in range(1, 7)}
    for frame in turned.values():
        for column in ("participant", "scorer_of"):
            if column in frame:
                frame[column] = frame[column].map(lambda who: names.get(who, who))
    other = WhatIf(asked.settings, asked.versions, turned, asked.notes)
    before, after = what_if.scorer_rows(asked), what_if.scorer_rows(other)
    for mine, theirs in zip(before, after, strict=True):
        assert mine.agreement == theirs.agreement
        assert mine.gain.n == theirs.gain.n
    one, two = what_if.matrix(asked), what_if.matrix(other)
    assert one is not None
    assert two is not None
    assert np.array_equal(one.gain, two.gain[::-1, ::-1])
