"""A driver made of a participant's own demonstrations."""

from __future__ import annotations

from study.errors import StudyError
from study.events.events import Timestep
from study.families import load_member
from study.simulated.rollouts import Acting
from study.training_sets import demonstrations
from study.whatif.sessions import ChoiceSession


def own_driver(session: ChoiceSession) -> Acting:
    """Return the nearest-neighbour policy of all that the participant did in the session.

    Raises:
        StudyError: they drove no robot.
    """
    rows = (
        record
        for _, record in session.source.records(Timestep.topic)
        if isinstance(record, Timestep)
    )
    arrays = demonstrations(rows, len(session.task.state_fields)).arrays()
    module = load_member("study.policies", "policy", "nearest_neighbor")
    try:
        weights = module.fit(arrays, session.task, {}, 0).weights
    except StudyError as error:
        raise StudyError(
            f"{session.participant}: no driver of their demonstrations: {error.message}",
            "Give another driver.",
        ) from error
    driver: Acting = module.load(weights, session.task)
    return driver
