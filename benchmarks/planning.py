"""Planning: made-up studies tested many at once, against a loop over the report's own functions.

    python -m benchmarks.planning [--studies 10000] [--jobs 2] [--naive 200]

Each study is made up trial by trial and goes to the primary test of participants' means. The fast
path is that of `study plan`, from the start of its workers to the last power. The loop makes a
table of each study, averages its cells and calls `rm_anova`, as an analyst's script would; so many
studies are measured and scaled up to one process. Both must say the same of the same studies, p by
p. Fails where they do not, or where the fast path misses its target on two cores.
"""

from __future__ import annotations

import argparse
import os
import platform
import sys
import time

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
import scipy

from analysis.planning.assumptions import Assumptions, Design
from analysis.planning.closed_form import closed_form
from analysis.planning.made_up import BLOCK, level_names, make_up
from analysis.planning.power import run_here, run_piece, simulate
from analysis.planning.testing import analyse_many
from analysis.statistics.cells import cell_means
from analysis.statistics.result import EffectResult
from analysis.statistics.rm_anova import rm_anova
from benchmarks.simulated_designs import EFFECT, EFFECT_SD, LEVEL_SD, PEOPLE, TRIAL_SD, TRIALS
from study.workers import run_pieces

TARGET_S = 60.0
"""For 10,000 studies on two cores."""
GIVEN = Assumptions(
    (0.0, EFFECT), EFFECT_SD, TRIAL_SD, ((0, 1), (1, 0)), level_sd=LEVEL_SD, learning=0.7
)
SIZE = Design(PEOPLE, TRIALS)


def main() -> int:
    """Measure and print; 1 if a result differs or the target is missed."""
    parser = argparse.ArgumentParser(description="Seconds to plan by simulation.")
    parser.add_argument("--studies", type=int, default=10_000)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--naive", type=int, default=200, help="studies of the loop")
    given = parser.parse_args()
    began = time.perf_counter()
    (cell,) = simulate(
        [(GIVEN, SIZE)],
        lambda pieces: run_pieces(run_piece, [(each,) for each in pieces], jobs=given.jobs),
        studies=given.studies,
        model_studies=given.studies,
        seed=1,
        stream="benchmark",
    )
    fast = time.perf_counter() - began
    began = time.perf_counter()
    sizes = {"studies": given.studies, "model_studies": given.studies, "seed": 1}
    (again,) = simulate([(GIVEN, SIZE)], run_here, **sizes, stream="benchmark")
    alone = time.perf_counter() - began
    assert again == cell
    loop, differs = naive(given.naive)
    loop *= cell.counts.studies / given.naive
    formula = closed_form(GIVEN, SIZE)
    print(f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}, "
          f"NumPy {np.__version__}, SciPy {scipy.__version__}")  # fmt: skip
    print(f"{cell.counts.studies} studies of {PEOPLE} participants, 2 x {TRIALS} trials")
    print(f"study plan, {given.jobs} processes: {fast:8.2f} s, their start and imports included")
    print(f"the same here, one process: {alone:8.2f} s, with all imported")
    print(f"a study at a time:          {loop:8.2f} s here ({given.naive} studies measured): "
          f"{loop / alone:.0f} times as long")  # fmt: skip
    print(f"power {cell.power:.4f} [{cell.interval.low:.4f}, {cell.interval.high:.4f}], "
          f"closed form {formula.power if formula else float('nan'):.4f}")  # fmt: skip
    print(f"largest difference of p between both: {differs:.1e}")
    allowed = TARGET_S * max(1.0, cell.counts.studies / 10_000)
    print(f"target: {allowed:.0f} s")
    return 1 if differs > 1e-9 or fast > allowed else 0


def naive(studies: int) -> tuple[float, float]:
    """Loop over studies; return seconds and the largest difference of p from the fast path."""
    made = [make_up(GIVEN, SIZE, 1, "loop", block) for block in range(-(-studies // BLOCK))]
    fast = np.concatenate([analyse_many(each).p for each in made])
    levels = level_names(2)
    seconds, differs = 0.0, 0.0
    for study in range(studies):
        began = time.perf_counter()
        frame = made[study // BLOCK].frame(study % BLOCK)
        outcome = rm_anova(cell_means(frame, "team_reward", levels))
        seconds += time.perf_counter() - began
        assert isinstance(outcome, EffectResult)
        differs = max(differs, abs(outcome.p - float(fast[study])))
    return seconds, differs


if __name__ == "__main__":
    sys.exit(main())
