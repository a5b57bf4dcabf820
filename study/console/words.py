"""What the console's panels say, as text with colours; alarms are words too, never colour alone."""

from __future__ import annotations

from rich.text import Text

from study.console.wire import Remark, Status

UNSAVED_LIMIT_S = 1.0
"""From which age of an unsaved record on the recording is shown red."""
SILENCE_LIMIT_S = 1.0
"""How long a session may say nothing before that is shown red."""
LATE_SHARE = 0.01
NO_LIMIT = 1_000_000
"""Timesteps of a trial that only the ends of its episodes end."""
STANDING = "bold black on yellow"
GOOD, CAREFUL, BAD, QUIET = "bold green", "bold yellow", "bold white on red", "dim"
PHASES = ("practice", "phase 1", "phase 2", "phase 3", "phase 4")
_WHY = {
    "operator": "the participant paused",
    "focus lost": "the window lost the keyboard",
    "recording interrupted": "the recording was interrupted",
    "experimenter": "you paused",
}


def clock(seconds: float) -> str:
    """Return a time as 1:02:03 or 2:03."""
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"


def headline(status: Status, silence_s: float, farewell: str = "", *, over: bool = False) -> Text:
    """Return who is in the session, and how it stands.

    Args:
        status: what it said last.
        silence_s: how long ago.
        farewell: why it is not followed any more; empty while it is.
        over: whether that is as it should be.
    """
    facts = status.facts
    text = Text.assemble(
        (f" {facts.participant} ", "bold reverse"), f"  {facts.study}  ",
        ("order ", QUIET), " then ".join(facts.order), "  ",
        (clock(status.t_s + silence_s), "bold"), ("  since the start", QUIET), "\n",
    )  # fmt: skip
    if farewell:
        return text.append(f" {farewell} ", "bold reverse" if over else BAD)
    return text.append_text(_state(status, silence_s))


def _state(status: Status, silence_s: float) -> Text:
    if silence_s > SILENCE_LIMIT_S:
        return Text.assemble((f" NO WORD FROM THE SESSION FOR {silence_s:.0f} s ", BAD))
    still = clock(status.still_s + silence_s)
    why = _WHY.get(status.why, status.why)
    if status.state == "held":
        also = "" if status.why == "experimenter" else f"; before that, {why}"
        paused = f" PAUSED BY THE EXPERIMENTER, {still} "
        return Text.assemble((paused, STANDING), f"  R resumes{also}")
    if status.state == "paused":
        return Text.assemble((f" PAUSED, {still} ", STANDING), f"  {why}; the participant goes on")
    if status.state == "ended":
        return Text.assemble((" ENDED ", "bold reverse"))
    return Text.assemble((" RUNNING ", "bold black on green"))


def now(status: Status) -> Text:
    """Return stage, phase, condition and trial."""
    place = status.place
    text = Text()
    text.append(f"Stage {place.number} of {place.stages}", "bold")
    text.append(f"  {_bar(place.number, place.stages)}\n")
    phase = PHASES[place.phase] if 0 <= place.phase < len(PHASES) else f"phase {place.phase}"
    name = place.name.replace("_", " ")
    text.append(f"{place.kind}\n" if name == place.kind else f"{place.kind}: {name}\n")
    text.append(phase.capitalize())
    if place.block:
        text.append(f", block {place.block}")
    if place.condition:
        text.append(f", condition {place.condition}")
    trial = status.trial
    if trial is None:
        return text.append("\nNo fleet run under way", QUIET)
    robots = "robot" if trial.robots == 1 else "robots"
    text.append(f"\nTrial {trial.number}, {trial.robots} {robots}, {trial.allocation}\n")
    if trial.timesteps >= NO_LIMIT:
        # Episodes end it, whenever that is.
        return text.append(f"Timestep {trial.timestep}", "bold")
    text.append(f"Timestep {trial.timestep} of {trial.timesteps}", "bold")
    return text.append(f"  {_bar(trial.timestep, trial.timesteps)}")


def recording(status: Status, silence_s: float, *, over: bool = False) -> Text:
    """Return the age of what is not yet on disk; red above a second.

    Args:
        status: what the session said last.
        silence_s: how long ago.
        over: whether the session ended, as it should: it says no more of the records since.
    """
    disk = status.disk
    if over:
        text = Text(f"The session has ended after record {disk.sent:,} or later.\n")
        return text.append("Its terminal says where the recording is.", QUIET)
    # What a session that says nothing has written meanwhile is not known.
    age = disk.unsaved_s + (silence_s if silence_s > SILENCE_LIMIT_S else 0.0)
    text = Text()
    if age > UNSAVED_LIMIT_S:
        text.append(f" NOTHING REACHED THE DISK FOR {age:.1f} s ", BAD)
    else:
        text.append("All but the last ").append(f"{age:.1f} s", GOOD).append(" is on disk")
    text.append(f"\nRecord {disk.durable:,} of {disk.sent:,} is on disk")
    if not disk.working:
        text.append("\n").append(" THE WRITER DOES NOT KEEP UP ", BAD)
    part = f"part {disk.part} of " if disk.part > 1 else ""
    return text.append(f"\n{part}{status.facts.file}", QUIET)


def timing(status: Status) -> Text:
    """Return how punctual pictures and timesteps are."""
    found, text = status.timing, Text()
    if found.frames:
        share = found.late / found.frames
        text.append(f"{found.late} of {found.frames:,} pictures late ({share:.1%})",
                    CAREFUL if share >= LATE_SHARE else GOOD)  # fmt: skip
        text.append(f" in {found.seconds:.0f} s\n")
        text.append(f"longest wait for one {found.longest_ms:.1f} ms, "
                    f"usual {found.period_ms:.1f} ms\n")  # fmt: skip
    else:
        text.append("No pictures yet\n", QUIET)
    if found.step_ms is None or found.step_longest_ms is None:
        text.append("No timesteps now", QUIET)
    else:
        text.append(f"a timestep every {found.step_ms:.1f} ms, longest {found.step_longest_ms:.1f}")
    if status.trial:
        skipped = status.trial.skipped
        text.append(f"\n{skipped} timesteps skipped", CAREFUL if skipped else QUIET)
    return text


def fits(status: Status) -> Text:
    """Return the fits, the newest first, with held-out likelihood, top-1 and gate."""
    if not status.fits:
        return Text("None yet", QUIET)
    text = Text()
    for fit in reversed(status.fits):
        bad = fit.state in ("failed", "timed out", "ends the session")
        text.append(f"{fit.artefact_id.replace(':', ' ')}  ", "bold")
        text.append(fit.state, CAREFUL if bad else "")
        if fit.gate:
            text.append("  gate ", QUIET).append(
                fit.gate, GOOD if fit.gate == "passed" else CAREFUL
            )
        text.append("\n")
        measured = []
        if fit.top1 is not None and fit.chance_top1 is not None:
            measured.append(f"top-1 {fit.top1:.2f}, chance {fit.chance_top1:.2f}")
        if fit.likelihood_gain is not None:
            measured.append(f"{fit.likelihood_gain:+.3f} nats a choice")
        if measured:
            text.append(f"  {'; '.join(measured)}\n")
        if fit.reason:
            text.append(f"  {fit.reason}\n", QUIET)
    # A line too many would be scrolled to.
    text.rstrip()
    return text


def remarks(listed: tuple[Remark, ...], left_out: int) -> Text:
    """Return deviations or notes, the newest first."""
    if not listed:
        return Text("None", QUIET)
    text = Text()
    for remark in reversed(listed):
        text.append(f"{clock(remark.t_s):>7}  ", QUIET)
        if remark.code:
            text.append(f"{remark.code.replace('_', ' ')}: ", CAREFUL)
        text.append(f"{remark.text}\n")
    if left_out:
        return text.append(f"and {left_out} before", QUIET)
    text.rstrip()
    return text


def _bar(done: int, of: int, width: int = 16) -> Text:
    full = round(width * min(1.0, done / of)) if of > 0 else 0
    return Text.assemble(("━" * full, "green"), ("─" * (width - full), QUIET))
