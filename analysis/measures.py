"""Which rows enter the tests: phase three's complete trials, after the declared exclusions.

Trials are left out first: what a rule then counts of a participant are the trials that remain.
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Mapping, Sequence

import pandas as pd

from analysis.protocol_facts import ExclusionRule, ProtocolFacts
from analysis.recordings import StudyRecordings
from analysis.statistics.result import Excluded
from analysis.tables.study_tables import StudyTables
from study.events.codes import Phase


@dataclasses.dataclass(frozen=True, slots=True)
class AppliedRule:
    """What one exclusion rule of the protocol did.

    Attributes:
        rule: the rule.
        counts: what it counts, by participant.
        participants: those below its threshold, sorted.
    """

    rule: ExclusionRule
    counts: Mapping[str, int]
    participants: tuple[str, ...]


@dataclasses.dataclass(frozen=True, slots=True)
class AnalysedData:
    """The rows that tests rest on.

    Attributes:
        trials: scored, complete trials of phase three of those kept.
        all_trials: the same of everybody, whom a rule leaves out too.
        unruled_trials: the same as if the protocol had no rule, of participants or of trials.
        excluded_trials: complete trials of phases three and four that a rule of the protocol
            leaves out, with the rule's name as "rule"; of those kept.
        treated: those of ``trials`` that ran some condition of the protocol, under the name of
            the condition that ran.
        departures: those of ``trials`` that did not run as assigned.
        broken_trials: scored trials of phase three that did not run to their end.
        phase_four: complete trials of phase four of those kept.
        responses: answers of those kept.
        scores: scores of instruments of those kept.
        rules: what each rule of the protocol did.
        excluded: participants left out by a rule of the protocol.
        unknown_rules: names of rules whose measure this version does not know.
        orders: each participant's conditions in the order run.
    """

    trials: pd.DataFrame
    all_trials: pd.DataFrame
    unruled_trials: pd.DataFrame
    excluded_trials: pd.DataFrame
    treated: pd.DataFrame
    departures: pd.DataFrame
    broken_trials: pd.DataFrame
    phase_four: pd.DataFrame
    responses: pd.DataFrame
    scores: pd.DataFrame
    rules: tuple[AppliedRule, ...]
    excluded: tuple[Excluded, ...]
    unknown_rules: tuple[str, ...]
    orders: Mapping[str, tuple[str, ...]]


def analysed_data(
    study: StudyRecordings, tables: StudyTables, facts: ProtocolFacts
) -> AnalysedData:
    """Select the rows that enter the tests."""
    trials = tables.frame("trials")
    against = trials["deviations"].astype("str").map(lambda codes: _rule_against(facts, codes))
    tested = trials[against == ""]
    left_out = trials[(against != "") & trials["complete"]].assign(rule=against)
    three = tested[(tested["phase"] == Phase.THREE) & tested["scored"]]
    people = [session.opened.participant for session in study.sessions]
    rules, unknown = _apply_rules(facts.exclusions, people, tables, three)
    excluded = _excluded(rules)
    kept = set(people) - {item.participant for item in excluded}
    used = three[three["complete"] & three["participant"].isin(kept)]
    ran = used["treated"].astype("str")
    four = tested[(tested["phase"] == Phase.FOUR) & tested["complete"]]
    left_out = left_out[left_out["participant"].isin(kept) & (left_out["phase"] >= Phase.THREE)]
    every = trials["complete"] & trials["scored"] & (trials["phase"] == Phase.THREE)
    responses, scores = tables.frame("responses"), tables.frame("scores")
    return AnalysedData(
        trials=used,
        all_trials=three[three["complete"]],
        unruled_trials=trials[every],
        excluded_trials=left_out,
        treated=used[ran != ""].assign(condition=ran[ran != ""]),
        departures=used[ran != used["condition"].astype("str")],
        broken_trials=three[~three["complete"] & three["participant"].isin(kept)],
        phase_four=four[four["participant"].isin(kept)],
        responses=responses[responses["participant"].isin(kept)],
        scores=scores[scores["participant"].isin(kept)],
        rules=rules,
        excluded=excluded,
        unknown_rules=unknown,
        orders={s.opened.participant: s.opened.order for s in study.sessions},
    )


def _rule_against(facts: ProtocolFacts, codes: str) -> str:
    """Return the name of the first rule that leaves a trial out; empty if none does."""
    happened = set(codes.split(","))
    return next((rule.name for rule in facts.trial_exclusions if rule.deviations & happened), "")


def _apply_rules(
    rules: Sequence[ExclusionRule],
    people: Sequence[str],
    tables: StudyTables,
    three: pd.DataFrame,
) -> tuple[tuple[AppliedRule, ...], tuple[str, ...]]:
    applied: list[AppliedRule] = []
    unknown: list[str] = []
    for rule in rules:
        counts = _counts(rule, tables, three)
        if counts is None:
            unknown.append(rule.name)
            continue
        by_person = {who: counts.get(who, 0) for who in people}
        below = tuple(sorted(who for who, count in by_person.items() if count < rule.at_least))
        applied.append(AppliedRule(rule, by_person, below))
    return tuple(applied), tuple(unknown)


def _excluded(applied: Sequence[AppliedRule]) -> tuple[Excluded, ...]:
    """Name each participant once, with every rule that leaves them out."""
    reasons: dict[str, list[str]] = {}
    for item in applied:
        what = item.rule.measure.replace("_", " ")
        for who in item.participants:
            reasons.setdefault(who, []).append(
                f"rule {item.rule.name}: {item.counts[who]} {what}, "
                f"at least {item.rule.at_least:g} required"
            )
    return tuple(Excluded(who, "; ".join(texts)) for who, texts in sorted(reasons.items()))


def _counts(rule: ExclusionRule, tables: StudyTables, three: pd.DataFrame) -> dict[str, int] | None:
    """Count what a rule counts, by participant; None if its measure is unknown."""
    if rule.measure == "complete_trials":
        return _by_participant(three[three["complete"]])
    counts: Counter[str] = Counter()
    if rule.measure == "choices":
        # Those that a scorer is fitted on: the operator's own, in phase two.
        for part in tables.parts("choices"):
            rows = part.frame
            own = (rows["source"] == "operator") & (rows["flag"] == "usable")
            counts.update(_by_participant(rows[own & (rows["phase"] == Phase.TWO)]))
    elif rule.measure == "demonstrations":
        for part in tables.parts("timesteps"):
            rows = part.frame
            driven = rows["action_source"] == "operator"
            counts.update(_by_participant(rows[driven & (rows["phase"] > Phase.PRACTICE)]))
    else:
        return None
    return dict(counts)


def _by_participant(rows: pd.DataFrame) -> dict[str, int]:
    counted = rows["participant"].astype("str").value_counts()
    return {str(name): int(count) for name, count in counted.items()}
