"""Events of fits: what was prepared in the background, gone on from, and judged by a gate."""

from __future__ import annotations

from study.events.fields import Record, boolean, double, fixed64, record, sfixed32, string


@record("event", "preparation_requested")
class PreparationRequested(Record):
    """A scorer is to be fitted in the background; its answer takes effect nowhere."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    request_id: int = sfixed32(2, "number of the request")
    artefact_id: str = string(3, "name of what a later fit will make")
    algorithm: str = string(4, 'name in the protocol: "luce", ...')
    rows: int = sfixed32(5, "choice rows used")
    data_sha256: str = string(6, "SHA-256 of the training data, hexadecimal")


@record("event", "warm_started")
class WarmStarted(Record):
    """The fit just requested goes on from what an earlier one left."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    request_id: int = sfixed32(2, "number of the request that goes on")
    from_request_id: int = sfixed32(3, "number of the request whose answer it goes on from")
    preparation_sha256: str = string(4, "SHA-256 of that answer's preparation, hexadecimal")


@record("event", "fit_gate_judged")
class FitGateJudged(Record):
    """A scorer was held against its gate."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    request_id: int = sfixed32(2, "number of the fit's request")
    artefact_id: str = string(3, "name of what was fitted")
    attempt: int = sfixed32(4, "attempt, from 1")
    attempts: int = sfixed32(5, "how many there are at most")
    passed: bool = boolean(6, "whether it reached every threshold")
    decision: str = string(
        7, 'what follows: "use", "repeat", "go_on", "fallback" or "end"; "use" if it passed'
    )
    fallback: str = string(8, 'what takes its place: "manual", a scorer, or empty')
    likelihood_gain: float = double(
        9, "held-out log-likelihood a choice above chance; NaN if not measured", unit="nats"
    )
    top1_gain: float = double(10, "held-out top-1 above chance; NaN if not measured")
    calibration_error: float = double(11, "of held-out choices; NaN if not measured")
    min_likelihood_gain: float = double(12, "its threshold", unit="nats")
    min_top1_gain: float = double(13, "its threshold")
    max_calibration_error: float = double(14, "its threshold")
    reason: str = string(15, "why it did not pass, in words; empty if it did")
