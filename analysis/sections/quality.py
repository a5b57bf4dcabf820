"""Data quality and timing: everything that could change a result."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

import numpy as np

from analysis.deviations import in_words
from analysis.formatting import counted, listed, number
from analysis.left_out import SetAside
from analysis.recordings import Session
from analysis.results import StudyResults
from analysis.scored_instruments import differing_instruments
from analysis.sections.orders import changed_orders, uneven_orders


@dataclasses.dataclass(frozen=True, slots=True)
class Flag:
    """Something a reader must know of one session."""

    kind: str
    session: str
    text: str
    treatment: str


@dataclasses.dataclass(frozen=True, slots=True)
class RuleRow:
    """One exclusion rule of the protocol: what it leaves out, and what it did leave out."""

    name: str
    what: str
    found: str
    reason: str


@dataclasses.dataclass(frozen=True, slots=True)
class TimingRow:
    """How punctual one session was; numbers as written, in milliseconds.

    Attributes:
        frames_late: share of late pictures, percent.
        poll_gap: longest between two readings of the keys: no reaction time errs by more.
        remark: what was bad, or empty.
    """

    participant: str
    timesteps: int
    skipped: int
    interval: str
    late_p99: str
    late_max: str
    frames: int
    frame_median: str
    frame_p99: str
    frames_late: str
    poll_gap: str
    remark: str


MOST_SKIPPED, MOST_LATE = 0.01, 0.01
"""Shares of timesteps skipped and of pictures late beyond which a session is remarked upon."""
LONGEST_POLL_GAP_S = 0.1
"""Between two readings of the keys; an error of a reaction time that is no longer small."""


def flags(results: StudyResults) -> list[Flag]:
    """List exclusions, incomplete sessions, file problems, orders, broken trials and deviations."""
    study, data = results.study, results.data
    found = [
        Flag("Left out", item.participant, item.reason, "Not in the tests of team reward")
        for item in results.cells.excluded
    ]
    left_out = {item.participant for item in results.cells.excluded}
    deviations = results.deviations
    ends = {row.session: row.text for row in deviations if row.kept and row.code == "ended_early"}
    for session in study.sessions:
        who = session.opened.participant
        if not session.complete:
            kept = "Left out" if who in left_out else "Kept; tested without as well"
            found.append(Flag("Incomplete session", who, _incomplete(session, ends), kept))
        if session.left_out_trials:
            text = f"{counted(session.left_out_trials, 'fleet run')} broken off, and begun anew"
            found.append(Flag("Broken trial", who, text, "The new ones count"))
        found += [
            Flag("File", who, problem, "What is readable is analysed")
            for problem in session.recording.problems
        ]
        found += [
            Flag("Lost records", who, text, "Not in the tests") for text in _lost_in_trials(session)
        ]
    found += [
        Flag("Order", who, text, "Analysed as run")
        for who, text in changed_orders(study, results.facts)
    ]
    uneven = uneven_orders(study, results.facts)
    if uneven:
        found.append(Flag("Order", "all", f"Not balanced: {uneven}", "Analysed as run"))
    departed = data.departures
    for who, condition in sorted(
        {*zip(departed["participant"], departed["condition"], strict=True)}
    ):
        which = (departed["participant"] == who) & (departed["condition"] == condition)
        label = results.facts.label(str(condition))
        text = f"{counted(int(which.sum()), 'trial')} under {label} did not run as assigned"
        treatment = "As assigned in the tests; as treated beside them"
        found.append(Flag("Not as assigned", str(who), text, treatment))
    broken = data.broken_trials
    for who, condition, trial in zip(
        broken["participant"], broken["condition"], broken["trial"], strict=True
    ):
        label = results.facts.label(str(condition))
        text = f"Trial {trial} under {label} did not run to its end"
        found.append(Flag("Broken trial", str(who), text, "Not in the tests"))
    left = data.excluded_trials
    for who, condition, trial, rule, codes in zip(
        left["participant"],
        left["condition"],
        left["trial"],
        left["rule"],
        left["deviations"],
        strict=True,
    ):
        label = results.facts.label(str(condition))
        text = f"Trial {trial} under {label}: rule {rule} ({str(codes).replace(',', ', ')})"
        found.append(Flag("Excluded trial", str(who), text, "Not in the tests"))
    gone = set(zip(left["session"].astype("str"), left["trial_id"], strict=True))
    for row in deviations:
        if row.kept and row.code == "ended_early":
            continue  # The row of the incomplete session says so.
        kept = "Its trial is not in the tests" if (row.session, row.trial_id) in gone else "Kept"
        if not row.kept:
            kept = "The session was resumed, from before it"
        found.append(Flag("Deviation", row.participant, row.text, kept))
    found += _doubtful_scores(results)
    found += [
        Flag("File", item.participant or item.file, item.reason, "Cannot be used")
        if item.unreadable
        else Flag("File left out", item.participant or item.file, _with_file(item), "Not analysed")
        for item in study.set_aside
    ]
    if len(study.protocol_hashes) > 1:
        text = f"{len(study.protocol_hashes)} different protocols were pooled on purpose"
        found.append(Flag("Protocol", "all", text, "Pooled; compare with care"))
    found += [
        Flag("Protocol", "all", f"The measure of rule {name} is not known", "Rule not applied")
        for name in data.unknown_rules
    ]
    return found


def _doubtful_scores(results: StudyResults) -> list[Flag]:
    """Flag scores that answers do not give, and instruments asked in several wordings."""
    scores = results.tables.frame("scores")
    found = []
    columns = ("participant", "questionnaire", "scale", "occasion", "score", "computed")
    for who, name, scale, when, score, computed in zip(*(scores[c] for c in columns), strict=True):
        if math.isfinite(computed) and not math.isclose(score, computed, abs_tol=1e-9):
            text = f"{name} {scale}, {when}: {score:g} recorded, {computed:g} from the answers"
            found.append(Flag("Score", str(who), text, "Kept as recorded"))
    for name, versions in differing_instruments(results.study):
        text = f"{name} was not asked alike in all sessions (version {versions})"
        found.append(Flag("Instrument", "all", text, "Pooled; compare with care"))
    return found


def _with_file(item: SetAside) -> str:
    """Give the reason why a file is left out; name the file where the row names a participant."""
    return f"{item.file}: {item.reason}" if item.participant else item.reason


def _incomplete(session: Session, ends: Mapping[str, str]) -> str:
    """Say why a session is not complete, by its recorded deviation where there is one."""
    if session.ended is None:
        return "Its end is not recorded"
    if session.ended.complete:
        return "Every stage was passed, but records are missing"
    return ends.get(session.opened.session_id) or in_words("ended_early", session.ended.reason)


def rules(results: StudyResults) -> list[RuleRow]:
    """Say what each rule of the protocol left out: trials first, then participants."""
    trials = results.data.excluded_trials
    rows = []
    for rule in results.facts.trial_exclusions:
        own = trials[trials["rule"] == rule.name]
        people = listed(sorted({str(who) for who in own["participant"]}))
        found = f"{counted(len(own), 'trial')} of {people}" if len(own) else "no trial"
        codes = listed([code.replace("_", " ") for code in sorted(rule.deviations)])
        rows.append(RuleRow(rule.name, f"trials: {codes}", found, rule.reason))
    for applied in results.data.rules:
        rule_of, measure = applied.rule, applied.rule.measure.replace("_", " ")
        what = f"participants: fewer than {rule_of.at_least:g} {measure}"
        found = ", ".join(applied.participants) or "nobody"
        rows.append(RuleRow(rule_of.name, what, found, rule_of.reason))
    return rows


def _lost_in_trials(session: Session) -> list[str]:
    """Say of which fleet runs records are missing."""
    texts = []
    if session.damaged_trials:
        numbers = ", ".join(map(str, session.damaged_trials))
        texts.append(f"Records are missing of fleet runs {numbers}: they count as incomplete")
    texts += [
        f"The beginning of fleet run {trial} is missing: its {count} timesteps are left out"
        for trial, count in session.unknown_trials.items()
    ]
    return texts


def timing_rows(results: StudyResults) -> list[TimingRow]:
    """Summarise timing by session, operated fleet runs only."""
    timing = results.tables.frame("timing")
    timing = timing[timing["phase"] < 4]
    rows: list[TimingRow] = []
    for session in results.study.sessions:
        own = timing[timing["participant"] == session.opened.participant]
        columns = {name: own[name].to_numpy() for name in own.columns}
        rows.append(
            TimingRow(
                participant=session.opened.participant,
                timesteps=int(columns["timesteps"].sum()),
                skipped=int(columns["skipped"].sum()),
                interval=_milliseconds(columns["interval_median"], "median"),
                late_p99=_milliseconds(columns["late_p99"], "max"),
                late_max=_milliseconds(columns["late_max"], "max"),
                frames=int(columns["frames"].sum()),
                frame_median=_milliseconds(columns["frame_median"], "median"),
                frame_p99=_milliseconds(columns["frame_p99"], "max"),
                frames_late=_late_share(columns),
                poll_gap=_milliseconds(columns["poll_gap_max"], "max"),
                remark="; ".join(_bad_timing(columns)),
            )
        )
    return rows


def _late_share(columns: dict[str, np.ndarray]) -> str:
    frames = float(columns["frames"].sum())
    return number(100 * float(columns["frames_late"].sum()) / frames, 1) if frames else "–"


def _bad_timing(columns: dict[str, np.ndarray]) -> list[str]:
    """Say in which respects a session was not punctual."""
    timesteps, frames = float(columns["timesteps"].sum()), float(columns["frames"].sum())
    gaps = columns["poll_gap_max"]
    found = []
    if float(columns["skipped"].sum()) > MOST_SKIPPED * timesteps:
        found.append("timesteps were skipped")
    if float(columns["frames_late"].sum()) > MOST_LATE * frames:
        found.append("pictures were late")
    if np.nanmax(gaps, initial=0.0) > LONGEST_POLL_GAP_S:
        found.append("keys were read late")
    return found


def _milliseconds(seconds: np.ndarray, how: str) -> str:
    known = seconds[np.isfinite(seconds)]
    if known.size == 0:
        return "–"
    value = float(np.median(known) if how == "median" else known.max())
    return number(value * 1000, 1) if math.isfinite(value) else "–"
