"""Fits answer with weights or with a reason, whatever becomes of their process."""

from __future__ import annotations

import json
import os
import signal
import time
from collections.abc import Iterator
from operator import attrgetter
from typing import Any

import numpy as np
import pytest

from patience import PATIENCE_S
from study.events.task_description import TaskDescription
from study.loading import load_protocol
from study.session.effects import RequestFit
from study.shell.fitting import FitAnswer, InlineFitter, ProcessFitter, fit
from study.training_sets import choice_sets, demonstrations


def description() -> TaskDescription:
    """Return the smoke protocol's task."""
    return load_protocol("smoke").description


def request(kind: str, rows: int = 60, **changes: Any) -> RequestFit:
    """Return a request with made-up data."""
    random = np.random.default_rng(rows)
    if kind == "policy":
        arrays: dict[str, Any] = {
            "states": random.uniform(0, 10, (rows, 4)).astype(np.float32),
            "actions": random.integers(0, 4, rows).astype(np.int32),
        }
    else:
        arrays = {
            "states": random.uniform(0, 10, (rows, 3, 4)).astype(np.float32),
            "available": np.ones((rows, 3), np.bool_),
            "chosen": random.integers(0, 3, rows).astype(np.int32),
            "trials": (np.arange(rows) // 10).astype(np.int32),
        }
    values: dict[str, Any] = {
        "request_id": 5,
        "artefact_id": f"{kind}:x",
        "kind": kind,
        "algorithm": "nearest_neighbor" if kind == "policy" else "luce",
        "parameters_json": json.dumps({} if kind == "policy" else {"hidden": [4], "epochs": 3}),
        "arrays": arrays,
        "seed": 1,
        "budget_seconds": PATIENCE_S,
    }
    return RequestFit(**{**values, **changes})


@pytest.mark.parametrize("kind", ["policy", "scorer"])
def test_fit_without_data_says_why(kind: str) -> None:
    """Nobody corrected, or nobody chose: the answer is a reason, not an exception."""
    empty = demonstrations([], 4).arrays() if kind == "policy" else choice_sets([], 3, 4).arrays()
    answer = fit(request(kind, arrays=empty), description())
    assert answer.reason
    # It stands within a sentence: of the terminal, the console, the table of deviations.
    assert "\n" not in answer.reason
    assert not answer.reason.endswith(".")
    assert not answer.timed_out
    assert answer.weights == b""


@pytest.mark.parametrize(
    "changes",
    [{"algorithm": "luse"}, {"parameters_json": '{"hiden": [2]}'}, {"parameters_json": "{"}],
    ids=["unknown", "parameter", "no JSON"],
)
def test_fit_that_cannot_be_made_says_why(changes: dict[str, Any]) -> None:
    """A wrong request is answered with a reason too."""
    assert fit(request("scorer", **changes), description()).reason


def test_scorer_fit_comes_with_its_map() -> None:
    """The grid is [healths, headings, rows, columns] of the task's map grid; a policy has none."""
    grid = description().map_grid
    assert grid is not None
    answer = fit(request("scorer"), description())
    assert answer.reason == ""
    shape = (len(grid.healths), len(grid.headings), len(grid.ys), len(grid.xs))
    assert answer.score_grid.shape == shape
    assert answer.score_grid.dtype == np.float64
    assert np.isfinite(answer.score_grid).all()
    assert answer.weights
    assert answer.metrics
    assert fit(request("policy"), description()).score_grid.size == 0


def test_inline_fitter_answers_once() -> None:
    """The answer belongs to the request, and comes once."""
    fitter = InlineFitter(description())
    asked = request("policy")
    fitter.request(asked)
    answer = fitter.poll()
    assert answer is not None
    assert answer.request is asked
    assert fitter.poll() is None
    fitter.close()


@pytest.fixture(scope="module")
def fitter() -> Iterator[ProcessFitter]:
    """A fitting process."""
    made = ProcessFitter(description())
    yield made
    made.close()


def answered(fitter: ProcessFitter, asked: RequestFit) -> FitAnswer:
    """Ask and wait for the answer."""
    fitter.request(asked)
    return awaited(fitter)


def awaited(fitter: ProcessFitter) -> FitAnswer:
    """Wait for the answer."""
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        answer = fitter.poll(0.2)
        if answer is not None:
            return answer
    raise AssertionError("no answer")


def test_process_fits_gives_up_and_fits_again(fitter: ProcessFitter) -> None:
    """A fit over its budget is given up; the next one is served as if nothing had been."""
    assert fitter.poll() is None
    good = answered(fitter, request("policy"))
    assert good.reason == ""
    slow = request("scorer", 4000, parameters_json='{"epochs": 5000}', budget_seconds=0.05)
    given_up = answered(fitter, slow)
    assert given_up.timed_out
    assert given_up.request is slow
    assert fitter.poll() is None
    again = answered(fitter, request("policy"))
    assert again.weights == good.weights


def test_killed_process_is_an_answer_and_replaced(fitter: ProcessFitter) -> None:
    """A fit whose process dies fails with the reason; the next one is served."""
    fitter.request(request("scorer", 4000, parameters_json='{"epochs": 5000}'))
    os.kill(attrgetter("_worker._process.pid")(fitter), signal.SIGKILL)
    answer = awaited(fitter)
    assert "ended unexpectedly" in answer.reason
    assert not answer.timed_out
    assert answered(fitter, request("policy")).reason == ""


def test_process_that_died_unasked_is_replaced(fitter: ProcessFitter) -> None:
    """A request to a dead process is served by a new one, or answered with the reason."""
    assert answered(fitter, request("policy")).reason == ""
    os.kill(attrgetter("_worker._process.pid")(fitter), signal.SIGKILL)
    time.sleep(0.3)
    first = answered(fitter, request("policy"))
    assert first.reason == "" or "ended unexpectedly" in first.reason
    assert answered(fitter, request("policy")).reason == ""


def test_fault_in_a_fit_is_answered_at_once(fitter: ProcessFitter) -> None:
    """Data that no fit expects costs an answer with a reason, not the whole budget."""
    answer = answered(fitter, request("policy", arrays={}, budget_seconds=PATIENCE_S))
    assert answer.reason
    assert not answer.timed_out
