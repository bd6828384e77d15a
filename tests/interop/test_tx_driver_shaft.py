"""TX-Drivers at a shaft that the drive turns: both protocols on one bus, and PDOs with changing values."""

import can
import pytest
from tx_driver import PDO1, PRE_OPERATIONAL, START
from virtual_drive import DATABASE

NODE = 2
RPM = 1900
"""Speed of the shaft, rpm.

The way between two PDOs is no simple fraction of a revolution, which would repeat the same angles.
"""
COUNTS = 4096
"""Counts of the encoder in a revolution."""
UPDATE_MS = 5
SYNC_ENCODER = 2
"""Bit of the Can Config Register (table 7)."""
ROTARY, REVERSE = 2, 4
"""Bits of the Basic Config Register (table 8)."""
MM = 2**19
"""Raw value of 1 mm in a position of 3 bytes (section 3.1)."""
STEP = RPM / 60 * COUNTS * UPDATE_MS / 1000
"""Counts from one PDO1 to the next."""


class Motor:
    """A master of the drive, on a connection of its own."""

    def __init__(self, drive):
        self.bus = drive.bus()
        self.request = self.bus.send_periodic(message("REQUEST_WORD", 0), 0.04)
        self.set_point = self.bus.send_periodic(message("MOTOR_CMD_SET", RPM << 48), 0.04)

    def turn(self):
        # The low byte of the high word requests Drive.
        self.request.modify_data(message("REQUEST_WORD", 1 << 32))

    def end(self):
        for task in (self.request, self.set_point):
            task.stop()
            task.thread.join()
        self.bus.shutdown()


def message(name, data):
    identifier = DATABASE.get_message_by_name(name).frame_id
    return can.Message(arbitration_id=identifier, data=data.to_bytes(8, "big"), is_extended_id=True)


@pytest.fixture
def turning(master):
    """A node with two channels and an encoder, at a shaft that has reached its speed."""
    # Speed 1 is real time: the drive's master sends by the clock.
    master = master(f"{NODE}:dual", speed="1")
    node = master.node(NODE, "dual-encoder")
    motor = Motor(master.drive)
    configure(master, node, ROTARY)
    master.let_pass(0.3)
    motor.turn()
    for _ in range(20):
        if abs(sum(steps(positions(master, 100), COUNTS)) - 99 * STEP) < 0.01 * 99 * STEP:
            break
    yield master, node
    motor.end()


def configure(master, node, register, **entries):
    """Configures the encoder, and starts the node with a PDO1 every 5 ms.

    Returns the number of frames that were received before the start.
    """
    master.command(PRE_OPERATIONAL, node.id)
    node.sdo["Can Config Register"].raw = SYNC_ENCODER
    node.sdo["Basic Config Register"].raw = register
    node.sdo["Update Time"].raw = UPDATE_MS
    for name, value in entries.items():
        node.sdo[name.replace("_", " ")].raw = value
    since = master.now
    master.command(START, node.id)
    return since


def positions(master, count, since=None):
    """Returns position 1, position 2 and encoder of `count` PDO1s, in the order of figure 5."""
    frames = master.wait(PDO1 + NODE, master.now if since is None else since, count)[:count]
    return [tuple(int.from_bytes(data[a:b], "little", signed=True) for a, b in ((0, 3), (3, 6), (6, 8))) for data in frames]


def steps(readings, revolution):
    """Returns the steps of a rotary encoder between readings, each in the shorter direction."""
    half = revolution // 2
    counts = [reading[2] for reading in readings]
    return [(after - before + half) % revolution - half for before, after in zip(counts, counts[1:])]


def test_the_encoder_counts_what_the_drive_turns(turning):
    master, node = turning
    way = sum(steps(positions(master, 201), COUNTS))
    assert abs(way / (200 * STEP) - 1) < 0.01
    assert {0 <= reading[2] < COUNTS for reading in positions(master, 50)} == {True}
    configure(master, node, ROTARY | REVERSE)
    way = sum(steps(positions(master, 201), COUNTS))
    assert abs(way / (200 * STEP) + 1) < 0.01
    # python-canopen decodes the same encoder value from the PDO.
    seen = []
    node.tpdo[1].add_callback(lambda pdo: seen.append((bytes(pdo.data), pdo["Encoder"].raw, pdo["Position 2"].raw)))
    positions(master, 20)
    for data, encoder, position in list(seen)[:20]:
        assert (encoder, position) == (int.from_bytes(data[6:8], "little", signed=True), int.from_bytes(data[3:6], "little", signed=True))
    assert len(seen) > 10


def test_counts_of_a_revolution_are_those_of_the_entry(turning):
    master, node = turning
    configure(master, node, ROTARY, Counts_Per_Revolution=1500)
    readings = positions(master, 201)
    counts = [reading[2] for reading in readings]
    assert 0 <= min(counts) < 100 and 1400 < max(counts) < 1500
    assert abs(sum(steps(readings, 1500)) / (200 * STEP) - 1) < 0.01


@pytest.mark.parametrize("register, end", [(0, 2**15 - 1), (REVERSE, -(2**15))])
def test_a_linear_encoder_stops_at_its_end_and_is_reset(turning, register, end):
    master, node = turning
    configure(master, node, register)
    master.let_pass(0.3)
    assert {reading[2] for reading in positions(master, 50)} == {end}, "eight revolutions are long over"
    since = configure(master, node, register, Reset_Encoder=0)
    counts = [abs(reading[2]) for reading in positions(master, 100, since)]
    # Some 50 ms after the reset the encoder counts from 0 again, and this is its count so far.
    assert counts[0] < 2**14
    moving = [count for count in counts if count < abs(end)]
    ways = [after - before for before, after in zip(moving, moving[1:])]
    assert len(ways) > 10 and all(abs(way - STEP) < 0.02 * STEP for way in ways)
    assert counts[-1] == abs(end)


def test_the_displacement_is_the_shafts(turning):
    master, _ = turning
    readings = positions(master, 400)
    first, second = ({}, {})
    for position1, position2, counts in readings:
        first.setdefault(counts // 128, []).append(position1 / MM)
        second.setdefault(counts // 128, []).append(position2 / MM)
    assert sorted(first) == list(range(32)), "all around"
    # Every angle of the shaft has one distance; the distance changes by less than 1 um a degree.
    for around in (first, second):
        assert all(max(seen) - min(seen) < 0.010 for seen in around.values())
        shown = [sum(seen) / len(seen) for seen in around.values()]
        assert 0.03 < max(shown) - min(shown) < 0.1
        assert abs(sum(shown) / len(shown) - 1.0) < 0.01
    # The second sensor sees a quarter of a revolution later what the first one sees.
    means = [{place: sum(seen) / len(seen) for place, seen in around.items()} for around in (first, second)]
    late, early = ([abs(means[1][place] - means[0][(place + shift) % 32]) for place in range(32)] for shift in (-8, 8))
    assert max(late) < 0.004 < max(early)
