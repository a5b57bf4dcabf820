"""The synthetic user: a policy trained by soft actor-critic on a task's own reward.

It stands for the paper's simulated user ("Simulation Experiments"), who drives near the
optimum with a little noise, and whose value of a state is known. Its weights ship with the
program; `study train-user` makes them. Loading and acting import no torch.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from study.errors import StudyError
from study.perceptron import Perceptron, read_weights
from study.simulated.landmarks import Landmarks

FORMAT = 2
WEIGHTS = Path(__file__).parent / "users"
"""Where the weights are that ship with the program, one file a task."""

_NOT_HASHED = frozenset({"horizon"})
"""The user knows no clock: it drives in episodes of any length alike."""

Floats = npt.NDArray[np.float64]
States = npt.NDArray[np.float32]


def parameters_sha256(parameters: Mapping[str, object]) -> str:
    """Return the hash of a task's parameters that a user's weights are good for.

    Args:
        parameters: all of the task's, defaults filled in, as JSON would hold them: what
            ``Parameters.model_dump(mode="json")`` gives.
    """
    kept = {name: value for name, value in parameters.items() if name not in _NOT_HASHED}
    return hashlib.sha256(json.dumps(kept, sort_keys=True).encode()).hexdigest()


class TrainedUser:
    """A trained policy over the actions of a task; a `study.policies.base.Policy`.

    Attributes:
        made_of: what the weights say of themselves: task, parameters, seed, command, versions.
        discount: gamma, per timestep.
        sha256: of the weights' names, shapes and numbers.
        state_names: of the state's fields.
        keys: for each action the name of the key that does it; "" for none.

    Args:
        tensors: by name, as in the weights' file.
        made_of: as the file's metadata hold it.
        source: named in error messages.

    Raises:
        StudyError: they are no user's weights, or do not fit together.
    """

    def __init__(
        self, tensors: Mapping[str, npt.NDArray[Any]], made_of: Mapping[str, Any], source: str
    ) -> None:
        if made_of.get("format") != FORMAT:
            raise StudyError(
                f"{source}: no trained user's weights of format {FORMAT}",
                "Train the user anew with study train-user.",
            )
        try:
            self._landmarks = Landmarks.from_json(made_of["landmarks"])
            self.state_names = tuple(field.name for field in self._landmarks.fields)
            self.keys: tuple[str, ...] = tuple(map(str, made_of["keys"]))
            self.discount = float(made_of["discount"])
            if not 0.0 < self.discount < 1.0:
                raise ValueError("the discount is not between 0 and 1")
            inputs = self._landmarks.size
            self._actor = Perceptron.from_tensors(tensors, "actor", inputs, len(self.keys))
            self._values = Perceptron.from_tensors(tensors, "values", inputs, 1)
        except (KeyError, TypeError, ValueError) as error:
            raise StudyError(
                f"{source}: no weights of a trained user: {error}",
                "Train the user anew with study train-user.",
            ) from error
        self.made_of = dict(made_of)
        self.source = source
        self.sha256 = _tensors_sha256(tensors)

    @classmethod
    def shipped(cls, task_name: str, parameters: Mapping[str, object] | None = None) -> TrainedUser:
        """Return the user of a task that ships with the program.

        Args:
            task_name: as in a protocol.
            parameters: of the task, defaults filled in (see `parameters_sha256`); checked
                against those that the user was trained for, unless None.

        Raises:
            StudyError: no user of this task ships, its file is damaged, or it was trained
                for other parameters.
        """
        known = sorted(path.stem for path in WEIGHTS.glob("*.safetensors"))
        if task_name not in known:
            raise StudyError(
                f'no trained user of task "{task_name}" comes with the program',
                f"There are users of: {', '.join(known) or 'none'}. "
                "Train one with study train-user.",
            )
        return cls.load(WEIGHTS / f"{task_name}.safetensors", task_name, parameters)

    @classmethod
    def load(
        cls, path: Path, task_name: str, parameters: Mapping[str, object] | None = None
    ) -> TrainedUser:
        """Read a user's weights from a file; see `shipped`."""
        tensors, metadata = read_weights(path)
        try:
            made_of = json.loads(metadata.get("user", "{}"))
        except (ValueError, RecursionError):
            made_of = {}
        user = cls(tensors, made_of if isinstance(made_of, dict) else {}, str(path))
        if (task := user.made_of.get("task")) != task_name:
            raise StudyError(f'{path}: a user of task "{task}", not "{task_name}"')
        if parameters is not None:
            user.check_parameters(parameters)
        return user

    def check_parameters(self, parameters: Mapping[str, object]) -> None:
        """Check that the user was trained for a task's parameters; the horizon may differ.

        Raises:
            StudyError: it was trained for others; the message names those that differ.
        """
        if parameters_sha256(parameters) == self.made_of.get("parameters_sha256"):
            return
        trained = self.made_of.get("parameters", {})
        differing = [
            f"{name} is {json.dumps(parameters.get(name))}, "
            f"trained for {json.dumps(trained.get(name))}"
            for name in sorted({*trained, *parameters} - _NOT_HASHED)
            if parameters.get(name) != trained.get(name)
        ]
        raise StudyError(
            f"{self.source}: the user was trained for other parameters of the task: "
            f"{'; '.join(differing) or 'their hash differs'}",
            "Use the parameters it was trained for, or train one with study train-user.",
        )

    def probabilities(self, states: States) -> Floats:
        """Return the chance of each action in each of n states.

        Args:
            states: float32 [n, d].

        Returns:
            float64 [n, actions]; rows add up to 1.
        """
        logits = self._actor(self._landmarks.features(states))
        weights = np.exp(logits - logits.max(axis=-1, keepdims=True))
        chances: Floats = weights / weights.sum(axis=-1, keepdims=True)
        return chances

    def actions(self, states: States, random: np.random.Generator) -> npt.NDArray[np.int32]:
        """Draw an action for each of n states.

        Args:
            states: float32 [n, d].
            random: one number is drawn for each state.

        Returns:
            int32 [n].
        """
        upto = self.probabilities(states).cumsum(axis=-1)
        marks = random.random(len(states))[:, None] * upto[:, -1:]
        drawn: npt.NDArray[np.int32] = (marks >= upto[:, :-1]).sum(axis=-1).astype(np.int32)
        return drawn

    def values(self, states: States) -> Floats:
        """Return V of each of n states: the points that the user will still earn, discounted.

        Without the entropy that training rewards; by temporal differences, checked against
        rollouts (``made_of["values_r_squared"]``).

        Args:
            states: float32 [n, d].

        Returns:
            float64 [n], points.
        """
        return self._values(self._landmarks.features(states))[..., 0]


def _tensors_sha256(tensors: Mapping[str, npt.NDArray[Any]]) -> str:
    digest = hashlib.sha256()
    for name in sorted(tensors):
        digest.update(f"{name} {tensors[name].dtype} {tensors[name].shape}\n".encode())
        digest.update(np.ascontiguousarray(tensors[name]).tobytes())
    return digest.hexdigest()
