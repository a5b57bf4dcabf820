"""Which rows enter the tests: phase three's complete trials, after the declared exclusions.

Trials are left out first: what a rule then counts of a participant are the trials that remain.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import pandas as pd

from analysis.protocol_facts import ExclusionRule, ProtocolFacts
from analysis.recordings import StudyRecordings
from analysis.statistics.result import Excluded
from analysis.tables.study_tables import StudyTables
from study.events.codes import Phase


@dataclasses.dataclass(frozen=True, slots=True)
class AnalysedData:
    """The rows that tests rest on.

    Attributes:
        trials: scored, complete trials of phase three of those kept.
        all_trials: the same of everybody, whom a rule leaves out too.
        excluded_trials: complete trials of phases three and four that a rule of the protocol
            leaves out, with the rule's name as "rule"; of those kept.
        broken_trials: scored trials of phase three that did not run to their end.
        phase_four: complete trials of phase four of those kept.
        responses: answers of those kept.
        excluded: participants left out by a rule of the protocol.
        unknown_rules: names of rules whose measure this version does not know.
        orders: each participant's conditions in the order run.
    """

    trials: pd.DataFrame
    all_trials: pd.DataFrame
    excluded_trials: pd.DataFrame
    broken_trials: pd.DataFrame
    phase_four: pd.DataFrame
    responses: pd.DataFrame
    excluded: tuple[Excluded, ...]
    unknown_rules: tuple[str, ...]
    orders: Mapping[str, tuple[str, ...]]


def analysed_data(
    study: StudyRecordings, tables: StudyTables, facts: ProtocolFacts
) -> AnalysedData:
    """Select the rows that enter the tests."""
    trials = tables.frame("trials")
    rules = trials["deviations"].astype("str").map(lambda codes: _rule_against(facts, codes))
    tested = trials[rules == ""]
    left_out = trials[(rules != "") & trials["complete"]].assign(rule=rules)
    three = tested[(tested["phase"] == Phase.THREE) & tested["scored"]]
    people = [session.opened.participant for session in study.sessions]
    excluded: dict[str, Excluded] = {}
    unknown: list[str] = []
    for rule in facts.exclusions:
        counts = _counts(rule, tables, three)
        if counts is None:
            unknown.append(rule.name)
            continue
        for participant in people:
            count = counts.get(participant, 0)
            if count < rule.at_least and participant not in excluded:
                reason = (
                    f"rule {rule.name}: {count} {rule.measure.replace('_', ' ')}, "
                    f"at least {rule.at_least:g} required"
                )
                excluded[participant] = Excluded(participant, reason)
    kept = set(people) - set(excluded)
    everybody = three[three["complete"]]
    three = three[three["participant"].isin(kept)]
    four = tested[(tested["phase"] == Phase.FOUR) & tested["complete"]]
    left_out = left_out[left_out["participant"].isin(kept) & (left_out["phase"] >= Phase.THREE)]
    responses = tables.frame("responses")
    return AnalysedData(
        trials=three[three["complete"]],
        all_trials=everybody,
        excluded_trials=left_out,
        broken_trials=three[~three["complete"]],
        phase_four=four[four["participant"].isin(kept)],
        responses=responses[responses["participant"].isin(kept)],
        excluded=tuple(excluded[name] for name in sorted(excluded)),
        unknown_rules=tuple(unknown),
        orders={s.opened.participant: s.opened.order for s in study.sessions},
    )


def _rule_against(facts: ProtocolFacts, codes: str) -> str:
    """Return the name of the first rule that leaves a trial out; empty if none does."""
    happened = set(codes.split(","))
    return next((rule.name for rule in facts.trial_exclusions if rule.deviations & happened), "")


def _counts(rule: ExclusionRule, tables: StudyTables, three: pd.DataFrame) -> dict[str, int] | None:
    """Count what a rule counts, by participant; None if its measure is unknown."""
    if rule.measure == "complete_trials":
        rows = three[three["complete"]]
    elif rule.measure == "choices":
        # Those that a scorer is fitted on: the operator's own, in phase two.
        choices = tables.frame("choices")
        own = (choices["source"] == "operator") & (choices["flag"] == "usable")
        rows = choices[own & (choices["phase"] == Phase.TWO)]
    elif rule.measure == "demonstrations":
        steps = tables.frame("timesteps")
        rows = steps[(steps["action_source"] == "operator") & (steps["phase"] > Phase.PRACTICE)]
    else:
        return None
    counted = rows["participant"].astype("str").value_counts()
    return {str(name): int(count) for name, count in counted.items()}
