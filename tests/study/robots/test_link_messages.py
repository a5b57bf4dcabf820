"""Messages as bytes: what we say comes back, what others send is refused or read."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from study.robots.link import (
    MAX_ANGULAR,
    MAX_LINEAR,
    Busy,
    Command,
    EmergencyStop,
    Frame,
    Goodbye,
    Hello,
    LinkError,
    Message,
    PoseReading,
    Poses,
    Release,
    Status,
    Welcome,
    decode,
    encode,
)

numbers = st.integers(1, 2**64 - 1)
counts = st.integers(0, 2**64 - 1)
linears = st.floats(-MAX_LINEAR, MAX_LINEAR)
angulars = st.floats(-MAX_ANGULAR, MAX_ANGULAR)
finite = st.floats(allow_nan=False, allow_infinity=False)
sizes = st.tuples(st.integers(1, 8), st.integers(1, 8), st.binary(min_size=192, max_size=192))
messages: st.SearchStrategy[Message] = st.one_of(
    *(st.builds(kind, numbers) for kind in (Hello, Busy, EmergencyStop, Release, Goodbye)),
    st.builds(Welcome, numbers, st.floats(0.01, MAX_LINEAR), st.floats(0.01, MAX_ANGULAR)),
    st.builds(Command, numbers, counts, counts, linears, angulars),
    st.builds(
        Status,
        *[counts] * 7,
        linears,
        angulars,
        st.floats(0, 1),
        st.integers(0, 3),
    ),
    st.builds(
        lambda size, sequence: Frame(
            sequence, 1, size[0], size[1], size[2][: 3 * size[0] * size[1]]
        ),
        sizes,
        counts,
    ),
    st.builds(
        Poses,
        counts,
        counts,
        st.lists(
            st.builds(PoseReading, st.integers(0, 65535), finite, finite, finite), max_size=64
        ).map(tuple),
    ),
)


@given(messages)
def test_messages_come_back_as_they_were(message: Message) -> None:
    """Encoded and decoded, nothing is lost."""
    assert decode(encode(message)) == message


@given(st.lists(st.binary(max_size=120), max_size=3))
def test_noise_is_no_message(parts: list[bytes]) -> None:
    """Whatever comes is refused with one kind of error."""
    with pytest.raises(LinkError):
        decode(parts)


@given(messages, st.data())
def test_damaged_messages_are_refused_or_read(message: Message, data: st.DataObject) -> None:
    """A flipped bit or a cut gives a message within all limits, or a `LinkError`."""
    parts = [bytearray(part) for part in encode(message)]
    part = parts[data.draw(st.integers(0, len(parts) - 1))]
    if part:
        place = data.draw(st.integers(0, len(part) - 1))
        if data.draw(st.booleans()):
            part[place] ^= 1 << data.draw(st.integers(0, 7))
        else:
            del part[place:]
    try:
        read = decode([bytes(part) for part in parts])
    except LinkError:
        return
    if isinstance(read, Command | Status):
        assert abs(read.linear) <= MAX_LINEAR
        assert abs(read.angular) <= MAX_ANGULAR


@pytest.mark.parametrize(
    "message",
    [
        Command(1, 1, 1, math.nan, 0.0),
        Command(1, 1, 1, MAX_LINEAR * 1.01, 0.0),
        Command(1, 1, 1, 0.0, -math.inf),
        Command(0, 1, 1, 0.0, 0.0),
        Command(1, -1, 1, 0.0, 0.0),
        Welcome(1, 2 * MAX_LINEAR, 1.0),
        Frame(1, 1, 640, 481, bytes(3 * 640 * 481)),
        Frame(1, 1, 2, 2, bytes(11)),
        Status(1, 1, 1, 1, 1, 1, 1, 0.0, 0.0, 1.1, 0),
        Status(1, 1, 1, 1, 1, 1, 1, 0.0, 0.0, 1.0, 4),
        Poses(1, 1, (PoseReading(0, math.nan, 0.0, 0.0),)),
        Poses(1, 1, (PoseReading(0, 0.0, 0.0, 0.0),) * 65),
    ],
)
def test_the_protocol_cannot_say_it(message: Message) -> None:
    """Speeds above the limit, numbers that are none and impossible sizes cannot be sent."""
    with pytest.raises(LinkError):
        encode(message)
