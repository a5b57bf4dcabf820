"""What a Gymnasium environment observes and shows, as rows of numbers and pictures."""

from __future__ import annotations

import math
import os
from typing import Any

import numpy as np
import numpy.typing as npt

from study.errors import StudyError
from study.events.task_description import StateField
from study.tasks._gymnasium_known import Known

Row = npt.NDArray[np.float32]

MOST_FIELDS = 1024
"""Of a state: it is recorded for every robot at every timestep."""
UNBOUNDED = 1e30
"""A range that reaches further says nothing: spaces give infinity or the largest float."""
SAMPLED_EPISODES = 10
SAMPLED_STEPS = 200


def state_fields(
    env_id: str,
    env: Any,  # noqa: ANN401
    settings: dict[str, Any],
    known: Known | None,
) -> tuple[StateField, ...]:
    from gymnasium.spaces import Discrete  # noqa: PLC0415 - an extra
    from gymnasium.spaces.utils import flatten_space  # noqa: PLC0415

    space = env.observation_space
    if isinstance(space, Discrete) and settings["discrete"] == "number":
        first = float(space.start)
        low, high = np.array([first]), np.array([first + float(space.n) - 1])
    else:
        try:
            flat: Any = flatten_space(space)
            low, high = np.ravel(flat.low).astype(float), np.ravel(flat.high).astype(float)
        except (NotImplementedError, AttributeError) as error:
            raise StudyError(
                f"the observations of {env_id} are {space}, which is no row of fixed length",
                "Take an environment whose observations have a fixed size, or wrap it into one.",
            ) from error
    if not 1 <= len(low) <= MOST_FIELDS:
        raise StudyError(
            f"an observation of {env_id} has {len(low)} numbers; at most {MOST_FIELDS} are taken",
            "Take one that observes a few numbers instead of pixels, or wrap it into one.",
        )
    bounded = (np.abs(low) < UNBOUNDED) & (np.abs(high) < UNBOUNDED)
    if not bounded.all():
        reached = _reached(env, settings["discrete"])
        low, high = np.where(bounded, low, reached[0]), np.where(bounded, high, reached[1])
    names = settings["state_names"]
    if names and len(names) != len(low):
        raise StudyError(
            f"task.parameters.state_names: {len(names)} names given; a state of {env_id} has "
            f"{len(low)} numbers",
            "Give one name a number, in order, or none.",
        )
    if not names and known is not None and len(known.fields) == len(low):
        names = known.fields
    if not names:
        word = "state" if isinstance(space, Discrete) and len(low) > 1 else "observation"
        names = tuple(f"{word} {place}" for place in range(len(low)))
    # A number that cannot vary must not divide by zero.
    high = np.where(high > low, high, low + 1.0)
    return tuple(
        StateField(name, "", float(least), float(most), bounded=bool(known_range))
        for name, least, most, known_range in zip(names, low, high, bounded, strict=True)
    )


def _reached(env: Any, discrete: str) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:  # noqa: ANN401
    """Return the range that play at random reaches, and a half more, of a fixed seed.

    To two digits, so that the last bit of a sum on another machine changes nothing.
    """
    random = np.random.default_rng(0)
    rows = []
    for episode in range(SAMPLED_EPISODES):
        observation, _ = env.reset(seed=episode)
        rows.append(row_of(env, observation, discrete))
        for _ in range(SAMPLED_STEPS):
            observation, _, terminated, truncated, _ = env.step(
                int(random.integers(env.action_space.n))
            )
            rows.append(row_of(env, observation, discrete))
            if terminated or truncated:
                break
    table = np.array(rows, float)
    low, high = table.min(axis=0), table.max(axis=0)
    more = (high - low) / 4
    return _two_digits(low - more), _two_digits(high + more)


def _two_digits(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    return np.array([float(f"{value:.2g}") for value in values])


def row_of(env: Any, observation: object, discrete: str) -> Row:  # noqa: ANN401
    """Return an observation as a row of numbers, float32 [d]."""
    from gymnasium.spaces import Discrete  # noqa: PLC0415 - an extra
    from gymnasium.spaces.utils import flatten  # noqa: PLC0415

    space = env.observation_space
    if isinstance(space, Discrete) and discrete == "number":
        return np.array([observation], np.float32)
    return np.asarray(flatten(space, observation), np.float32)


def picture_of(env: Any, widest: int) -> npt.NDArray[np.uint8]:  # noqa: ANN401
    """Return what an environment shows, at most ``widest`` pixels wide, uint8 [h, w, 3].

    Raises:
        StudyError: it cannot draw itself.
    """
    # Nothing is to open a window, or a sound card.
    os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
    os.environ.setdefault("SDL_AUDIODRIVER", "dummy")
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    try:
        drawn = np.asarray(env.render())
    except Exception as error:  # what foreign code raises is not known
        raise StudyError(
            f"{env.spec.id} cannot draw itself: {first_line(error)}",
            "See what the environment's page says must be installed to render it.",
        ) from error
    if drawn.ndim != 3 or drawn.shape[2] != 3 or drawn.dtype != np.uint8:
        raise StudyError(
            f"{env.spec.id} draws arrays of shape {drawn.shape} and type {drawn.dtype}",
            "A task needs pictures of height x width x 3 bytes.",
        )
    by = math.ceil(drawn.shape[1] / widest)
    if by == 1:
        return drawn
    height, width = drawn.shape[0] // by, drawn.shape[1] // by
    whole = drawn[: height * by, : width * by]
    # Slice by slice: seven times as quick as a sum over blocks.
    rows = np.zeros((height, *whole.shape[1:]), np.uint16)
    for row in range(by):
        rows += whole[row::by]
    total = np.zeros((height, width, 3), np.uint32)
    for column in range(by):
        total += rows[:, column::by]
    smaller: npt.NDArray[np.uint8] = (total // (by * by)).astype(np.uint8)
    return smaller


def first_line(error: Exception) -> str:
    """Return what an error says, in one line."""
    return (str(error).splitlines() or [type(error).__name__])[0]
