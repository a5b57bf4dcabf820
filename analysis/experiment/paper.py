"""The paper's numbers beside ours, and in words where they agree.

From "Simulation Experiments": learned from choices among n = 4, Luce's model puts the user's
robot first among n = 12 in 79 % of cases, the classifier in 32 %. Its figure gives rewards
without numbers in the text, so that only their order can be compared.
"""

from __future__ import annotations

import dataclasses

from analysis.experiment.contrasts import Contrast, Mean, mean_of
from analysis.experiment.frames import GROUND_TRUTH, NONE, Experiment
from analysis.experiment.questions import IMPACT, PREDICTION, REWARD, policies_at, runs_at
from analysis.formatting import counted, listed, number

LUCE_TOP1, CLASSIFIER_TOP1 = 0.79, 0.32


@dataclasses.dataclass(frozen=True, slots=True)
class Beside:
    """One number of the paper's and ours.

    Attributes:
        what: what is measured.
        paper: as the paper has it, in words.
        ours: the mean over trials; None where it is a setting.
        said: ours in words where it is a setting.
        decimals: for means.
    """

    what: str
    paper: str
    ours: Mean | None
    said: str = ""
    decimals: int = 2


def beside_the_paper(experiment: Experiment) -> list[Beside]:
    """Return the table of the paper's numbers and ours."""
    two, three = experiment.protocol["phase_two"], experiment.protocol["phase_three"]
    rows = [
        Beside("Trials", "250", None, str(experiment.trials)),
        Beside("Fleet in phase two, robots", "4", None, str(two["robots"])),
        Beside("Fleet in phase three, robots", "12", None, str(three["robots"])),
        Beside(
            "Episodes in phase four", "8", None, str(experiment.protocol["phase_four"]["episodes"])
        ),
    ]
    first = experiment.dwells[0]
    frame = runs_at(experiment, first)
    for scorer, given in (
        (experiment.luce, f"{LUCE_TOP1:.2f}"),
        (experiment.classifier, f"{CLASSIFIER_TOP1:.2f}"),
    ):
        if scorer is None:
            continue
        mine = frame[frame["scorer"] == scorer]
        label = experiment.label(scorer)
        for column, words in (
            ("own_agreement", "states of its own fleet"),
            ("reference_agreement", "states of a fleet that ground truth drives"),
        ):
            rows.append(Beside(f"Top-1 agreement, {label}, {words}", given, mean_of(mine[column])))
    for dwell in experiment.dwells:
        rows += [
            Beside(
                f"Phase three, team reward, {experiment.label(scorer)}, dwell {dwell}",
                "drawn only",
                _reward_mean(experiment, scorer, dwell),
                decimals=1,
            )
            for scorer in (GROUND_TRUTH, experiment.luce, experiment.classifier)
            if scorer
        ]
    return rows


def _reward_mean(experiment: Experiment, scorer: str, dwell: int) -> Mean:
    frame = runs_at(experiment, dwell)
    return mean_of(frame[frame["scorer"] == scorer]["team_reward"])


def in_words(experiment: Experiment, tests: dict[str, list[Contrast]]) -> list[str]:
    """Say where our results agree with the paper and where not, from the numbers alone."""
    return [
        *_prediction_words(experiment, tests.get(PREDICTION, [])),
        *_reward_words(experiment, tests.get(REWARD, [])),
        *_impact_words(experiment, tests.get(IMPACT, [])),
        *_ceiling_words(experiment),
    ]


def _prediction_words(experiment: Experiment, tests: list[Contrast]) -> list[str]:
    sentences = []
    for test in tests:
        lead = f"On {test.measure.removeprefix('agreement, ')}, "
        gap = f"{number(abs(100 * test.mean.value), 1)} percentage points"
        share = f"it was ahead in {100 * test.better:.0f} % of trials"
        if test.verdict == "higher":
            words = (
                "Luce’s scorer agreed with the user more often than the classifier, by "
                f"{gap} ({share}): as in the paper."
            )
        elif test.verdict == "lower":
            words = (
                "Luce’s scorer agreed with the user less often than the classifier, by "
                f"{gap} ({share}): against the paper."
            )
        else:
            words = (
                f"Luce’s scorer and the classifier could not be told apart ({gap} between them; "
                f"{share}): the paper’s difference did not show."
            )
        sentences.append(lead + words)
    frame = runs_at(experiment, experiment.dwells[0])
    for scorer, paper in ((experiment.luce, LUCE_TOP1), (experiment.classifier, CLASSIFIER_TOP1)):
        if scorer is None:
            continue
        mine = frame[frame["scorer"] == scorer]
        own, reference = mean_of(mine["own_agreement"]), mean_of(mine["reference_agreement"])
        places = [
            f"{100 * mean.value:.0f} % ({where})"
            for mean, where in ((own, "own fleet’s states"), (reference, "ground truth’s states"))
        ]
        inside = [m.interval is not None and m.interval.holds(paper) for m in (own, reference)]
        if any(inside):
            words = "one of which has the paper’s number in its interval"
        elif own.value < paper and reference.value < paper:
            words = "both below it"
        elif own.value > paper and reference.value > paper:
            words = "both above it"
        else:
            words = "one on either side of it"
        sentences.append(
            f"The level: {experiment.label(scorer)} reached {listed(places)}, where the paper has "
            f"{100 * paper:.0f} %; {words}."
        )
    return sentences


def _groups(tests: list[Contrast], experiment: Experiment) -> list[tuple[str, str]]:
    """Return for each measure whom Luce's scorer beat, lost to, and could not be told from."""
    found = []
    for measure in dict.fromkeys(test.measure for test in tests):
        here = [test for test in tests if test.measure == measure]
        parts = []
        for verdict, words in (
            ("higher", "more than"),
            ("lower", "less than"),
            ("undecided", "neither clearly more nor less than"),
        ):
            names = [experiment.label(t.second) for t in here if t.verdict == verdict]
            if names:
                parts.append(f"{words} {listed(names)}")
        found.append((measure, "; ".join(parts)))
    return found


def _reward_words(experiment: Experiment, tests: list[Contrast]) -> list[str]:
    sentences = [
        f"{measure.capitalize()}: the fleet under Luce’s scorer earned {words}."
        for measure, words in _groups(tests, experiment)
    ]
    return sentences + _against_baseline(experiment, tests, "team reward")


def _impact_words(experiment: Experiment, tests: list[Contrast]) -> list[str]:
    sentences = [
        f"{measure.capitalize()}: alone, the policy fitted to what was demonstrated under Luce’s "
        f"scorer earned {words}."
        for measure, words in _groups(tests, experiment)
    ]
    return sentences + _against_baseline(experiment, tests, "data impact")


def _against_baseline(experiment: Experiment, tests: list[Contrast], what: str) -> list[str]:
    against = [test for test in tests if test.second == experiment.classifier]
    if not against:
        return []
    agree = [test for test in against if test.verdict == "higher"]
    lower = [test for test in against if test.verdict == "lower"]
    count = counted(len(against), "dwell")
    if len(agree) == len(against):
        return [f"Against the classifier, the paper’s order of {what} holds at all of {count}."]
    told = f"{len(agree)} of {count}"
    reverse = f", and is reversed at {len(lower)}" if lower else ""
    return [f"Against the classifier, the paper’s order of {what} shows at {told}{reverse}."]


def _ceiling_words(experiment: Experiment) -> list[str]:
    """Say how much of what ground truth adds to an unassisted fleet each learned scorer adds."""
    sentences = []
    for dwell in experiment.dwells:
        alone = _reward_mean(experiment, NONE, dwell).value
        best = _reward_mean(experiment, GROUND_TRUTH, dwell).value
        if not best - alone > 0:
            continue
        shares = {
            name: 100 * (_reward_mean(experiment, name, dwell).value - alone) / (best - alone)
            for name in experiment.scorers
            if name not in (NONE, GROUND_TRUTH)
        }
        parts = [f"{experiment.label(name)} {share:.0f} %" for name, share in shares.items()]
        sentences.append(
            f"Of the {number(best - alone, 0)} points that ground truth adds to a fleet that "
            f"nobody helps (dwell {dwell}), the scorers add: {listed(parts)}."
        )
    return sentences


def policy_means(experiment: Experiment, dwell: int) -> list[tuple[str, Mean, Mean]]:
    """Return (scorer, policy's reward, data impact) of a dwell's main policies."""
    frame = policies_at(experiment, dwell)
    return [
        (
            scorer,
            mean_of(frame[frame["scorer"] == scorer]["policy_reward"]),
            mean_of(frame[frame["scorer"] == scorer]["data_impact"]),
        )
        for scorer in experiment.scorers
    ]
