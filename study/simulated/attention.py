"""What an operator notices of a fleet, remembers, and makes of it."""

from __future__ import annotations

import math

import numpy as np

from study.screens import FleetScreen, Tile
from study.simulated.driving import effort_to_go
from study.simulated.parameters import OperatorParameters
from study.simulated.ways import Way

_HAZARD_REACH_M = 1.5
_WARNINGS = frozenset({"damage", "stuck", "low"})


class Impression:
    """What is remembered of one robot.

    Attributes:
        seen_ns: session time at which it was last looked at.
        episode: number of its episode then.
        effort: metres to go, turning included.
        best_effort: the least seen in this episode.
        progress_ns: session time at which ``best_effort`` was last improved.
        need: how badly it needs help, 0 not at all, 1 urgently.
        unavailable: whether choosing it was tried and did nothing.
    """

    __slots__ = (
        "best_effort",
        "effort",
        "episode",
        "need",
        "progress_ns",
        "seen_ns",
        "unavailable",
    )

    def __init__(self, episode: int, effort: float, now_ns: int) -> None:
        self.seen_ns = now_ns
        self.episode = episode
        self.effort = effort
        self.best_effort = effort
        self.progress_ns = now_ns
        self.need = 0.0
        self.unavailable = False

    def take_over(self, now_ns: int) -> None:
        """Judge progress afresh: from now on it is one's own."""
        self.best_effort = self.effort
        self.progress_ns = now_ns


class Memory:
    """Impressions of the robots of one fleet run."""

    def __init__(self, parameters: OperatorParameters, robots: int) -> None:
        self._parameters = parameters
        self.impressions: list[Impression | None] = [None] * robots

    def look(self, plan: Way, tile: Tile, now_ns: int) -> Impression:
        """Look at a tile: remember and appraise what it shows.

        Args:
            plan: where robots are to go.
            tile: the robot as shown.
            now_ns: session time.

        Returns:
            The robot's impression, brought up to date.
        """
        impression = self.impressions[tile.robot]
        known = impression is not None and impression.episode == tile.episode
        near = impression.effort if impression is not None and known else None
        effort = effort_to_go(plan, tile, self._parameters, near)
        if impression is None or impression.episode != tile.episode:
            impression = Impression(tile.episode, effort, now_ns)
            self.impressions[tile.robot] = impression
        elif effort < impression.best_effort - self._parameters.forward_step_m:
            impression.best_effort = effort
            impression.progress_ns = now_ns
        impression.seen_ns = now_ns
        impression.effort = effort
        impression.need = self._need(plan, tile, impression, now_ns)
        return impression

    def need(self, robot: int, now_ns: int) -> float:
        """Return the need remembered of a robot; it fades towards that of an unknown one."""
        impression = self.impressions[robot]
        unknown = self._parameters.unknown_need
        if impression is None:
            return unknown
        age_s = (now_ns - impression.seen_ns) * 1e-9
        confidence = math.exp(-age_s / self._parameters.memory_span_s)
        return unknown + confidence * (impression.need - unknown)

    def _need(self, plan: Way, tile: Tile, impression: Impression, now_ns: int) -> float:
        """Appraise a robot from what has been seen of it."""
        kind = tile.cue.kind if tile.cue is not None else ""
        if kind in {"goal", "lost"}:
            return 0.0
        parameters = self._parameters
        worn = 1.0 - tile.health / 100.0
        if plan.in_hazard(tile.x, tile.y) or kind == "damage":
            danger = 1.0
        elif plan.hazard_ahead(tile.x, tile.y, tile.heading, _HAZARD_REACH_M):
            danger = 0.5
        else:
            danger = 0.0
        idle_s = (now_ns - impression.progress_ns) * 1e-9
        stuck = 1.0 if kind == "stuck" else min(1.0, idle_s / parameters.stuck_patience_s)
        far = min(1.0, impression.effort / plan.longest) if plan.longest > 0.0 else 0.0
        return (
            parameters.weight_hazard * danger * (0.5 + 0.5 * worn)
            + parameters.weight_stuck * stuck
            + parameters.weight_health * worn
            + parameters.weight_far * far
        )


class Glances:
    """Decides when an operator looks away from the driven robot, and at which tiles."""

    def __init__(self, parameters: OperatorParameters, random: np.random.Generator) -> None:
        self._parameters = parameters
        self._random = random
        self._next_ns = 0
        self._looked_ns: list[int] = []

    def begin(self, robots: int, now_ns: int) -> None:
        """Start on a fleet run."""
        self._looked_ns = [-1] * robots
        self._next_ns = now_ns

    def postpone(self, until_ns: int) -> None:
        """Look nowhere else before ``until_ns``."""
        self._next_ns = max(self._next_ns, until_ns)

    def take(self, screen: FleetScreen, now_ns: int) -> tuple[Tile, ...] | None:
        """Return the tiles noticed in a glance taken now, or None between glances.

        Tiles not looked at for longest come first, ties at random; a warning on any tile
        may draw a look instead. Nothing else of a tile has a say in whether it is noticed.
        """
        if now_ns < self._next_ns:
            return None
        period_ns = self._parameters.glance_period_s * 1e9
        self._next_ns = now_ns + round(period_ns * self._random.uniform(0.7, 1.3))
        if self._random.random() < self._parameters.glance_lapse:
            return ()
        ties = self._random.random(len(screen.tiles)).tolist()
        looked_ns = self._looked_ns
        order = sorted(
            (looked_ns[tile.robot], tie, place)
            for place, (tile, tie) in enumerate(zip(screen.tiles, ties, strict=True))
            if tile.robot != screen.operated
        )
        noticed = [screen.tiles[place] for _, _, place in order[: self._parameters.glance_tiles]]
        if noticed and self._random.random() < self._parameters.cue_capture:
            warning = [
                screen.tiles[place]
                for _, _, place in order
                if (cue := screen.tiles[place].cue) is not None and cue.kind in _WARNINGS
            ]
            if warning and warning[0] not in noticed:
                noticed[-1] = warning[0]
        for tile in noticed:
            looked_ns[tile.robot] = now_ns
        return tuple(noticed)
