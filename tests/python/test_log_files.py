"""Broken, cut and odd files: readable lines are kept, and unreadable ones are reported with their number."""

import gzip
from pathlib import Path

import can
import pytest
from logs import DATABASE, stamped, write

import narx

SPEED = DATABASE.get_message_by_name("MEASUREMENT_5").frame_id
FRAMES = stamped([can.Message(arbitration_id=SPEED, data=speed.to_bytes(2, "big") + bytes(6)) for speed in range(100)])
SIGNAL = "Mechanical estimated speed HES"

# Files written by python-can with one broken line: format, index of the line (from 0), function that breaks
# the line, reason of the error.
BROKEN = [
    (".log", 49, lambda line: line.replace("#", "?"), "no # between identifier and data"),
    (".log", 49, lambda line: line[:-3], "the data are not pairs of hexadecimal digits"),
    (".log", 49, lambda line: "\x00\x00\x00", 'not "(time) channel identifier#data"'),
    (".csv", 50, lambda line: line.replace("0x", "0y"), "invalid literal for int"),
    (".csv", 50, lambda line: line.rsplit(",", 2)[0], "not enough values to unpack"),
    (".csv", 50, lambda line: line[:-4], "6 data bytes where there should be 8"),
    (".asc", 55, lambda line: line.replace(" d 8 ", " d Z "), "invalid literal for int"),
    (".asc", 55, lambda line: line[:30], "python-can reads no frame from it"),
    (".asc", 55, lambda line: line.rstrip()[:-2], "7 data bytes where there should be 8"),
    (".asc", 55, lambda line: line.replace(" 00 00", ""), "2 data bytes where there should be 8"),
    (".asc", 55, lambda line: line.replace(".", "_"), "python-can reads no frame from it"),
    (".trc", 65, lambda line: line.replace(" 8 ", " Q "), "invalid literal for int"),
]  # fmt: skip


@pytest.mark.parametrize(("ending", "at", "break_it", "reason"), BROKEN)
def test_a_corrupt_line_is_told_and_skipped(tmp_path: Path, ending: str, at: int, break_it, reason: str) -> None:  # type: ignore[no-untyped-def]
    path = write(tmp_path / f"broken{ending}", FRAMES)
    lines = path.read_text().splitlines()
    whole, lines[at] = lines[at], break_it(lines[at])
    assert whole != lines[at], whole
    path.write_text("\n".join(lines) + "\n")
    log = narx.read_log(path)
    (error,) = log.errors
    assert error.line == at + 1 and reason in error.reason and error.text == lines[at].strip(" \n"), error
    speeds = log[SIGNAL].values.tolist()
    assert len(speeds) == 99 and ({*range(100)} - {*speeds}) & {*range(47, 53)}


def test_bytes_that_are_no_text_spoil_their_line_alone(tmp_path: Path) -> None:
    for ending in (".log", ".csv"):
        path = write(tmp_path / f"binary{ending}", FRAMES)
        lines = path.read_bytes().split(b"\n")
        lines[20] = b"\xff\xfe" + lines[20]
        path.write_bytes(b"\n".join(lines))
        log = narx.read_log(path)
        assert len(log) == 99 and [error.line for error in log.errors] == [21]


def test_a_first_line_without_a_header_is_a_frame(tmp_path: Path) -> None:
    for ending, headers in ((".csv", 1), (".asc", 4)):
        path = write(tmp_path / f"headless{ending}", FRAMES)
        lines = path.read_text().splitlines()[headers:]
        while not lines[0].strip()[0].isdigit() or "Start of" in lines[0]:
            del lines[0]
        path.write_text("\n".join(lines) + "\n")
        log = narx.read_log(path)
        assert log[SIGNAL].values.tolist() == [*range(100)]
        assert all("end" in error.text.lower() for error in log.errors)


@pytest.mark.parametrize("part", [0.0, 0.1, 0.5, 0.9, 0.999])
def test_a_binary_log_that_is_cut_keeps_what_was_read(tmp_path: Path, part: float) -> None:
    path = write(tmp_path / "cut.blf", FRAMES * 200)
    data = path.read_bytes()
    assert narx.read_log(path).errors == [] and len(narx.read_log(path)) == 20_000
    path.write_bytes(data[: int(len(data) * part)])
    log = narx.read_log(path)
    (error,) = log.errors
    assert error.line is None and ("truncated: " in error.reason if part else "not a log of this format" in error.reason)
    assert len(log) < 20_000 and log.table("MEASUREMENT_5")[SIGNAL].tolist() == [row % 100 for row in range(len(log))]
    assert part < 0.5 or len(log) > 5000 * part


def test_a_packed_log_that_is_cut_keeps_what_was_read(tmp_path: Path) -> None:
    plain = write(tmp_path / "plain.log", FRAMES * 200)
    packed = gzip.compress(plain.read_bytes())
    path = tmp_path / "cut.log.gz"
    path.write_bytes(packed[: len(packed) // 2])
    log = narx.read_log(path)
    assert 1000 < len(log) < 20_000
    assert any(error.line is None and error.reason.startswith("truncated: ") for error in log.errors)


def test_packed_logs_may_be_joined(tmp_path: Path) -> None:
    data = write(tmp_path / "plain.log", FRAMES * 20).read_bytes()
    path = tmp_path / "joined.log.gz"
    path.write_bytes(gzip.compress(data, 0) + bytes(1000) + gzip.compress(data, 9) + gzip.compress(data, 0))
    assert path.stat().st_size > 1 << 17
    log = narx.read_log(path)
    assert (len(log), log.errors) == (6000, [])
    path.write_bytes(gzip.compress(data, 0)[:-40_000] + b"not packed")
    log = narx.read_log(path)
    assert 500 < len(log) < 2000 and log.errors


def test_a_damaged_binary_log_says_so(tmp_path: Path) -> None:
    path = write(tmp_path / "damaged.blf", FRAMES * 200)
    data = bytearray(path.read_bytes())
    data[len(data) // 2 : len(data) // 2 + 64] = bytes(64)
    path.write_bytes(data)
    log = narx.read_log(path)
    (error,) = log.errors
    assert error.reason.startswith("damaged: ") and 0 < len(log) < 20_000


def test_what_is_no_such_log_says_so(tmp_path: Path) -> None:
    for ending in (".blf", ".asc", ".csv", ".log", ".trc", ".db"):
        path = tmp_path / f"picture{ending}"
        path.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 4)
        log = narx.read_log(path)
        assert len(log) == 0 and log.errors, ending


REFUSED = [
    ({}, "run.txt", 'path ".*run.txt": No read support for unknown log format ".txt"'),
    ({"slave": 256}, "run.log", "slave 256: must be a whole number from 0 to 255"),
    ({"monitor": -1}, "run.log", "monitor -1: must be"),
    ({"encoders": [0]}, "run.log", "encoders 0: must be a whole number from 1 to 127"),
]


@pytest.mark.parametrize(("arguments", "name", "message"), REFUSED)
def test_what_cannot_be_read_is_refused(tmp_path: Path, arguments: dict[str, int], name: str, message: str) -> None:
    (tmp_path / name).write_text("")
    with pytest.raises(narx.ParameterError, match=message):
        narx.read_log(tmp_path / name, **arguments)  # type: ignore[arg-type]
    with pytest.raises(FileNotFoundError):
        narx.read_log(tmp_path / "nowhere.log")


def test_other_addresses_are_unknown_unless_they_are_asked_for(tmp_path: Path) -> None:
    other = SPEED & ~(0xFF << 19) | 171 << 19
    path = write(tmp_path / "two.log", stamped([FRAMES[7], can.Message(arbitration_id=other, data=bytes(8))]))
    assert len(narx.read_log(path)["MEASUREMENT_5"]) == 1 and len(narx.read_log(path).unknown) == 1
    assert narx.read_log(path, slave=171)["MEASUREMENT_5"].time.tolist() == [FRAMES[7].timestamp + 0.001]
    assert len(narx.read_log(path, slave=None)["MEASUREMENT_5"]) == 2


def test_signals_side_by_side(tmp_path: Path) -> None:
    path = tmp_path / "side.log"
    voltage = DATABASE.get_message_by_name("MEASUREMENT_2").frame_id
    rows = [(1.0, voltage, 1800), (1.5, SPEED, 100), (2.0, voltage, 1900), (2.0, SPEED, 200), (3.0, SPEED, 300)]
    path.write_text("".join(f"({time}) can0 {id:08X}#{value:04X}000000000000\n" for time, id, value in rows))
    log = narx.read_log(path)
    table = log.to_pandas("HV Voltage", SIGNAL)
    assert table.fillna(-1).to_numpy().tolist() == [[1.0, 18.0, -1], [1.5, 18.0, 100], [2.0, 19.0, 200], [3.0, 19.0, 300]]
    assert log.to_pandas("HV Voltage", period=0.5)["HV Voltage"].tolist() == [18, 18, 19]
    log.save(tmp_path / "side.csv", "HV Voltage")
    assert (tmp_path / "side.csv").read_text().splitlines() == ["time,HV Voltage", "1.0,18.0", "2.0,19.0"]
    log["MEASUREMENT_2"].save(tmp_path / "side.parquet")
    assert list(log.to_pandas())[:3] == ["time", "HV Voltage", "HV Current"]
    assert list(log.frames.to_pandas()["data"])[1] == bytes([0, 100, 0, 0, 0, 0, 0, 0])
    with pytest.raises(narx.SignalError, match='"MEASUREMENT_2" is a message'):
        log.to_pandas("MEASUREMENT_2")
    with pytest.raises(narx.ParameterError, match="must be one of .csv, .parquet, .xlsx$"):
        log.save(tmp_path / "side.txt")
