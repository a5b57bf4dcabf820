"""Who may take part, and which order and seed a session gets."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols import variant
from study.commands.composing import session_opened, start_recorder
from study.commands.enrolling import assign, foreseen, tell_place
from study.commands.run import parse_size
from study.commands.simulating import default_seed, simulated_assignments
from study.enrolment.importing import bring_in_step
from study.enrolment.pseudonyms import check_participant
from study.enrolment.register import Register
from study.errors import StudyError
from study.loading import LoadedProtocol, load_protocol


def record_start(loaded: LoadedProtocol, folder: Path, participant: str) -> tuple[str, ...]:
    """Record the first input of a session; return its order."""
    assignment = assign(loaded, participant, folder)
    opened = session_opened(loaded, assignment)
    recorder = start_recorder(folder, loaded, opened)
    recorder.write(opened, 1)
    recorder.close()
    return assignment.order


@pytest.mark.parametrize("good", ["P01", "p-1_b", "0", "X" * 32, "console", "com10"])
def test_pseudonyms_are_taken(good: str) -> None:
    """Up to 32 letters, digits, - and _."""
    assert check_participant(good) == good


@pytest.mark.parametrize(
    "bad",
    ["", " ", "Anna Smith", "../P01", "a/b", "a\\b", ".", "-p", "_p", "P01\n", "X" * 33],
)
def test_other_ids_are_refused(bad: str) -> None:
    """Paths, blanks and what is too long could not be part of a file's name."""
    with pytest.raises(StudyError, match="cannot be used"):
        check_participant(bad)


@pytest.mark.parametrize("bad", ["Zoë", "a.b", "con", "NUL", "Com1", "lpt9", "a:b", "[bold]"])
def test_device_names_and_marks_are_refused(bad: str) -> None:
    """Neither can names that mean something to a system or a terminal."""
    with pytest.raises(StudyError, match="cannot be used"):
        check_participant(bad)


def test_a_name_is_refused(tmp_path: Path) -> None:
    """Before a slot is taken; who took part under such an id earlier still can."""
    loaded = load_protocol("smoke")
    with pytest.raises(StudyError, match="looks like a name"):
        assign(loaded, "AnnaSchmidt", tmp_path)
    with pytest.raises(StudyError, match="looks like a name"):
        foreseen(loaded, "AnnaSchmidt", tmp_path)
    with Register(tmp_path) as register:
        assert register.participants() == []
        orders = [("manual", "assisted")]
        register.reserve(loaded.protocol.study.name, orders, pseudonym="AnnaSchmidt")
    assert assign(loaded, "AnnaSchmidt", tmp_path).planned_index == 0


def test_the_slots_own_order_is_not_called_set_by_hand(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A second session has it whatever the plan has next; one that was set is told."""
    loaded = load_protocol("smoke")
    assign(loaded, "P01", tmp_path)
    with Register(tmp_path) as register:
        register.start("smoke", "P01")
        register.finish("smoke", "P01", "complete")
    by_hand = assign(loaded, "P02", tmp_path, order="manual,assisted")
    tell_place(loaded, by_hand, tmp_path)
    assert "notes that it was set by hand" in " ".join(capsys.readouterr().err.split())
    second = assign(loaded, "P01", tmp_path, again=True)
    assert second.order == by_hand.order
    tell_place(loaded, second, tmp_path)
    assert capsys.readouterr().err == ""


def test_an_order_against_the_plan_is_remarked(tmp_path: Path) -> None:
    """It becomes a note of the experimenter's; an order that the plan has anyway does not."""
    loaded = load_protocol("smoke")
    assert assign(loaded, "P01", tmp_path, order="manual,assisted").remark == ""
    assert assign(loaded, "P02", tmp_path, order="manual,assisted").remark == (
        "Order set by hand: manual then assisted; the plan had assisted then manual"
    )
    assert assign(loaded, "P03", tmp_path).remark == ""


@given(st.text(max_size=40))
def test_no_id_leaves_the_folder(given_id: str) -> None:
    """Whatever is taken is a plain file name."""
    try:
        taken = check_participant(given_id)
    except StudyError:
        return
    assert Path(f"study_{taken}_x.mcap").name == f"study_{taken}_x.mcap"
    assert taken.isascii()
    assert "\n" not in taken


@pytest.mark.parametrize("quoted", ['name = "smoke"', "name='smoke'"])
def test_orders_alternate_and_participants_come_once(tmp_path: Path, quoted: str) -> None:
    """However the file is written, its sessions are found: AB, BA, AB; nobody comes twice."""
    loaded = load_protocol(str(variant(tmp_path, ('name = "smoke"', quoted))))
    folder = tmp_path / "recordings"
    orders = [record_start(loaded, folder, name) for name in ("P01", "P02", "P03")]
    assert orders == [("manual", "assisted"), ("assisted", "manual"), ("manual", "assisted")]
    with pytest.raises(StudyError, match='"P02" already has a recording'):
        assign(loaded, "P02", folder)
    assert assign(loaded, "P02", folder, again=True).order == ("assisted", "manual")


def test_other_studies_and_broken_files_do_not_count(tmp_path: Path) -> None:
    """Orders are balanced within a study; what is no recording is passed over."""
    folder = tmp_path / "recordings"
    record_start(load_protocol("pilot"), folder, "P01")
    (folder / "torn.mcap").write_bytes(b"torn")
    loaded = load_protocol("smoke")
    with Register(folder) as register:
        bring_in_step(register)
        assert register.participants("smoke") == []
        (known,) = register.participants("pilot")
    assert (known.pseudonym, known.order) == ("P01", ("manual", "assisted"))
    assert assign(loaded, "P01", folder).order == ("manual", "assisted")


def test_seed_follows_from_participant_and_protocol(tmp_path: Path) -> None:
    """The same person in the same study has one seed; another has another; both can be set."""
    loaded = load_protocol("smoke")
    first, again = (assign(loaded, "P01", tmp_path).seed for _ in range(2))
    assert first == again
    assert assign(loaded, "P02", tmp_path).seed != first
    assert assign(load_protocol("pilot"), "P01", tmp_path).seed != first
    assert assign(loaded, "P01", tmp_path, seed=0).seed == 0


def test_order_can_be_overruled(tmp_path: Path) -> None:
    """An order given by hand is taken if it names each condition once."""
    loaded = load_protocol("smoke")
    assert assign(loaded, "P01", tmp_path, order=" assisted , manual").order == (
        "assisted",
        "manual",
    )
    for wrong in ("manual", "manual,manual", "manual,other", "manual,assisted,manual"):
        with pytest.raises(StudyError, match="Name each condition once"):
            assign(loaded, "P01", tmp_path, order=wrong)


@pytest.mark.parametrize("participants", [1, 2, 7, 12])
def test_simulated_orders_balance(participants: int) -> None:
    """Simulated participants take the orders in turn, each with ids and seeds of its own."""
    loaded = load_protocol("smoke")
    assignments = simulated_assignments(loaded, participants, default_seed(loaded))
    first = sum(a.order == ("manual", "assisted") for a in assignments)
    assert 0 <= first - (participants - first) <= 1
    for field in ("participant", "seed"):
        assert len({getattr(a, field) for a in assignments}) == participants
    assert {a.operator_kind for a in assignments} == {"simulated"}
    seeds = {json.loads(a.operator_json)["study_seed"] for a in assignments}
    assert seeds == {default_seed(loaded)}


def test_window_size() -> None:
    """Width x height in pixels; anything else is refused."""
    assert parse_size("") is None
    assert parse_size("1280X960") == (1280, 960)
    for wrong in ("1280", "1280x", "x960", "12.5x3", "-1x3", "axb"):
        with pytest.raises(StudyError, match="window size"):
            parse_size(wrong)
