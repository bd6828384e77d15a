"""Files that the demo run writes, read by independent tools."""

import csv
import os
from pathlib import Path

import can

DEMO = Path(os.environ["NARX_INTEROP"]) / "demo"
REQUEST, STATUS, SPEED = 0x0AAD5202, 0x1552A803, 0x1552A8CD


def frames():
    with can.LogReader(DEMO / "run.log") as log:
        return list(log)


def test_every_line_of_the_log_is_a_frame():
    lines = (DEMO / "run.log").read_text().splitlines()
    read = frames()
    assert len(read) == len(lines) > 300
    assert all(frame.is_extended_id and frame.dlc == 8 for frame in read)
    assert all(a.timestamp <= b.timestamp for a, b in zip(read, read[1:]))


def test_the_drive_accepts_the_request_word():
    read = frames()
    drive = next(f for f in read if f.arbitration_id == REQUEST and f.data[3] == 1)
    assert bytes(drive.data) == bytes([0, 0, 0, 1, 0, 0, 0, 0])
    control_modes = [f.data[2] & 15 for f in read if f.arbitration_id == STATUS and f.timestamp > drive.timestamp + 0.06]
    assert set(control_modes) == {1, 2}, "started in open loop, then sensorless"
    assert control_modes == sorted(control_modes), "one start, without a restart"


def test_the_broadcast_speed_is_the_speed_of_the_csv():
    with open(DEMO / "run.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    last = [f for f in frames() if f.arbitration_id == SPEED][-1]
    broadcast = int.from_bytes(last.data[0:2], "big", signed=True)
    row = min(rows, key=lambda row: abs(float(row["time"]) - last.timestamp))
    assert abs(broadcast - float(row["speed_estimated"])) <= 20
    assert abs(broadcast - 2000) <= 40
    fixed = ["time", "setpoint", "speed", "speed_estimated", "state", "sector", "duty", "current_a", "current_b",
             "current_c", "bus_current", "bus_voltage", "torque"]
    assert list(rows[0])[: len(fixed)] == fixed
    assert len(rows) == 30_000, "1.5 s at 20 kHz"
