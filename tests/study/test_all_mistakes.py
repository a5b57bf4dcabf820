"""Mistakes in a file that have nothing to do with one another are all told, each once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from protocols import ROOT
from robots_list import KEY, LIST, OTHER
from study.errors import ProtocolError
from study.experiment.protocol import parse_experiment
from study.loading import load_protocol
from study.questionnaire import parse_questionnaire
from study.robots.robots_file import read_robots_file

Mistakes = dict[str, tuple[str, str, str]]
"""By what is wrong: a text that the file has once, what is there instead, words of the message."""
Reader = Callable[[Path], object]

THIRD = '[[conditions]]\nname = "third"\nlabel = "3"\nview = "tiles"\nallocation = "manual"\n'
THIRD += "robots = 12\n\n[phase_four]"
ASSUMED = '"timing.timesteps_per_second" ='
OPERATED = 'allocation = "manual"\nview = "operated_only"'

PROTOCOL: Mistakes = {
    "empty text": ('"Smoke test: every stage, shortened"', '""', "study.title:"),
    "language": ("ants = 2", 'ants = 2\nlanguage = "xx"', "study.language:"),
    "rate": ("_second = 10.0", "_second = 0", "timing.timesteps_per_second: 0 given"),
    "task's end": ('on_end = "reset"', 'on_end = "rest"', "task.on_end:"),
    "layout": ('"three_rooms"', '"three_room"', 'task.parameters.layout: unknown layout "three'),
    "task's number": ("horizon = 20", "horizon = 0", "task.parameters.horizon: 0 given"),
    "task's range": ("[60.0, 100.0]", "[100.0, 60.0]", "task.parameters: start_health is"),
    "task's rewards": ("progress = 1.0", 'progress = "1"', "task.parameters.rewards.progress:"),
    "policy's parameter": ('"sine_cosine"', '"sine"', "policy.parameters.encoding:"),
    "scorer": ('luce]\nname = "luce"', 'luce]\nname = "luse"', "scorers.luce.name:"),
    "scorer's gate": (
        'name = "classifier"',
        'name = "classifier"\ngate.fallback = "lucy"',
        'scorers.classifier.gate.fallback: "lucy" given',
    ),
    "scorer's parameter": (
        "weight_decay = 1.0\n\n[practice]",
        "weight_decay = -1.0\n\n[practice]",
        "scorers.classifier.parameters.weight_decay: -1.0",
    ),
    "misspelt key": ("episodes = 2", "episode = 2", "phase_one.episode: unknown key"),
    "choice": ('refit = "each_episode"', 'refit = "never"', "phase_one.refit:"),
    "true or false": ("paired_starts = true", "paired_starts = 1", "phase_three.paired_starts: 1"),
    "order": ("[phase_four]", THIRD, 'phase_three.order: "ab_ba" needs two conditions, 3 given'),
    "label": ('label = "Manual"', "label = 3", "conditions.manual.label: 3 given"),
    "view": ('allocation = "manual"\nview = "tiles"', OPERATED, "a manual condition shows all"),
    "condition's scorer": ('scorer = "luce"', 'scorer = "luze"', 'scorer: "luze" is not under'),
    "dwell": ("dwell = 15", "dwell = -1", "conditions.assisted.dwell: -1 given"),
    "asked when": ('"after_reveal"]', '"afterwards"]', '"afterwards" given'),
    "questionnaire": ('"ease_and_success"', '"ease"', "questionnaires.1.name:"),
    "key twice": ('back = "backspace"', 'back = "return"', "keys: bound twice: return"),
    "no key": ('pause = "escape"', 'pause = "esc"', 'keys.pause: "esc" given'),
    "key that is a number": ('up = "up"', "up = 7", "keys.up: 7 given"),
    "robot key": ('"8", "9"', '"8", "nine"', 'keys.robots.9: "nine" given'),
    "few robot keys": (', "0", "-", "="]', "]", "keys.robots: 9 keys given for a fleet of 12"),
    "exclusion": ("at_least = 2", 'at_least = "2"', "exclusions.incomplete.at_least:"),
    "analysis": ('"rm_anova", ', '"anova", ', '"anova" given'),
    "assumption of nothing": (ASSUMED, '"timing.rate" =', 'assumptions: "timing.rate" names no'),
    "assumption without words": (
        "[assumptions]",
        '[assumptions]\n"study.name" = 3',
        "assumptions.study.name: 3 given",
    ),
    "unknown table": ("[analysis]", "[nonsense]\n\n[analysis]", "nonsense: unknown key"),
}

ASKED = """
[[items]]
id = "q3"
text = "Your age"
kind = "number"
least = 18
most = 99

[[items]]
id = "q4"
text = "Your hand"
kind = "choice"
options = ["left", "right"]

[[scales]]
name = "ease"
method = "mean"
items = ["q1"]
reverse = ["q1"]
"""
HIGH = ("high = 7", "high = 1", "high: 1 given; it must exceed low, 1")
QUESTIONNAIRE: Mistakes = {
    "name of another file": ('"ease_and_success"', '"ease"', "must be the file's"),
    "version": ("version = 1", 'version = "1"', 'version: "1" given'),
    "empty text": ('"About the block you just finished"', '""', "title:"),
    "misspelt key": ("[labels]", "items_per_pages = 2\n\n[labels]", "items_per_pages: unknown"),
    "range": HIGH,
    "label of no number": ("4 = ", "four = ", 'labels: "four" is no whole number'),
    "label without words": ('1 = "Strongly Disagree"', "1 = 3", "labels.1: 3 given"),
    "item's type": ('"It was easy to guide the robots to their goals"', "3", "items.1.text: 3"),
    "item's label": (
        'text = "I was successful at guiding the robots"',
        'text = "I was"\nlabels = { x = "No" }',
        '"x" is no whole number',
    ),
    "id twice": ('id = "q2"', 'id = "q1"', "items: an id is given twice"),
    "item without text": ('text = "Your age"\n', "", "items.3.text: missing"),
    "least over most": ("least = 18", "least = 100", "items.3.least: 100 given"),
    "options": ('["left", "right"]', '["left"]', "items.4.options: a"),
    "optional": ('"Your hand"', '"Your hand"\noptional = true', "items.4.optional: only"),
    "method": ('method = "mean"', 'method = "mode"', "scales.ease.method:"),
    "unknown item": ('items = ["q1"]', 'items = ["q8"]', 'scales: "q8" is no item'),
    "unknown item turned": ('reverse = ["q1"]', 'reverse = ["q9"]', 'scales: "q9" is no item'),
}

NONE = '[scorers.none]\nname = "random"\nlabel = "None"\n\n[scorers.health]'
EXPERIMENT: Mistakes = {
    "number": ("trials = 250", "trials = 0", "experiment.trials: 0 given"),
    "seeds": ("= 20261126", "= 20200531", "seeds: development and held_out are both"),
    "layout": ('"three_rooms"', '"three_room"', "task.parameters.layout:"),
    "task's number": ("horizon = 200", "horizon = 0", "task.parameters.horizon:"),
    "policy": ('"nearest_neighbor"', '"nearest"', "policy.name:"),
    "name taken": ("[scorers.health]", NONE, "scorers.none: the name is taken"),
    "scorer without label": ('label = "Random"\n', "", "scorers.random.label: missing"),
    "corrected": ('scorer = "luce"', 'scorer = "lucy"', 'correction.scorer: "lucy"'),
    "asked": ("asked = 4", "asked = 40", "correction: asked is 40"),
    "turned": ('["luce", "classifier"]', '["lutz", "classifier"]', 'sensitivity.scorers: "lutz"'),
    "driving": ('["ground_truth", ', '["truth", ', 'fleet_sizes.scorers: "truth"'),
    "assumption": ('"correction" =', '"corrections" =', 'assumptions: "corrections"'),
    "assumption without words": (
        '"fleet_sizes" = "Not in the paper."',
        '"fleet_sizes" = 1',
        "1 given",
    ),
}


ROBOTS: Mistakes = {
    "key file": ('"keys/operator.toml"', "3", "operator_key: 3 given"),
    "address": ("tcp://192.168.1.21", "192.168.1.21", 'robot1.address: "192.168.1.21'),
    "name twice": ('"robot2"', '"robot1"', "robots: name robot1 is that of two robots"),
    "key twice": (OTHER, KEY, f"robots: public_key {KEY} is that of two robots"),
    "server": ('"192.168.1.10"', "10", "poses.natnet.server: 10 given"),
    "bodies": ("[11, 12]", "[11]", "poses.rigid_bodies must have one id for each robot"),
}


def _robots(path: Path) -> None:
    read_robots_file(path)


def _protocol(path: Path) -> None:
    load_protocol(str(path))


def _questionnaire(path: Path) -> None:
    parse_questionnaire(path.read_text(), str(path), name="ease_and_success")


def _experiment(path: Path) -> None:
    parse_experiment(path.read_text(), str(path))


def _shipped(name: str) -> str:
    return (ROOT / "protocols" / f"{name}.toml").read_text()


FILES: dict[str, tuple[str, Mistakes, Reader]] = {
    "protocol": (
        _shipped("smoke").replace("\ntrials = 2\n", "\ntrials = 3\n"),
        PROTOCOL,
        _protocol,
    ),
    "questionnaire": (
        _shipped("questionnaires/ease_and_success") + ASKED,
        QUESTIONNAIRE,
        _questionnaire,
    ),
    "robots": (LIST, ROBOTS, _robots),
    "experiment": (_shipped("simulation"), EXPERIMENT, _experiment),
}
SINGLE = [(kind, name) for kind, (_, mistakes, _) in FILES.items() for name in mistakes]


def _told(kind: str, names: Sequence[str], folder: Path) -> list[str]:
    """Return what a reader says of a file with these mistakes; each has to be told, and once."""
    text, mistakes, read = FILES[kind]
    for name in names:
        old, new, _ = mistakes[name]
        assert text.count(old) == 1, name
        text = text.replace(old, new)
    path = folder / "wrong.toml"
    path.write_text(text)
    with pytest.raises(ProtocolError) as caught:
        read(path)
    problems = caught.value.problems
    for name in names:
        said = [problem for problem in problems if mistakes[name][2] in problem]
        assert len(said) == 1, (names, name, problems)
    assert len(problems) == len(names), (names, problems)
    return problems


@pytest.mark.parametrize("kind", FILES)
def test_the_file_without_mistakes_is_right(kind: str, tmp_path: Path) -> None:
    """What is told of the others comes from their mistakes."""
    text, _, read = FILES[kind]
    path = tmp_path / "right.toml"
    path.write_text(text)
    read(path)


@pytest.mark.parametrize(("kind", "name"), SINGLE)
def test_any_two_mistakes_are_told_at_once(kind: str, name: str, tmp_path: Path) -> None:
    """One by itself gives one message, and hides none of the others, whichever they are."""
    _told(kind, [name], tmp_path)
    names = list(FILES[kind][1])
    for other in names[names.index(name) + 1 :]:
        _told(kind, [name, other], tmp_path)


@pytest.mark.parametrize(
    ("kind", "old", "new", "words"),
    [
        # Which labels there can be depends on the range, and this on both its ends.
        ("questionnaire", "high = 7", "high = 1", ["high: 1 given"]),
        ("questionnaire", "high = 7", 'high = "7"', ['high: "7" given']),
        ("questionnaire", "high = 7", "higk = 5", ['did you mean "high"?']),
        # What is misspelt or no name may be what is asked for.
        ("questionnaire", 'id = "q1"', 'id = "Q1"', ["items.1.id:"]),
        ("questionnaire", '"q1"\ntext', '"q1"\nkind = "scales"\ntext', ["items.1.kind:"]),
        ("protocol", "[scorers.luce", "[scorers.Luce", ["scorers.Luce:"]),
        ("protocol", "dwell = 15", "dwel = 15", ['did you mean "dwell"?']),
        ("protocol", 'scorer = "luce"', 'scorers = "luce"', ['did you mean "scorer"?']),
        ("protocol", "[scorers.", "[scorer.", ['did you mean "scorers"?']),
        # A step's longest way depends on the walls of the layout.
        ("protocol", '"three_rooms"', '"three"', ["task.parameters.layout:"]),
        ("experiment", "asked = 4", 'asked = "4"', ["correction.asked:"]),
    ],
)  # fmt: skip
def test_no_mistake_is_told_twice(
    kind: str, old: str, new: str, words: list[str], tmp_path: Path
) -> None:
    """What follows from one mistake is none of its own."""
    text, _, read = FILES[kind]
    assert old in text
    path = tmp_path / "wrong.toml"
    path.write_text(text.replace(old, new))
    with pytest.raises(ProtocolError) as caught:
        read(path)
    problems = caught.value.problems
    assert len(problems) == len(words), problems
    for word, problem in zip(words, problems, strict=True):
        assert word in problem


def test_a_list_that_is_too_long_hides_none_of_its_entries(tmp_path: Path) -> None:
    """Each entry that is wrong is told, and what stands beside the list too."""
    text, _, read = FILES["questionnaire"]
    path = tmp_path / "wrong.toml"
    items = "".join(f'[[items]]\nid = "more{n}"\ntext = "More"\n' for n in range(40))
    text = text.replace('["left", "right"]', '["a", "", "c", "d", "e", "f", "g", "h"]')
    path.write_text(f"{text}{items}".replace('"Your age"', "3").replace("high = 7", "high = 1"))
    with pytest.raises(ProtocolError) as caught:
        read(path)
    said = sorted(problem.split(": ")[0] for problem in caught.value.problems)
    assert said == ["high", "items", "items.3.text", "items.4.options", "items.4.options.2"]


@pytest.mark.parametrize("kind", FILES)
def test_all_mistakes_are_told_at_once(kind: str, tmp_path: Path) -> None:
    """However many there are."""
    _told(kind, list(FILES[kind][1]), tmp_path)
