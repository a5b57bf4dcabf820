"""What the study's scored instruments show: which scales, and the rows their tests rest on."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from analysis.instruments import Instrument, instruments
from analysis.measures import AnalysedData
from analysis.recordings import StudyRecordings
from analysis.statistics.scale_scores import AskedScale, Floats, ScaleRow, scale_rows
from analysis.tables.scores import answers_by_form

OCCASIONS = ("at_start", "before_reveal", "after_reveal", "at_end")


def scored_instruments(
    study: StudyRecordings, data: AnalysedData, levels: Sequence[str]
) -> tuple[ScaleRow, ...]:
    """Compare conditions on every scale that was scored, and compute its reliability.

    Args:
        study: the recordings.
        data: the rows of those whom no rule leaves out.
        levels: conditions, the reference first.
    """
    if data.scores.empty:
        return ()
    known: dict[str, Instrument] = {}
    for session in study.sessions:
        known = instruments(session) | known
    asked = _asked(data, known)
    return tuple(scale_rows(asked, data.scores, _answers(study, data, asked), levels))


def differing_instruments(study: StudyRecordings) -> list[tuple[str, str]]:
    """Return names of instruments that sessions did not all ask in the same version and wording.

    Returns:
        Name, and the versions asked, as text.
    """
    seen: dict[str, list[Instrument]] = {}
    for session in study.sessions:
        for name, instrument in instruments(session).items():
            if instrument not in seen.setdefault(name, []):
                seen[name].append(instrument)
    return [
        (name, ", ".join(str(version) for version in sorted({i.version for i in given})))
        for name, given in sorted(seen.items())
        if len(given) > 1
    ]


def _asked(data: AnalysedData, known: dict[str, Instrument]) -> list[AskedScale]:
    columns = ("questionnaire", "scale", "occasion", "lowest", "highest", "version")
    found: dict[tuple[str, str, str], AskedScale] = {}
    for name, scale, occasion, lowest, highest, version in zip(
        *(data.scores[column] for column in columns), strict=True
    ):
        instrument = known.get(str(name))
        declared = instrument.scale(str(scale)) if instrument else None
        found.setdefault(
            (str(name), str(scale), str(occasion)),
            AskedScale(
                instrument=str(name),
                title=instrument.title if instrument else str(name),
                version=int(version),
                scale=str(scale),
                occasion=str(occasion),
                lowest=float(lowest),
                highest=float(highest),
                items=declared.items if declared else (),
            ),
        )

    def place(asked: AskedScale) -> tuple[str, str, int, str]:
        known_when = asked.occasion in OCCASIONS
        when = OCCASIONS.index(asked.occasion) if known_when else len(OCCASIONS)
        return asked.instrument, asked.scale, when, asked.occasion

    return sorted(found.values(), key=place)


def _answers(
    study: StudyRecordings, data: AnalysedData, asked: Sequence[AskedScale]
) -> dict[tuple[str, str, str, str], Floats]:
    """Gather the answers behind each scale, a row a participant who answered every item."""
    kept = set(data.scores["participant"].astype(str))
    rows: dict[tuple[str, str, str, str], list[list[float]]] = {}
    for session in study.sessions:
        if session.opened.participant not in kept:
            continue
        definitions, forms = instruments(session), answers_by_form(session)
        for (_, _, condition, name, occasion), answers in forms.items():
            instrument = definitions.get(name)
            for scale in instrument.scales if instrument else ():
                values = instrument.directed(scale, answers) if instrument else None
                wanted = any(
                    (a.instrument, a.scale, a.occasion, a.items)
                    == (name, scale.name, occasion, scale.items)
                    for a in asked
                )
                if values is not None and wanted:
                    rows.setdefault((name, scale.name, occasion, condition), []).append(values)
    return {key: np.array(values, dtype=np.float64) for key, values in rows.items()}
