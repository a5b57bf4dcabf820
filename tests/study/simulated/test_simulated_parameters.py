"""The parameters of simulated operators."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from study.errors import StudyError
from study.simulated.parameters import OperatorParameters, draw_parameters, stated_parameters


@given(st.integers(0, 2**63), st.integers(0, 100))
@settings(max_examples=30)
def test_draws_repeat_and_survive_json(seed: int, index: int) -> None:
    """A participant's parameters are the same every time, and after a trip through JSON."""
    drawn = draw_parameters(seed, index)
    assert drawn == draw_parameters(seed, index)
    assert OperatorParameters.model_validate_json(drawn.model_dump_json()) == drawn


def test_participants_differ_about_the_middle() -> None:
    """Participants differ, and their average lies near the defaults."""
    drawn = [draw_parameters(1, index) for index in range(200)]
    delays = [parameters.reorientation_s for parameters in drawn]
    assert len(set(delays)) > 100
    assert np.mean(delays) == pytest.approx(OperatorParameters().reorientation_s, rel=0.1)
    assert {parameters.glance_tiles for parameters in drawn} == {1, 2, 3}


def test_every_parameter_says_its_unit_and_reason() -> None:
    """Each field has a description with a unit and, after a semicolon, why it is plausible."""
    for name, field in OperatorParameters.model_fields.items():
        assert field.description, name
        assert ";" in field.description, name


def test_nonsense_is_refused() -> None:
    """Unknown names and impossible values are refused, and a value cannot be changed."""
    with pytest.raises(ValidationError):
        OperatorParameters(glance_lapse=1.5)
    with pytest.raises(ValidationError):
        OperatorParameters.model_validate({"glances": 3})
    with pytest.raises(ValidationError):
        OperatorParameters().glance_tiles = 3  # type: ignore[misc]


def test_stated_parameters_are_all_participants_and_change_no_other() -> None:
    """What is not stated is drawn as ever."""
    stated = stated_parameters(["glance_tiles=1", "glance_lapse = 0.5"])
    for index in range(5):
        drawn = draw_parameters(3, index).model_dump()
        found = draw_parameters(3, index, stated=stated).model_dump()
        assert (found.pop("glance_tiles"), found.pop("glance_lapse")) == (1, 0.5)
        assert found.items() <= drawn.items()


@pytest.mark.parametrize(
    "text", ["nobody=1", "driver=1", "glance_tiles=2.5", "glance_lapse=nan", "glance_lapse", "=1"]
)
def test_parameters_that_cannot_be_stated(text: str) -> None:
    """Unknown names, no numbers and impossible values are one message each."""
    with pytest.raises(StudyError):
        stated_parameters([text])
