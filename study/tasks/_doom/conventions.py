"""What the map's scripts and those who call them have agreed on; quick to import."""

from __future__ import annotations

TICS = 4
"""Tics a timestep; the engine makes 35 a second."""

MAP = "MAP01"
SET_STATE, SET_VELOCITY_FIRST, LIVE = 1, 2, 3
"""The scripts' numbers: put the player somewhere, how fast it then goes, and what runs always."""

HEALTH, TIMESTEPS, PLACED = 1, 2, 3
"""The user variables that scripts answer in: health (16.16), timesteps done, places set."""
