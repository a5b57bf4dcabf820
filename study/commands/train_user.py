"""`study train-user` and `study check-user`: the synthetic user, and how good it is."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from study.commands.terminal import console
from study.errors import StudyError
from study.loading import load_protocol
from study.seeding import stream_seed

if TYPE_CHECKING:
    from study.simulated.trained_user import TrainedUser
    from study.training.optimality import Comparison
    from study.training.user import Course

Protocol = Annotated[str, typer.Argument(help="Protocol file, or name of a shipped one.")]
Robots = Annotated[
    int, typer.Option(min=2, max=100_000, help="Paired episodes of the check, for each start.")
]
Cell = Annotated[
    float, typer.Option(min=0.1, max=0.6, help="Distance of the grid's places, metres.")
]


def train_user(
    protocol: Protocol = "scaled_autonomy",
    seed: Annotated[int, typer.Option(min=0, help="Seed of the training.")] = 1,
    updates: Annotated[
        int | None, typer.Option(min=1, max=10_000_000, help="Gradient steps; default: as shipped.")
    ] = None,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="File of the weights; must not exist.")
    ] = Path("user.safetensors"),
    *,
    check: Annotated[
        bool, typer.Option("--check/--no-check", help="Hold it against value iteration.")
    ] = True,
    robots: Robots = 2000,
    cell: Cell = 0.25,
) -> None:
    """Train a synthetic user on a protocol's task by discrete soft actor-critic."""
    from study.training.soft_actor_critic import ActorCriticParameters  # noqa: PLC0415
    from study.training.user import course_of, make_user  # noqa: PLC0415

    if output.exists():
        raise StudyError(f"{output} exists", "Give another file with --output.")
    loaded = load_protocol(protocol)
    course = course_of(loaded.protocol.task.name, loaded.protocol.task.parameters)
    training = ActorCriticParameters()
    if updates is not None:
        training = training.model_copy(update={"updates": updates})
    command = f"study train-user {protocol} --seed {seed} --updates {training.updates}"
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, TimeElapsedColumn(), console=console) as progress:
        bar = progress.add_task("Gradient steps", total=training.updates)

        def report(done: int, points: float, entropy: float) -> None:
            words = f"Gradient steps ({points:.1f} points an episode, entropy {entropy:.2f})"
            progress.update(bar, completed=done, description=words)

        made = make_user(course, training, seed, command, report)
        progress.update(bar, completed=training.updates, description="Gradient steps")
    output.parent.mkdir(parents=True, exist_ok=True)
    with output.open("xb") as file:
        file.write(made.weights)
    console.print(f"Weights in {escape(str(output))}")
    _print_made(made.user)
    if check:
        _check(course, made.user, stream_seed(seed, "check"), robots, cell)


def check_user(
    protocol: Protocol = "scaled_autonomy",
    weights: Annotated[
        Path | None, typer.Option(help="File of the weights; default: those that ship.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of starts, noise and actions.")] = 1,
    robots: Robots = 2000,
    cell: Cell = 0.25,
) -> None:
    """Hold a trained user against value iteration on a fine grid of the same task."""
    from study.simulated.trained_user import TrainedUser  # noqa: PLC0415
    from study.training.user import course_of  # noqa: PLC0415

    loaded = load_protocol(protocol)
    name = loaded.protocol.task.name
    course = course_of(name, loaded.protocol.task.parameters)
    if weights is None:
        user = TrainedUser.shipped(name, course.given())
    else:
        user = TrainedUser.load(weights, name, course.given())
    _print_made(user)
    _check(course, user, seed, robots, cell)


def _print_made(user: TrainedUser) -> None:
    made_of = user.made_of
    versions = ", ".join(f"{name} {number}" for name, number in made_of["versions"].items())
    console.print(f"Made by {escape(made_of['command'])} ({versions})")
    measured = made_of["values_measured"]
    console.print(
        f"R^2 of its values in {measured['states']} states, each measured by the mean of "
        f"{measured['rollouts']} rollouts: {float(made_of['values_r_squared']):.3f}",
        soft_wrap=True,
    )


def _check(course: Course, user: TrainedUser, seed: int, robots: int, cell: float) -> None:
    from study.training.optimality import compare, solved_policy  # noqa: PLC0415

    with console.status("Value iteration") as status:
        best = solved_policy(
            course,
            user,
            cell,
            lambda sweep, change: status.update(f"Value iteration, sweep {sweep}: {change:.2f}"),
        )
        status.update("Driving both")
        found = compare(course, user, best, user.discount, seed, robots)
    solved = best.solved
    size = solved.nodes.size
    console.print(f"Soft value iteration: {size:,} states, {solved.sweeps} sweeps, seed {seed}")
    console.print("Mean [95 % interval], paired by start and noise:")
    for comparison in found:
        _print_comparison(comparison)


def _print_comparison(comparison: Comparison) -> None:
    where = {"task": "the task's own starts", "anywhere": "starts anywhere on the map"}
    console.print(f"  {comparison.robots} episodes from {where[comparison.starts]}", markup=False)
    rows = (
        ("points", comparison.user, comparison.grid, comparison.difference),
        (
            "discounted",
            comparison.user_discounted,
            comparison.grid_discounted,
            comparison.difference_discounted,
        ),
    )
    for name, user, grid, difference in rows:
        console.print(
            f"    {name:10s}  user {user}   value iteration {grid}   difference {difference}",
            markup=False,
        )
    console.print(
        f"    {'at goal':10s}  user {comparison.user_goals:.1%}   "
        f"value iteration {comparison.grid_goals:.1%}",
        markup=False,
    )
