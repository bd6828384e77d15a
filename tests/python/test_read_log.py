"""Logs become columns, and every lost line is reported as an error.

The frames are those that python-can reads, and the values those that cantools decodes.
"""

import io
import math
import re
import tempfile
from collections.abc import Iterator
from pathlib import Path

import can
import canopen
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from logs import DATABASE, any_frames, drive_frames, stamped, write

import narx


@pytest.fixture(scope="module")
def folder() -> Iterator[Path]:
    """A folder for the files of all examples; each example overwrites the files of the last."""
    with tempfile.TemporaryDirectory() as name:
        yield Path(name)


@given(frames=st.lists(drive_frames(), min_size=1, max_size=40))
@settings(max_examples=60, deadline=None)
def test_columns_are_what_cantools_decodes(folder: Path, frames: list[can.Message]) -> None:
    log = narx.read_log(write(folder / "drive.log", stamped(frames)))
    assert not log.errors and len(log) == len(frames)
    rows = dict.fromkeys(log, 0)
    for frame in frames:
        described = DATABASE.get_message_by_frame_id(frame.arbitration_id)
        table = log.table(described.name)
        row = rows[table.name]
        rows[table.name] += 1
        assert table.time[row] == frame.timestamp and table.name == described.name
        decoded = DATABASE.decode_message(frame.arbitration_id, bytes(frame.data), decode_choices=False)
        assert isinstance(decoded, dict)
        for name, value in decoded.items():
            column = "Value" if re.match(r"P\d+_", name) else name
            assert isinstance(value, int | float)
            assert math.isclose(float(table[column][row]), value, rel_tol=1e-12), (name, row)
    assert rows == log.counts


@given(frames=st.lists(any_frames(), max_size=30))
@settings(max_examples=60, deadline=None)
def test_frames_are_what_python_can_reads(folder: Path, frames: list[can.Message]) -> None:
    path = write(folder / "any.log", stamped(frames))
    with can.CanutilsLogReader(path) as reader:
        theirs = list(reader)
    ours = narx.read_log(path)
    assert not ours.errors and len(ours) == len(theirs) == len(frames)
    assert_same_frames(ours, theirs)


def assert_same_frames(ours: narx.CanLog, theirs: list[can.Message]) -> None:
    frames = ours.frames
    assert frames.time.tolist() == [frame.timestamp for frame in theirs]
    assert frames.flag("error").tolist() == [frame.is_error_frame for frame in theirs]
    for row, frame in enumerate(theirs):
        if frame.is_error_frame:
            continue
        assert frames.id[row] == frame.arbitration_id and frames.dlc[row] == frame.dlc
        assert bytes(frames.data[row, : len(frame.data)]) == bytes(frame.data)
        told = {name: bool(frames.flag(name)[row]) for name in ("extended", "remote", "fd", "received")}
        assert told == {
            "extended": frame.is_extended_id, "remote": frame.is_remote_frame, "fd": frame.is_fd, "received": frame.is_rx,
        }  # fmt: skip
    named = sum(ours.counts.values())
    assert named + len(ours.unknown) + len(ours.malformed) + len(ours.error_frames) == len(ours)


STAMPS = st.sampled_from(["(1436509052.249713)", "(0.0)", "(0)", "(12.5", "1.5", "(1.2.3)", "()", "(-3.25)", "(7.000000001)", "(1e2)"])
CHANNELS = st.sampled_from(["can0", "vcan12", "0", "", "can 0"])
BODIES = st.one_of(
    st.from_regex(r"[0-9A-Fa-f]{1,9}#([0-9A-Fa-f]{2}){0,9}", fullmatch=True),
    st.from_regex(r"[0-7][0-9A-F]{2}#[0-9A-FR]{0,5}", fullmatch=True),
    st.from_regex(r"[0-7][0-9A-F]{2}##[0-9]?([0-9A-F]{2}){0,20}", fullmatch=True),
    st.from_regex(r"[0-9A-G#]{0,12}", fullmatch=True),
)
DIRECTIONS = st.sampled_from(["", " R", " T", " r", " X", "R"])
ODD = st.builds("{} {} {}{}".format, STAMPS, CHANNELS, BODIES, DIRECTIONS)


def theirs(line: str) -> can.Message | None:
    """Returns the frame that python-can reads in a line, or None."""
    try:
        return next(iter(can.CanutilsLogReader(io.StringIO(line))), None)
    except (ValueError, IndexError):
        return None


def impossible(line: str, frame: can.Message) -> bool:
    """Returns whether python-can reads the line as a frame that cannot occur on a bus.

    narx reports such lines as errors (docs/design/python.md, Logs as columns).
    """
    data = line.split("#", 1)[1].split(" ")[0]
    digits = line.split("#")[0].split()[-1]
    return (
        not re.match(r"\(.*\) ", line)
        or not re.fullmatch("[0-9A-Fa-f]{1,8}", digits)
        or not frame.is_extended_id and frame.arbitration_id > 0x7FF
        or len(frame.data) != frame.dlc and not frame.is_remote_frame
        or frame.dlc > (64 if frame.is_fd else 8)
        or frame.is_error_frame and len(data) > 16
        or frame.is_remote_frame and (frame.is_fd or not re.fullmatch("[Rr][0-8]?", data))
        or bool(re.match("2[0-9A-F]{7}$|3[0-9A-F]{7}$|[A-F][0-9A-F]{7}$", digits.upper()))
    )


@given(lines=st.lists(ODD, min_size=1, max_size=12))
@settings(max_examples=100, deadline=None)
def test_odd_lines_are_read_as_python_can_does_or_told(folder: Path, lines: list[str]) -> None:
    path = folder / "odd.log"
    path.write_text("".join(line + "\n" for line in lines))
    log = narx.read_log(path)
    assert log.lines == len(lines) == len(log) + len(log.errors)
    refused = {error.line: error for error in log.errors}
    read = []
    for number, line in enumerate(lines, 1):
        frame = theirs(line)
        if number not in refused:
            assert frame is not None, line
            read.append(frame)
        else:
            assert frame is None or impossible(line, frame), (line, refused[number])
            assert refused[number].text == line.strip() and refused[number].reason
    if not any(frame.arbitration_id > 0x1FFFFFFF or frame.is_error_frame for frame in read):
        plain = [row for row, error in enumerate(log.frames.flag("error")) if not error]
        assert log.frames.time.tolist() == [frame.timestamp for frame in read]
        assert log.frames.id[plain].tolist() == [read[row].arbitration_id for row in plain]


@pytest.mark.parametrize("ending", [".asc", ".blf", ".csv", ".trc", ".log.gz", ".asc.gz", ".db"])
@given(frames=st.lists(drive_frames(), min_size=1, max_size=8))
@settings(max_examples=8, deadline=None)
def test_every_format_gives_the_same_columns(folder: Path, ending: str, frames: list[can.Message]) -> None:
    for old in folder.glob("same*"):
        old.unlink()
    expected = narx.read_log(write(folder / "same.log", stamped(frames)))
    log = narx.read_log(write(folder / f"same{ending}", frames))
    assert not log.errors and log.counts == expected.counts
    for name in log:
        for signal in log.table(name).keys() - {"time"}:
            assert np.array_equal(log[name][signal], expected[name][signal], equal_nan=True), (name, signal)
    assert log.frames.time - log.frames.time[0] == pytest.approx(expected.frames.time - expected.frames.time[0], abs=1e-5)


def test_types_and_names(tmp_path: Path) -> None:
    path = tmp_path / "types.log"
    lines = [
        "(1.0) can0 15552A03#0400030300000000", "(2.0) can0 15552AC9#FF6A0000012C0064", "(2.5) can0 15552ACD#0BB8000100000000",
        "(3.0) can0 15552A04#1000000000000000", "(4.0) can0 15552A6E#004E000000080000", "(5.0) can0 15552ACD#0BB9000100000000",
    ]  # fmt: skip
    path.write_text("\n".join(line.replace("15552A", narx_id()) for line in lines) + "\n")
    log = narx.read_log(path)
    assert list(log) == ["STATUS_WORD", "FAULT_WORD", "PARAMETER", "MEASUREMENT_1", "MEASUREMENT_5"]
    status = log["status"]
    assert status["Log memory full"].dtype == bool and status["motor_mode"].dtype == np.uint16
    assert status.series("Control mode").text() == ["Hall closed loop"]
    position = log["Mechanical position"]
    assert position.values.dtype == np.float64 and (position.unit, position[0], position.time[0]) == ("deg", 3.0, 2.0)
    assert np.asarray(log["mechanical estimated speed SL"]).tolist() == [-150.0]
    assert (log["speed"].time.tolist(), log["speed"].values.tolist()) == ([2.5, 5.0], [3000.0, 3001.0])
    assert log["Motor pair poles"].values.tolist() == [8.0]
    assert log["external_shutdown"].values.tolist() == [True] and log["FAULT_WORD"]["Faults"].dtype == np.uint32
    assert len(log["MEASUREMENT_3"]) == 0 and "MEASUREMENT_3" not in log and "hv voltage" not in log
    with pytest.raises(narx.SignalError, match='no message with a signal "HV Voltage" came'):
        log["HV Voltage"]
    with pytest.raises(narx.SignalError, match='no message or signal "HV Voltages"; did you mean "HV Voltage"'):
        log["HV Voltages"]


def test_speed_is_what_the_control_mode_uses(tmp_path: Path) -> None:
    path = tmp_path / "speed.log"
    modes = {"off": "0000", "sensorless": "0201", "hall": "0301"}
    lines: list[str] = []

    def receive(opcode: str, data: str) -> None:
        lines.append(f"({len(lines)}.0) can0 {narx_id()}{opcode}#{data.ljust(16, '0')}\n")

    for mode in ("", "off", "sensorless", "hall", "sensorless"):
        if mode:
            receive("03", "0000" + modes[mode])
        receive("CD", f"{5000 + len(lines):04X}")
        receive("C9", f"{1000 + len(lines):04X}")
    path.write_text("".join(lines))
    speed = narx.read_log(path)["speed"]
    assert speed.values.tolist() == [1001, 1004, 1007, 5009, 1013] and speed.time.tolist() == [1, 4, 7, 9, 13]
    path.write_text("")
    assert len(narx.read_log(path)["speed"]) == 0


def narx_id() -> str:
    """Returns the digits of the drive's identifiers before type and opcode."""
    return f"{DATABASE.get_message_by_name('STATUS_WORD').frame_id:08X}"[:6]


def test_a_clock_that_jumps_back_begins_a_lap(tmp_path: Path) -> None:
    voltage = "1552A8CA#0708000100020003"
    file = tmp_path / "twice.log"
    stamps = (100.0, 101.0, 102.0, 0.5, 1.5, 1.4, 2.5)
    lines = [f"({stamp}) can0 {voltage}" for stamp in stamps]
    file.write_text("\n".join([*lines[:3], "(102.5) can0 182#00000008", *lines[3:]]) + "\n")
    with pytest.warns(narx.NarxWarning, match=f'the clock of "{file}" jumps back once: `laps` has each part'):
        log = narx.read_log(file)
    assert [len(lap) for lap in log.laps] == [4, 4] and log.laps[0].counts == {"MEASUREMENT_2": 3, "PDO1": 1}
    assert log.laps[1]["HV Voltage"].time.tolist() == [0.5, 1.5, 1.4, 2.5] and len(log.laps[1].laps) == 1
    table = log.to_pandas("HV Voltage", "Position 1")
    # The lap's own order is that of its clock; a lap without a signal has no value of it.
    assert table["time"].tolist() == [100.0, 101.0, 102.0, 102.5, 0.5, 1.4, 1.5, 2.5]
    assert table["lap"].tolist() == [0] * 4 + [1] * 4
    assert table["Position 1"].isna().tolist() == [True] * 3 + [False] + [True] * 4 and table["HV Voltage"].notna().all()
    assert len(log.to_pandas("HV Voltage", period=0.5)) == 5 + 5
