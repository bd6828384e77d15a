"""The real firmware image, driven by an unmodified python-can through slcan."""

import xml.etree.ElementTree as ElementTree
import zlib

import pytest
from conftest import (
    BROADCAST_SECONDS,
    FAULT_WORD,
    MEASUREMENT_5,
    REBOOT,
    REBOOT_ACKNOWLEDGED,
    STATUS_WORD,
    XML_DOWNLOAD_ANSWER,
    XML_DOWNLOAD_DATA,
    XML_DOWNLOAD_REQUEST,
)

STANDBY_REQUEST, DRIVE_REQUEST = 0, 1
INITIALIZATION, STANDBY, HALL_CLOSED_LOOP = 0, 1, 5


@pytest.mark.parametrize("master", [(), ("--pwm-rate", "20000")], ids=["10 kHz", "20 kHz"], indirect=True)
def test_the_motor_starts_reaches_its_speed_and_stops(master):
    master.wait(1.0, lambda: STATUS_WORD in master.seen and FAULT_WORD in master.seen, "broadcast after power-up")
    assert MEASUREMENT_5 not in master.seen, "a drive without master sends no measurements"

    master.mode = STANDBY_REQUEST
    master.wait_for_state(STANDBY, 2.0)
    master.wait(0.2, lambda: MEASUREMENT_5 in master.seen, "measurement")
    assert master.speed == 0

    master.mode, master.rpm = DRIVE_REQUEST, 2000
    master.wait_for_state(HALL_CLOSED_LOOP, 0.2)
    master.wait(1.0, lambda: abs(master.speed - 2000) <= 20, "set-point")
    master.run(0.3)
    assert abs(master.speed - 2000) <= 20
    assert master.seen[STATUS_WORD][2:4] == b"\x03\x01", "hall closed loop, Drive"

    master.mode = STANDBY_REQUEST
    master.wait(2.0, lambda: master.speed == 0, "standstill")
    master.wait_for_state(STANDBY, 0.1)
    master.run(0.1)
    assert master.seen[STATUS_WORD] == b"\x01\x41" + bytes(6), "Standby; the log is erased, idle, and may be erased"
    assert master.seen[FAULT_WORD] == bytes(8), "no fault"


def test_the_drive_serves_its_description(master):
    master.wait(1.0, lambda: STATUS_WORD in master.seen, "broadcast after power-up")
    master.send(XML_DOWNLOAD_REQUEST, 0)
    master.wait(0.2, lambda: XML_DOWNLOAD_ANSWER in master.seen, "length")
    length = 2 * int.from_bytes(master.seen[XML_DOWNLOAD_ANSWER][0:2], "big")

    master.send(XML_DOWNLOAD_REQUEST, 1)
    start, text = master.broadcasts, bytearray()
    while len(text) < length:
        message = master.pump()
        if message is not None and message.arbitration_id == XML_DOWNLOAD_DATA:
            assert 2 * int.from_bytes(message.data[0:2], "big") == len(text)
            text += message.data[2:8]
        assert (master.broadcasts - start) * BROADCAST_SECONDS <= 4.0, f"{len(text)} of {length} bytes"
    assert not any(text[length:])

    description = ElementTree.fromstring(text[:length])
    assert (description.get("hardware"), description.get("rate")) == ("2", "10000")
    numbers = [int(row.get("number")) for row in description.findall("parameters/parameter")]
    assert numbers == sorted(set(numbers)) and set(range(122)) <= set(numbers)


def test_a_reboot_closes_no_channel(master):
    master.mode = STANDBY_REQUEST
    master.wait_for_state(STANDBY, 2.0)
    master.send(REBOOT, 0)
    master.wait(0.2, lambda: REBOOT_ACKNOWLEDGED in master.seen, "acknowledgement")
    assert master.seen[REBOOT_ACKNOWLEDGED][0:2] == b"\0\x01"
    master.wait_for_state(INITIALIZATION, 0.4)
    master.wait_for_state(STANDBY, 2.0)


def test_what_is_stored_outlives_a_reboot_and_what_is_logged_comes_down(master):
    master.mode = STANDBY_REQUEST
    master.wait_for_state(STANDBY, 2.0)
    assert master.write(99, 1234) == 0
    assert master.write(72, 20) == 0, "a record every 20 ms"
    assert master.write(29, 0x2000 + 202 * 4) == 0, "of the bus voltage"
    assert master.write(256, 0) == 0
    assert master.write(256, 1) == 0, "stored"
    assert master.write(98, 8000) == 0, "this one is stored by itself, before the restart at the latest"
    master.run(1.0)
    written = master.parameter(71)
    assert written > 20
    master.seen.clear()
    master.send(REBOOT, 0)
    master.wait(0.2, lambda: REBOOT_ACKNOWLEDGED in master.seen, "acknowledgement")
    master.wait_for_state(STANDBY, 2.0)
    assert (master.parameter(98), master.parameter(99)) == (8000, 1234)
    assert master.parameter(71) >= written, "the log goes on"

    assert master.write(68, 20) == 0
    assert master.write(75, 0) == 0
    master.log.clear()
    assert master.write(75, 1) == 0
    master.wait(2.0, lambda: len(master.log) >= 20 * 4, "download")
    assert [int.from_bytes(data[0:2], "big") for data in master.log] == [3 * place for place in range(80)]
    record = b"".join(data[2:8] for data in master.log[4:8])
    assert record[0:6] == b"\xaa\x55\0\0\0\x01" and record[22:24] == b"\x55\xaa"
    assert zlib.crc32(record[:18]) == int.from_bytes(record[18:22], "big")
    assert record[12:14] == (0x2000 + 202 * 4).to_bytes(2, "big")
    assert 2200 < int.from_bytes(record[14:18], "big") < 2600, "24 V"


def test_the_adapter_tells_its_version_and_serial_number(master):
    assert master.bus.get_version(30) == (10, 10)
    assert master.bus.get_serial_number(30) == "NARX"


def test_an_adapter_at_another_bitrate_receives_and_says_nothing(master):
    master.wait(1.0, lambda: STATUS_WORD in master.seen, "broadcast after power-up")
    master.bus.set_bitrate(250_000)
    # The adapter still answers, and its answer follows the frames that it had already queued.
    assert master.bus.get_version(30) == (10, 10)
    for _ in range(200):
        # This receives nothing, an older reply of the adapter, or one of the queued frames.
        master.bus.recv(0)
    for _ in range(100):
        assert master.bus.recv(0.02) is None
    master.seen.clear()
    master.bus.set_bitrate(500_000)
    master.wait(1.0, lambda: STATUS_WORD in master.seen, "broadcast")
