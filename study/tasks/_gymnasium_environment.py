"""One Gymnasium environment: made, checked, and described as a task."""

from __future__ import annotations

import dataclasses
import difflib
import functools
import json
import re
import warnings
from collections.abc import Iterator, Mapping
from typing import Any

from study.errors import ProtocolError, StudyError
from study.events.scene import Scene
from study.events.task_description import TaskDescription
from study.tasks._gymnasium_known import KNOWN, NOTHING, WAIT, Known, Termination, default_keys
from study.tasks._gymnasium_spaces import first_line, state_fields

NOT_INSTALLED = StudyError(
    "tasks of Gymnasium need the package gymnasium, which is not installed",
    'Install the extra "gymnasium": pip install "scaled-autonomy[gymnasium]", in a clone '
    "pip install -e '.[gymnasium]'.",
)
USUAL_HORIZON = 200
MOST_ACTIONS = 64
KEY = re.compile(r"left|right|up|down|space|[a-z]")


@dataclasses.dataclass(frozen=True, slots=True)
class Resolved:
    """An environment with all that a protocol, or what is known of it, says.

    Attributes:
        description: of the task.
        without_key: the environment's action for the task's idle action; -1 if it is not stepped.
        termination: what it means that the environment ends an episode.
    """

    description: TaskDescription
    without_key: int
    termination: Termination


def make_environment(env_id: str, options: Mapping[str, Any]) -> Any:  # noqa: ANN401 - an extra
    """Make an environment that draws pictures; it does not end episodes by their length.

    Raises:
        StudyError: it is not registered, cannot be made, or draws no pictures.
    """
    gymnasium = check_registered(env_id)
    try:
        with warnings.catch_warnings():
            # It warns of modes that are not there, and then goes on.
            warnings.simplefilter("ignore")
            env = gymnasium.make(
                env_id, render_mode="rgb_array", max_episode_steps=-1,
                disable_env_checker=True, **options,
            )  # fmt: skip
    except Exception as error:  # what foreign code raises is not known
        raise StudyError(
            f"{env_id} cannot be made: {first_line(error)}",
            "See task.parameters.options, and what the environment's page says must be installed.",
        ) from error
    modes = env.metadata.get("render_modes") or ()
    if "rgb_array" not in modes:
        env.close()
        raise StudyError(
            f"{env_id} draws no pictures: it has no render mode rgb_array, only "
            f"{', '.join(modes) or 'none'}",
            "Take an environment that has one: participants see nothing else of it.",
        )
    return env


def check_registered(env_id: str) -> Any:  # noqa: ANN401 - an extra
    """Return Gymnasium, if an environment is registered by that id.

    Raises:
        StudyError: it is not installed, or there is no such environment; the nearest are named.
    """
    try:
        import gymnasium  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise NOT_INSTALLED from error
    if not env_id:
        raise StudyError(
            'the task "gymnasium:" names no environment',
            "Write its id after the colon, as in gymnasium:CartPole-v1.",
        )
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            module, _, name = env_id.rpartition(":")
            if module:
                __import__(module)
            gymnasium.spec(name)
    except ImportError as error:
        raise StudyError(
            f"{env_id}: the module {module} that is to register it cannot be imported: {error}",
            "Install the package that the environment comes with.",
        ) from error
    except gymnasium.error.Error as error:
        near = difflib.get_close_matches(name, list(gymnasium.registry), n=3, cutoff=0.5)
        raise StudyError(
            f'no environment "{name}" is registered with Gymnasium',
            f"Did you mean {', '.join(near)}?"
            if near
            else "Of a package of its own, write the module that registers it before the id, as in "
            "gymnasium:ale_py:ALE/Pong-v5.",
        ) from error
    return gymnasium


def known_of(env_id: str) -> Known | None:
    """Return what is known of one of Gymnasium's own environments, by its name."""
    return KNOWN.get(env_id.rpartition("-v")[0])


@functools.lru_cache(maxsize=8)
def resolve(name: str, env_id: str, settings_json: str) -> Resolved:
    """Describe an environment as a task.

    Args:
        name: of the task.
        env_id: of the environment.
        settings_json: a task's `study.tasks.gymnasium.Parameters`, as JSON.

    Raises:
        StudyError: it cannot be a task, or something must be said that nobody knows.
        ProtocolError: more than one thing is wrong.
    """
    settings: dict[str, Any] = json.loads(settings_json)
    env = make_environment(env_id, settings["options"])
    try:
        actions = _action_count(env_id, env)
        known = known_of(env_id)
        if known is not None and len(known.actions) != actions:
            known = None
        termination = settings["termination"] or (known.termination if known else None)
        names = _action_names(env, settings["action_names"], known, actions)
        wrong = [
            *_no_termination(env_id, termination),
            *_wrong_actions(env_id, settings, names, actions),
        ]
        try:
            fields = state_fields(env_id, env, settings, known)
        except StudyError as error:
            wrong.append(error)
        if wrong[1:]:
            problems = [f"{error.sentence}" for error in wrong]
            raise ProtocolError(env_id, problems)
        if wrong or termination is None:
            raise wrong[0]
        without_key = _without_key(settings["without_key"], known, names)
        keys = _keys(settings["keys"], known, names, without_key)
        idle = without_key
        if without_key < 0 or without_key in keys.values():
            # Nothing pressed is no demonstration, even where it does what a key does.
            names = (*names, WAIT if without_key < 0 else "no key")
            idle = actions
        aspect = settings["aspect"] or (known.aspect if known else 4 / 3)
        description = TaskDescription(
            name=name,
            version=1,
            state_fields=fields,
            x_field=-1,
            y_field=-1,
            heading_field=-1,
            health_field=-1,
            action_names=names,
            idle_action=idle,
            key_actions=keys,
            horizon=settings["horizon"] or _own_horizon(env),
            rewards=(),
            scene=Scene(
                width=10.0 * aspect, height=10.0, rectangles=(), discs=(), plate=None,
                robot_radius=0.35, camera=True,
            ),
            map_grid=None,
            resimulable="no" if env.spec.nondeterministic else "exact",
            instruction=settings["instruction"] or (known.instruction if known else ""),
        )  # fmt: skip
        return Resolved(description, without_key, termination)
    finally:
        env.close()


def _action_count(env_id: str, env: Any) -> int:  # noqa: ANN401
    from gymnasium.spaces import Discrete  # noqa: PLC0415 - an extra

    space = env.action_space
    if not isinstance(space, Discrete) or int(space.start) != 0:
        raise StudyError(
            f"the actions of {env_id} are {space}, which keys cannot stand for",
            "Take an environment whose actions are Discrete(n), or wrap it into one.",
        )
    if not 1 <= int(space.n) <= MOST_ACTIONS:
        raise StudyError(f"{env_id} has {space.n} actions", f"At most {MOST_ACTIONS} can be taken.")
    return int(space.n)


def _no_termination(env_id: str, termination: Termination | None) -> Iterator[StudyError]:
    if termination is None:
        yield StudyError(
            f"{env_id} does not say what it means that it ends an episode",
            'Give task.parameters.termination: "goal", "lost", or "goal_if_rewarded" (a goal '
            "if the last reward is positive).",
        )


def _wrong_actions(
    env_id: str, settings: Mapping[str, Any], names: tuple[str, ...], actions: int
) -> Iterator[StudyError]:
    """Say which settings are about actions that the environment does not have, and which keys."""
    there = f"{env_id} has actions 0 to {actions - 1}"
    if len(names) != actions:
        yield StudyError(
            f"task.parameters.action_names: {len(names)} names given; {env_id} has {actions} "
            "actions",
            "Give one name an action, in the order of their numbers, or none.",
        )
    held = settings["without_key"]
    if isinstance(held, int) and not 0 <= held < actions:
        yield StudyError(
            f"task.parameters.without_key: {held} given; {there}",
            'Give one of them, or "wait": the environment is not stepped while no key is held.',
        )
    for key, action in settings["keys"].items():
        if not KEY.fullmatch(key):
            yield StudyError(
                f'task.parameters.keys: "{key}" given',
                "Keys are left, right, up, down, space and the letters a to z.",
            )
        if not 0 <= action < actions:
            yield StudyError(
                f"task.parameters.keys.{key}: {action} given; {there}",
                f"They are: {', '.join(f'{n} {name}' for n, name in enumerate(names))}."
                if len(names) == actions
                else "Give one of them.",
            )


def _action_names(
    env: Any,  # noqa: ANN401
    given: list[str],
    known: Known | None,
    actions: int,
) -> tuple[str, ...]:
    if given or known:
        return tuple(given) or (known.actions if known else ())
    meanings = getattr(env.unwrapped, "get_action_meanings", None)
    meant = tuple(str(word) for word in meanings()) if meanings else ()
    return meant if len(meant) == actions else tuple(f"action {n}" for n in range(actions))


def _without_key(given: int | str | None, known: Known | None, names: tuple[str, ...]) -> int:
    """Return what is done while no key is held; -1: the environment is not stepped."""
    if given is None:
        return known.without_key if known else names.index(NOTHING) if NOTHING in names else -1
    return -1 if given == WAIT else int(given)


def _keys(
    given: dict[str, int], known: Known | None, names: tuple[str, ...], without_key: int
) -> dict[str, int]:
    if not given:
        return dict(known.keys) if known else default_keys(names, without_key)
    return dict(given)


def _own_horizon(env: Any) -> int:  # noqa: ANN401
    import gymnasium  # noqa: PLC0415 - an extra

    # It was made without an end by length: what it is registered with says it.
    own = gymnasium.spec(env.spec.id).max_episode_steps
    return int(own) if own else USUAL_HORIZON
