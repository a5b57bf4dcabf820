"""Everything that the report states, computed once from the recordings."""

from __future__ import annotations

import dataclasses

import numpy as np

from analysis.data_label import DataLabel, data_label
from analysis.deviations import Told, told
from analysis.factor_answers import ByFactor, ratings_by_factor, scales_by_factor
from analysis.factorial import Factorial, factorial
from analysis.measures import AnalysedData, analysed_data
from analysis.protocol_facts import ProtocolFacts, protocol_facts
from analysis.recordings import StudyRecordings
from analysis.robustness import Robustness, order_tests, reward_tests, robustness
from analysis.scored_instruments import scored_instruments
from analysis.statistics.cells import Cells, cell_means
from analysis.statistics.crossover import Crossover
from analysis.statistics.latin_square import LatinSquare
from analysis.statistics.likert import LikertRow, likert_rows
from analysis.statistics.order_effects import OrderRow, describe_orders
from analysis.statistics.phase_four import PhaseFour, phase_four
from analysis.statistics.pooled_trials import condition_and_trial, condition_trial_order
from analysis.statistics.result import EffectResult, Outcome, Refusal
from analysis.statistics.scale_scores import ScaleRow
from analysis.tables.study_tables import StudyTables
from analysis.variants import Variant, variants
from study.events.codes import Phase

OCCASIONS = ("before_reveal", "after_reveal")


@dataclasses.dataclass(frozen=True, slots=True)
class StudyResults:
    """The study's results.

    Attributes:
        study: the recordings.
        tables: their tables.
        facts: what the protocol says.
        label: who produced the data.
        data: the rows that tests rest on.
        cells: team reward by participant and condition.
        primary: the primary test.
        sensitivity: other tests of the same question.
        contrasts: each pair of three or more conditions, Holm-adjusted.
        factorial: the effects of the factors that conditions cross; None if they cross none.
        variants: the primary test on other choices of rows.
        comparison: the paper's form.
        robustness: the difference from other sides; None unless two conditions were compared.
        order_tests: condition, period and carry-over; None where conditions were not tested.
        orders: description by order.
        ratings: a row for each item on a scale that enters no score, and occasion.
        scales: a row for each scale of a scored instrument, and occasion.
        rating_effects: each item by the factors that conditions cross; empty if they cross none.
        scale_effects: the same of each scale.
        phase_four: policies on their own.
        deviations: what deviated from the protocol, each fact once.
    """

    study: StudyRecordings
    tables: StudyTables
    facts: ProtocolFacts
    label: DataLabel
    data: AnalysedData
    cells: Cells
    primary: Outcome
    sensitivity: tuple[Outcome, ...]
    contrasts: tuple[Outcome, ...]
    factorial: Factorial | None
    variants: tuple[Variant, ...]
    comparison: tuple[Outcome, ...]
    robustness: Robustness | None
    order_tests: Crossover | LatinSquare | Refusal | None
    orders: tuple[OrderRow, ...]
    ratings: tuple[LikertRow, ...]
    scales: tuple[ScaleRow, ...]
    rating_effects: tuple[ByFactor[LikertRow], ...]
    scale_effects: tuple[ByFactor[ScaleRow], ...]
    phase_four: PhaseFour
    deviations: tuple[Told, ...]

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of the conditions, the reference first."""
        return tuple(condition.label for condition in self.facts.conditions)

    @property
    def by_trial(self) -> bool:
        """Whether the primary test is that of the trials, as participants lack some."""
        return isinstance(self.primary, EffectResult) and self.primary.method == "Kenward-Roger"


def compute_results(study: StudyRecordings, tables: StudyTables) -> StudyResults:
    """Run every analysis; what cannot be computed is a refusal, never an error."""
    facts = protocol_facts(study)
    data = analysed_data(study, tables, facts)
    levels = facts.levels
    cells = cell_means(data.trials, "team_reward", levels, what="complete trials")
    cells = dataclasses.replace(cells, excluded=(*data.excluded, *cells.excluded))
    whole = frozenset(s.opened.participant for s in study.sessions if s.complete)
    tests = reward_tests(data.trials, cells)
    used = data.trials[data.trials["participant"].isin(cells.participants)]
    trials = tables.frame("trials")
    before = trials[trials["phase"] == Phase.THREE]
    baseline = {
        str(who): str(policy)
        for who, policy in zip(before["participant"], before["policy_id"], strict=True)
    }
    ratings, scales = _ratings(data, facts), scored_instruments(study, data, levels)
    return StudyResults(
        study=study,
        tables=tables,
        facts=facts,
        label=data_label(study),
        data=data,
        cells=cells,
        primary=tests.primary,
        sensitivity=tests.sensitivity,
        contrasts=tests.contrasts,
        factorial=factorial(facts.crossing, data.trials, cells),
        variants=variants(data, cells, tests.primary, whole),
        comparison=(condition_trial_order(used, levels), condition_and_trial(used, levels)),
        robustness=robustness(cells, tests.means, facts.equivalence_bound),
        order_tests=order_tests(cells, data.orders, tests.means),
        orders=tuple(describe_orders(used, dict(data.orders))),
        ratings=tuple(ratings),
        scales=scales,
        rating_effects=ratings_by_factor(facts.crossing, ratings, data.responses),
        scale_effects=scales_by_factor(facts.crossing, scales),
        phase_four=phase_four(data.phase_four, tables.frame("fits"), levels, baseline),
        deviations=told(tables),
    )


def rated_items(facts: ProtocolFacts) -> frozenset[tuple[str, str]]:
    """Return (questionnaire, item) of all that is answered on a scale and enters no score."""
    found = set()
    for name, instrument in facts.instruments.items():
        scored = {item for scale in instrument.scales for item in scale.items}
        for item in instrument.items:
            if item.kind == "scale" and item.name not in scored:
                found.add((name, item.name))
    return frozenset(found)


def _ratings(data: AnalysedData, facts: ProtocolFacts) -> list[LikertRow]:
    rated, known = rated_items(facts), set(facts.instruments)
    names = zip(data.responses["questionnaire"], data.responses["item"], strict=True)
    # What no questionnaire on record declares is taken for a rating: nothing is passed over.
    wanted = np.array([pair in rated or pair[0] not in known for pair in names], dtype=bool)
    answers = data.responses[wanted]
    answers = answers[answers["condition"] != ""]
    pairs = set(zip(answers["item"], answers["occasion"], strict=True))
    asked = {(str(item), str(occasion)) for item, occasion in pairs}
    items = [item for item in facts.items if any(key[0] == item for key in asked)]
    items += sorted({key[0] for key in asked} - set(items))
    occasions = [name for name in OCCASIONS if any(key[1] == name for key in asked)]
    occasions += sorted({key[1] for key in asked} - set(occasions))
    keys = [(item, when) for when in occasions for item in items if (item, when) in asked]
    return likert_rows(answers, keys, facts.levels) if keys else []
