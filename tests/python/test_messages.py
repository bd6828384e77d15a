"""Decoding agrees with cantools and the committed data base, and accepts any frame."""

import math
from pathlib import Path

import can
import cantools
import pytest
from cantools.database.can import Database, Message
from hypothesis import given, settings
from hypothesis import strategies as st

import narx

DBC = cantools.database.load_file(Path(__file__).parents[2] / "docs" / "narx.dbc")
assert isinstance(DBC, Database)
MESSAGES: list[Message] = list(DBC.messages)
PLAIN = [message for message in MESSAGES if not message.is_multiplexed()]


def same(ours: object, theirs: object) -> bool:
    if isinstance(ours, float) and isinstance(theirs, int | float):
        return math.isclose(ours, theirs, rel_tol=1e-9, abs_tol=1e-9)
    return ours == theirs or str(ours) == str(theirs)


@given(message=st.sampled_from(PLAIN), data=st.binary(min_size=8, max_size=8))
@settings(max_examples=500, deadline=None)
def test_numbers_are_those_of_the_data_base(message: Message, data: bytes) -> None:
    ours = narx.decode(message.frame_id, data)
    assert ours is not None and ours.name.replace(" ", "_").upper() in message.name.upper()
    theirs = message.decode_simple(data, decode_choices=False)
    numbers = [value for value in ours.values.values() if isinstance(value, int | float) and not isinstance(value, bool)]
    expected = [float(value) for value in theirs.values() if isinstance(value, int | float)]
    # Every plain number of narx is one of cantools' numbers. Names and sets of faults are texts instead.
    assert all(any(same(number, other) for other in expected) for number in numbers), (ours, theirs)


@given(
    number=st.integers(0, 0x1FFFFFFF), extended=st.booleans(), remote=st.booleans(), data=st.binary(max_size=8)
)  # fmt: skip
@settings(max_examples=500, deadline=None)
def test_any_frame_is_decoded_or_is_none(number: int, extended: bool, remote: bool, data: bytes) -> None:
    number = number if extended else number & 0x7FF
    frame = can.Message(
        arbitration_id=number, is_extended_id=extended, is_remote_frame=remote, dlc=len(data),
        data=None if remote else data,
    )  # fmt: skip
    message = narx.decode(frame)
    if isinstance(message, narx.Message):
        assert extended and not remote and len(data) == 8 and message.opcode == number & 0x1FF
    elif message is not None:
        assert not extended and (number < 0x81 or message.node == number & 0x7F)


def test_values_have_names_and_units() -> None:
    measurement = next(message for message in MESSAGES if message.name == "MEASUREMENT_2")
    decoded = narx.decode(measurement.frame_id, (1802).to_bytes(2, "big") + (1500).to_bytes(2, "big") + bytes(4))
    assert isinstance(decoded, narx.Message) and decoded.from_drive and (decoded.source, decoded.destination) == (170, 85)
    assert decoded["HV Voltage"] == 18.02 and decoded["HV Current"] == 1.5
    assert decoded.units["HV Voltage"] == "V"
    faults = next(message for message in MESSAGES if message.name == "FAULT_WORD")
    told = narx.decode(faults.frame_id, (1 << 28 | 1 << 6).to_bytes(4, "big") + bytes(4))
    assert told is not None and {"external_shutdown"} < told["Faults"] and len(told["Faults"]) == 2


def test_what_is_no_frame_is_refused() -> None:
    with pytest.raises(narx.ParameterError, match="identifier 536870912: must be a whole number from 0 to 536870911"):
        narx.decode(1 << 29, bytes(8))
    with pytest.raises(narx.ParameterError, match="data of 9 bytes: must have at most 8"):
        narx.decode(3, bytes(9))
    with pytest.raises(narx.ParameterError, match="identifier 0x3: its data is missing"):
        narx.decode(3)


def test_files_for_other_tools_are_those_that_are_committed() -> None:
    docs = Path(__file__).parents[2] / "docs"
    assert narx.dbc() == (docs / "narx.dbc").read_text(encoding="utf-8")
    for channels, encoder, name in ((1, False, "single"), (1, True, "single-encoder"), (2, True, "dual-encoder")):
        assert narx.eds(channels, encoder) == (docs / f"eddycan-{name}.eds").read_text(encoding="utf-8")
    with pytest.raises(narx.ParameterError, match="channels 3: must be 1 or 2"):
        narx.eds(3)


def test_the_description_is_that_of_a_drive(bench: narx.Bench) -> None:
    # The drive adds a line's end to a text of odd length; `rstrip` removes it.
    lines, served = narx.xml().splitlines(), bench.drive.description().rstrip().splitlines()
    assert lines[2:] == served[2:] and len(lines) > 300
