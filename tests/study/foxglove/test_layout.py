"""The layout for Foxglove names only what is in a recording or in an export of one."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest

from study.events.fields import record_types, wire_fields
from study.foxglove.layout import layout_path
from study.foxglove.schemas import LOG_TOPIC, SCENE_TYPES

LAYOUT: dict[str, Any] = json.loads(layout_path().read_text(encoding="utf-8"))
PANELS: dict[str, dict[str, Any]] = LAYOUT["configById"]
PATH = re.compile(r"(?P<topic>[a-z]+/[a-z_]+)\.(?P<field>[a-z_]+)(?P<index>\[[0-9:]+\])?")
SERIES = [series["value"] for panel in PANELS.values() for series in panel.get("paths", [])]


def panels_in(node: Any) -> list[str]:
    """Return the panels of a part of the layout, tabs followed."""
    if isinstance(node, str):
        tabs = PANELS[node].get("tabs", [])
        return [node, *(name for tab in tabs for name in panels_in(tab["layout"]))]
    assert 0 < node["splitPercentage"] < 100
    assert node["direction"] in ("row", "column")
    return [*panels_in(node["first"]), *panels_in(node["second"])]


def test_every_panel_is_placed_once() -> None:
    """What is placed is described, and the other way round."""
    placed = panels_in(LAYOUT["layout"])
    assert sorted(placed) == sorted(PANELS)


@pytest.mark.parametrize("path", sorted(set(SERIES)))
def test_every_series_is_a_field_of_a_record(path: str) -> None:
    """Topic and field are declared; an array is indexed, a single value is not."""
    match = PATH.fullmatch(path)
    assert match, path
    wire = wire_fields(record_types()[match["topic"]])[match["field"]]
    assert bool(match["index"]) == (wire.kind in ("floats", "doubles", "ints"))


def test_every_topic_shown_exists() -> None:
    """Scene topics, raw messages and the log."""
    shown = set(PANELS["3D!scene"]["topics"])
    assert shown <= set(SCENE_TYPES)
    raw = {panel["topicPath"] for name, panel in PANELS.items() if name.startswith("RawMessages!")}
    assert raw <= set(record_types())
    assert PANELS["RosOut!log"]["topicToRender"] == LOG_TOPIC
