"""What the console's panels say, as text with colours; alarms are words too, never colour alone."""

from __future__ import annotations

from rich.table import Table
from rich.text import Text

from study.console.wire import Remark, Status

UNSAVED_LIMIT_S = 1.0
"""From which age of an unsaved record on the recording is shown red."""
SILENCE_LIMIT_S = 1.0
"""How long a session may say nothing before that is shown red."""
LATE_SHARE = 0.01
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


def headline(status: Status, silence_s: float) -> Text:
    """Return who is in the session, and how it stands."""
    facts = status.facts
    text = Text.assemble(
        (f" {facts.participant} ", "bold reverse"), f"  {facts.study}  ",
        ("order ", QUIET), " then ".join(facts.order), "  ",
        (clock(status.t_s + silence_s), "bold"), ("  since the start", QUIET), "\n",
    )  # fmt: skip
    return text.append_text(state(status, silence_s))


def state(status: Status, silence_s: float) -> Text:
    """Return one line on whether it goes on."""
    if silence_s > SILENCE_LIMIT_S:
        return Text(f" NO WORD FROM THE SESSION FOR {silence_s:.0f} s ", BAD)
    still = clock(status.still_s + silence_s)
    why = _WHY.get(status.why, status.why)
    if status.state == "running":
        return Text(" RUNNING ", "bold black on green")
    if status.state == "held":
        also = "" if status.why == "experimenter" else f"; before that, {why}"
        text = Text(f" PAUSED BY THE EXPERIMENTER, {still} ", "bold black on yellow")
        return text.append(f"  R resumes{also}", "default")
    if status.state == "paused":
        text = Text(f" PAUSED, {still} ", "bold black on yellow")
        return text.append(f"  {why}; the participant goes on", "default")
    return Text(" ENDED ", "bold reverse")


def now(status: Status) -> Text:
    """Return stage, phase, condition and trial."""
    place = status.place
    text = Text()
    text.append(f"Stage {place.number} of {place.stages}", "bold")
    text.append(f"  {_bar(place.number, place.stages)}\n")
    phase = PHASES[place.phase] if 0 <= place.phase < len(PHASES) else f"phase {place.phase}"
    text.append(f"{place.kind}: {place.name.replace('_', ' ')}\n")
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
    text.append(f"Timestep {trial.timestep} of {trial.timesteps}", "bold")
    return text.append(f"  {_bar(trial.timestep, trial.timesteps)}")


def recording(status: Status, silence_s: float) -> Text:
    """Return the age of what is not yet on disk; red above a second."""
    disk = status.disk
    # What a session that says nothing has written meanwhile is not known.
    age = disk.unsaved_s + (silence_s if silence_s > SILENCE_LIMIT_S else 0.0)
    late = age > UNSAVED_LIMIT_S
    text = Text()
    if late:
        text.append(f" NOT ON DISK FOR {age:.1f} s ", BAD)
    else:
        text.append(f"{age:.1f} s", GOOD).append(" is the oldest that is not on disk")
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


def fits(status: Status) -> Table | Text:
    """Return the fits with held-out likelihood, top-1 and gate."""
    if not status.fits:
        return Text("None yet", QUIET)
    table = Table(box=None, padding=(0, 1, 0, 0), expand=True, header_style=QUIET)
    table.add_column("fit", overflow="fold")
    table.add_column("log-lik. gain", justify="right")
    table.add_column("top-1 (chance)", justify="right")
    table.add_column("gate")
    table.add_column("now", overflow="fold")
    for fit in status.fits:
        gain = "" if fit.likelihood_gain is None else f"{fit.likelihood_gain:+.3f}"
        top1 = "" if fit.top1 is None else f"{fit.top1:.2f}"
        if fit.top1 is not None and fit.chance_top1 is not None:
            top1 += f" ({fit.chance_top1:.2f})"
        gate = Text(fit.gate, GOOD if fit.gate == "passed" else CAREFUL)
        bad = fit.state in ("failed", "timed out")
        table.add_row(Text(fit.artefact_id), gain, top1, gate, Text(fit.state, BAD if bad else ""))
        if fit.reason:
            table.add_row(Text(fit.reason, QUIET))
    return table


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
    return text.append(f"and {left_out} before", QUIET) if left_out else text


def _bar(done: int, of: int, width: int = 16) -> Text:
    full = round(width * min(1.0, done / of)) if of > 0 else 0
    return Text.assemble(("━" * full, "green"), ("─" * (width - full), QUIET))
