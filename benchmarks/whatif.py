"""How long what-if takes over a study's recordings, against asking about one choice at a time.

    python -m benchmarks.whatif [--sessions 12] [--minutes 30] [--keep FOLDER]

Sessions are made up: participants choose by scorers that are known, at 8 timesteps a second, in
the fleet runs of a study with people. `study whatif` runs as a process of its own, from the start
of Python to the last table: each participant's own scorer, two controls, and the matrix of all
scorers over all participants. The naive way asks the same scorers about the same choices in a
loop; it is timed on the choices of one participant, and what the rest would take is in proportion.
Regret is timed apart. Fails where the command takes longer than the target on two cores.
"""

from __future__ import annotations

import argparse
import math
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.made_up_sessions import machine
from benchmarks.made_up_studies import write_sessions
from study.commands.whatif import open_sessions
from study.whatif.named_scorers import Asked, asked_scorers, own_scorer
from study.whatif.sessions import ChoiceSession

ROOT = Path(__file__).resolve().parents[1]

TARGET_S = 10.0
"""For twelve half-hour sessions, regret apart."""
SCORERS = ("own", "stuck_longest", "lowest_health")


def main() -> int:
    """Measure and print; 1 if the target is missed."""
    parser = argparse.ArgumentParser(description="Seconds of study whatif.")
    parser.add_argument("--sessions", type=int, default=12, help="number of sessions")
    parser.add_argument("--minutes", type=float, default=30.0, help="length of a session")
    parser.add_argument("--keep", type=Path, help="folder in which the recordings stay")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = given.keep or Path(temporary) / "recordings"
        files = write_sessions(folder, given.sessions, given.minutes, "choosing")
        print(machine())
        spent, busy = command(files, Path(temporary) / "tables", 0)
        with_regret, _ = command(files, Path(temporary) / "regret", 50)
        sessions = open_sessions(files)
        choices = [sum(len(run.chosen) for run in each.runs) for each in sessions]
        one_by_one = naive(sessions)
    loop = one_by_one * sum(choices) / choices[0]
    print(
        f"{given.sessions} sessions of {given.minutes:g} minutes, {sum(choices)} choices, "
        f"{len(SCORERS)} scorers and a matrix of {given.sessions} by {given.sessions}"
    )
    print(
        f"study whatif          {spent:7.1f} s, from the start of Python to the last table "
        f"({busy:.1f} s of a processor)"
    )
    print(
        f"one choice at a time  {loop:7.1f} s for the scores alone ({one_by_one:.1f} s measured "
        f"on {choices[0]} choices): {loop / spent:.0f} times as long"
    )
    print(f"regret, 50 choices of each participant: {with_regret - spent:.1f} s more")
    allowed = TARGET_S * given.sessions / 12 * given.minutes / 30
    print(f"target: {allowed:.1f} s")
    return 1 if spent > allowed else 0


def command(files: list[Path], output: Path, regret: int) -> tuple[float, float]:
    """Run the command in a process of its own; return its seconds, and those of a processor."""
    asked = [part for name in SCORERS for part in ("--scorer", name)]
    options = ["-o", str(output), "--regret-choices", str(regret), *asked]
    line = [sys.executable, "-m", "study.commands.main", "whatif", *map(str, files), *options]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    start = time.perf_counter()
    done = subprocess.run(line, cwd=ROOT, capture_output=True, text=True, check=False)
    seconds = time.perf_counter() - start
    if done.returncode:
        raise SystemExit(done.stderr)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    busy = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return seconds, busy


def naive(sessions: list[ChoiceSession]) -> float:
    """Ask about the first participant's choices one by one; return the seconds it takes."""
    session = sessions[0]
    (mine,) = asked_scorers(SCORERS, [session], 0, print)
    owners = [own_scorer(each, print) for each in sessions]
    asked: list[Asked] = [*mine, *(owner for owner in owners if owner is not None)]
    start = time.perf_counter()
    for one in asked:
        for run in session.runs:
            begin = getattr(one.scorer, "begin", None)
            if begin is not None:
                begin(run.states.shape[1], 0)
            chosen = dict(zip(run.rows.tolist(), run.chosen.tolist(), strict=True))
            # A scorer that remembers has to see the timesteps without a choice too.
            for row in range(len(run.states)) if begin is not None else chosen:
                scores = one.scorer.scores(run.states[row])
                if row in chosen:
                    _judged(scores, run.available[row], chosen[row])
    return time.perf_counter() - start


def _judged(scores: np.ndarray, available: np.ndarray, chosen: int) -> tuple[int, int, float]:
    """Return the scorer's first robot, the rank of the one chosen and its log-likelihood."""
    known = [(float(scores[i]), -i) for i in range(len(scores)) if available[i]]
    mine = float(scores[chosen])
    top = max(known)
    total = sum(math.exp(value - top[0]) for value, _ in known)
    rank = 1 + sum(value > mine for value, _ in known)
    return -top[1], rank, mine - top[0] - math.log(total)


if __name__ == "__main__":
    sys.exit(main())
