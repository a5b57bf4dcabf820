"""What the experimenter does to a running session from the console; see `study.console`."""

from __future__ import annotations

from study.events.fields import Record, fixed64, record, sfixed32, string


@record("input", "experimenter_commanded")
class ExperimenterCommanded(Record):
    """The experimenter asked for something at the console."""

    t_ns: int = fixed64(1, "when it was taken", unit="ns")
    command: str = string(2, '"pause", "resume", "annotate" or "end"')
    text: str = string(3, "the note, or the reason to end; empty otherwise")


@record("event", "experimenter_noted")
class ExperimenterNoted(Record):
    """A note of the experimenter, and where in the session it was taken."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    text: str = string(2, "the note")
    trial_id: int = sfixed32(3, "which fleet run; -1 if none")
    stage: int = sfixed32(4, "place of the stage in the sequence, from 0")
