"""cantools reads the database of all messages, and decodes the same values as narx."""

import csv
import math
import os
import re
from itertools import groupby
from pathlib import Path

import cantools
import pytest

SAMPLES = Path(os.environ["NARX_INTEROP"])
ROOT = Path(__file__).parents[2]
COMMITTED = ROOT / "docs" / "narx.dbc"
# Numbers of the rows in PROTOCOL.md's tables of parameters.
PARAMETERS = re.findall(r"^\| (\d+) \| [0-9a-f]+ \| .* \| (?:live|read-only|stopped) \|", (ROOT / "PROTOCOL.md").read_text(), re.M)


@pytest.fixture(scope="module")
def database():
    return cantools.database.load_file(COMMITTED, strict=True)


@pytest.fixture(scope="module")
def frames():
    """Identifier, data and signals of each frame."""
    with open(SAMPLES / "decoded.csv", newline="") as table:
        rows = list(csv.DictReader(table))
    groups, current = [], None
    for row in rows:
        if row["signal"] == "":
            current = (int(row["id"]), bytes.fromhex(row["data"]), {})
            groups.append(current)
        else:
            current[2][row["signal"]] = float(row["value"])
    return groups


def test_the_committed_database_is_the_one_of_this_code():
    assert COMMITTED.read_text() == (SAMPLES / "narx.dbc").read_text()


def test_every_message_is_there(database, frames):
    # 33 messages of the specification (with Figure 14 and the request of REBOOT), and 11 of the update.
    assert len(database.messages) == 33 + 11
    assert all(message.is_extended_frame and message.length == 8 for message in database.messages)
    assert {message.frame_id for message in database.messages} == {identifier for identifier, _, _ in frames}


def test_both_decode_the_same(database, frames):
    assert len(frames) > 5000
    for identifier, data, expected in frames:
        decoded = database.decode_message(identifier, data, decode_choices=False)
        assert decoded.keys() == expected.keys()
        for name, value in expected.items():
            assert math.isclose(float(decoded[name]), value, rel_tol=1e-12), (hex(identifier), data.hex(), name)


def test_both_encode_the_same(database, frames):
    for identifier, data, expected in frames:
        # `strict` refuses values outside the ranges of the database.
        again = database.encode_message(identifier, expected, scaling=True, strict=True)
        unused = bytes(a & ~b for a, b in zip(data, again))
        assert not any(unused) or "FAULT" in database.get_message_by_frame_id(identifier).name, data.hex()
        assert not any(b & ~a for a, b in zip(data, again))


def test_every_parameter_is_multiplexed_by_its_number(database):
    for name in ["PARAMETER", "PARAMETER_SET"]:
        message = database.get_message_by_name(name)
        assert message.is_multiplexed()
        selected = [signal for signal in message.signals if signal.multiplexer_ids]
        assert len(selected) == len(PARAMETERS)
        for signal in selected:
            assert signal.name.startswith(f"P{signal.multiplexer_ids[0]}_")
    offset = database.get_message_by_name("PARAMETER").get_signal_by_name("P15_Temperature_calib_offset")
    assert (offset.scale, offset.unit, offset.minimum, offset.maximum, offset.is_signed) == (0.1, "degC", -50, 50, True)


def test_names_fit_every_reader(database):
    names = [signal.name for message in database.messages for signal in message.signals]
    assert max(map(len, names)) <= 32
    for _, group in groupby(sorted((m.name, s.name) for m in database.messages for s in m.signals)):
        assert len(list(group)) == 1
