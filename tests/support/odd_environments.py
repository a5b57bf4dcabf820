"""Environments that Gymnasium does not come with: registered when this module is imported."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Discrete


class Counter(gymnasium.Env[Any, Any]):  # type: ignore[misc, unused-ignore]
    """Counts what it was told; its only picture is a grey that follows the count."""

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"]}  # noqa: RUF012 - as Gymnasium has it

    def __init__(
        self, render_mode: str | None = None, size: int = 2, actions: int = 5, colour: int = 3
    ) -> None:
        self.render_mode = render_mode
        self.observation_space = Box(-np.inf, np.inf, (size,), np.float32)
        self.action_space = Discrete(actions)
        self._colour = colour
        self._count = 0

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[Any, dict[str, Any]]:
        """Begin at 0."""
        super().reset(seed=seed)
        self._count = 0
        return self._observation(), {}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Add the action's number."""
        self._count += int(action)
        return self._observation(), float(action), self._count >= 40, self._count == 39, {}

    def _observation(self) -> Any:
        return np.full(self.observation_space.shape or (), self._count, np.float32)

    def render(self) -> Any:
        """Return the count as a grey."""
        if self._colour != 3:
            return np.zeros((4, 6, self._colour), np.uint8)
        return np.full((4, 6, 3), self._count, np.uint8)


class Arcade(Counter):
    """Names its actions as the arcade machine does."""

    def get_action_meanings(self) -> list[str]:
        """Return names by action number."""
        return ["NOOP", "FIRE", "UP", "RIGHT", "LEFT"]


class Words(Counter):
    """Draws words only."""

    metadata: dict[str, Any] = {"render_modes": ["ansi"]}  # noqa: RUF012 - as Gymnasium has it


gymnasium.register("Counter-v0", entry_point="odd_environments:Counter", max_episode_steps=30)
gymnasium.register("Arcade-v0", entry_point="odd_environments:Arcade")
gymnasium.register("Words-v0", entry_point="odd_environments:Words")
