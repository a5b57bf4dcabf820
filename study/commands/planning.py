"""What `study plan` is made of: a protocol's part in it, a pilot, workers, a table to look at."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from rich.markup import escape
from rich.table import Table

from analysis.formatting import number
from analysis.planning.assumptions import Assumptions, Design, check_grid
from analysis.planning.pilot import Pilot, pilot_of
from analysis.planning.plan import Plan, Wanted, default_participants, grid
from analysis.planning.power import Counts, Piece, run_piece
from analysis.planning.stated import PlannedStudy
from study.commands.clearing import clear_simulated
from study.commands.progress import followed
from study.commands.simulate import simulate_with_progress
from study.commands.terminal import errors
from study.errors import StudyError
from study.loading import LoadedProtocol
from study.orders import possible_orders
from study.simulated.parameters import Driver
from study.workers import run_pieces

STAGES = {"grid": "Sizes", "check": "The size named, afresh", "variation": "If it is otherwise"}
MOST_DESIGNS = 400


def planned_study(loaded: LoadedProtocol) -> PlannedStudy:
    """Return what a plan takes from a protocol."""
    protocol = loaded.protocol
    # The reference is what the report takes for it: the participant's own choice, if there is one.
    conditions = sorted(protocol.conditions, key=lambda each: each.allocation != "manual")
    names = [condition.name for condition in conditions]
    orders = possible_orders(
        [condition.name for condition in protocol.conditions], protocol.phase_three.order
    )
    whole = len(names) * protocol.phase_three.trials
    rules = [rule for rule in protocol.exclusions if rule.measure == "complete_trials"]
    return PlannedStudy(
        title=protocol.study.title,
        sha256=loaded.sha256,
        levels=tuple(names),
        labels=tuple(condition.label for condition in conditions),
        orders=tuple(tuple(names.index(name) for name in order) for order in orders),
        participants=protocol.study.planned_participants,
        trials=protocol.phase_three.trials,
        trial_seconds=protocol.phase_three.trial_timesteps / protocol.timing.timesteps_per_second,
        needed=min(1.0, max((rule.at_least for rule in rules), default=0.0) / whole),
        bound=protocol.analysis.equivalence_bound,
        other_rules=tuple(rule.name for rule in protocol.exclusions if rule not in rules),
    )


def find_pilot(
    loaded: LoadedProtocol,
    recordings: list[Path],
    sessions: int,
    folder: Path,
    *,
    seed: int,
    jobs: int,
    driver: Driver,
    stated: Sequence[str],
    pool: bool,
) -> Pilot | None:
    """Return what a pilot estimates: of recordings, or simulated now; None for no pilot.

    Raises:
        StudyError: both are asked for, or the recordings tell too little.
    """
    if recordings and sessions:
        raise StudyError("--from and --sessions are both given", "Give one of them.")
    if sessions:
        clear_simulated(folder, "Give another folder with --output")
        recordings = simulate_with_progress(
            str(loaded.path), sessions, seed, folder, jobs, driver, stated
        )
    elif stated:
        raise StudyError("--set is about simulated participants", "Give --sessions too.")
    if not recordings:
        return None
    with errors.status("Reading the pilot"):
        return pilot_of(recordings, pool=pool)


def given_grid(
    study: PlannedStudy, participants: str, trials: str
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Read numbers of participants, none if none are given, and of trials a condition.

    Raises:
        StudyError: a number cannot be read, or is none that a study can have.
    """
    own = study.trials
    each = whole_numbers("--trials", trials) or tuple(sorted({max(1, own // 2), own, 2 * own}))
    people = whole_numbers("--participants", participants)
    designs = grid(people or (3,), each)
    check_grid(designs)
    if len(designs) > MOST_DESIGNS:
        raise StudyError(f"a grid of {len(designs)} sizes", f"Give at most {MOST_DESIGNS} of them.")
    return people, each


def wanted_of(
    study: PlannedStudy,
    assumptions: Assumptions,
    sizes: tuple[tuple[int, ...], tuple[int, ...]],
    *,
    power: float,
    studies: int,
    model_studies: int,
    seed: int,
) -> Wanted:
    """Return what is asked for, with a grid about what the closed form names if none is given."""
    people, each = sizes
    step = 0
    if not people:
        step = len(study.orders)
        people = default_participants(assumptions, each, power)
        if study.participants >= 3:
            people = (*people, study.participants)
    return Wanted(grid(people, each), power, studies, model_studies, seed, step)


def whole_numbers(option: str, text: str) -> tuple[int, ...]:
    """Read numbers between commas.

    Raises:
        StudyError: something else is among them.
    """
    if not text.strip():
        return ()
    try:
        return tuple(int(part) for part in text.split(","))
    except ValueError as error:
        raise StudyError(
            f"{option} {text}: whole numbers are expected", f"Write {option} 8,12,16."
        ) from error


class Workers:
    """Runs pieces of a plan on all cores or a cluster, and shows how far they are.

    Args:
        jobs: processes at once; -1 for one a core.
        scheduler: address of a Dask scheduler to use instead.
    """

    def __init__(self, jobs: int, scheduler: str) -> None:
        self._jobs = jobs
        self._scheduler = scheduler

    def __call__(self, pieces: Sequence[Piece]) -> Iterable[tuple[int, int, Counts]]:
        """Run pieces, in any order."""
        if not pieces:
            return
        calls = [(piece,) for piece in pieces]
        finished = run_pieces(run_piece, calls, jobs=self._jobs, scheduler=self._scheduler)
        what = STAGES[pieces[0].stream]
        # On standard error: what is printed on the other is the plan alone.
        yield from followed(what, finished, len(pieces), on=errors, transient=True)


def power_table(plan: Plan) -> Table:
    """Return the power of each size, a row for each number of participants."""
    trials = sorted({cell.design.trials for cell in plan.cells})
    table = Table(
        title="Power [95 % Monte-Carlo interval], by participants and trials a condition; "
        "dim: closed form"
    )
    table.add_column("participants", justify="right")
    for each in trials:
        table.add_column(f"{each} trial{'' if each == 1 else 's'}", justify="right")
    cells = {cell.design: cell for cell in plan.cells}
    for people in sorted({design.participants for design in cells}):
        row = [str(people)]
        for each in trials:
            cell = cells[Design(people, each)]
            low, high = number(cell.interval.low), number(cell.interval.high)
            text = escape(f"{number(cell.power)} [{low}, {high}]")
            formula = "" if cell.formula is None else f"  [dim]{number(cell.formula.power)}[/]"
            named = plan.chosen is not None and plan.chosen.design == cell.design
            row.append(f"[bold]{text}[/]{formula} *" if named else f"{text}{formula}  ")
        table.add_row(*row)
    return table
