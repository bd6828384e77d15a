"""The virtual drive as a bus of python-can, and masters on it."""

import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import can
import pytest
from can.interfaces.virtual import VirtualBus

import narx
from narx.bus import NarxBus

OPTIONS: dict[str, Any] = {"motor": "ec45-flat-50w-18v", "supply_voltage": 18.0, "mode": "hall"}
STATUS = can.Message(arbitration_id=0x1552A803, is_extended_id=True, data=bytes(8))
STANDBY = can.Message(arbitration_id=0x0055AA82, is_extended_id=True, data=bytes(8))


@pytest.fixture
def bus(request: pytest.FixtureRequest) -> Iterator[can.BusABC]:
    """A virtual drive whose time advances while a client receives."""
    with can.Bus(interface="narx", channel=request.node.name, realtime=False, **OPTIONS) as bus:
        yield bus


def test_time_passes_by_receiving(bus: can.BusABC) -> None:
    assert isinstance(bus, NarxBus) and bus.time == 0.0
    bus.set_filters([{"can_id": 0x123, "can_mask": 0x7FF, "extended": False}])
    assert bus.recv(0.25) is None and bus.time == pytest.approx(0.25)
    bus.set_filters(None)
    bus.send(STANDBY)
    received = [bus.recv(1.0) for _ in range(50)]
    stamps = [message.timestamp for message in received if message is not None]
    assert len(stamps) == 50 and stamps == sorted(stamps) and stamps[-1] <= bus.time < 10.0


def test_filters_hold_without_the_clock(bus: can.BusABC) -> None:
    bus.set_filters([{"can_id": 3, "can_mask": 0x1FF, "extended": True}])
    message = bus.recv(5.0)
    assert message is not None and message.arbitration_id & 0x1FF == 3
    bus.set_filters([{"can_id": 0x123, "can_mask": 0x7FF, "extended": False}])
    before = bus.recv(0.0), narx.decode(message)
    assert before[0] is None and before[1] is not None and before[1].name == "STATUS_WORD"
    assert bus.recv(0.5) is None


def test_a_listener_does_not_let_time_pass(bus: can.BusABC) -> None:
    assert isinstance(bus, NarxBus)
    seen: list[can.Message] = []
    with narx.Drive(bus) as drive, can.Bus(interface="narx", channel="test_a_listener_does_not_let_time_pass", realtime=False) as other:
        drive.start(2000)
        notifier = can.Notifier(other, [seen.append], timeout=0.01)
        try:
            before = bus.time
            # The drive would be in Fault after 1 s without a set-point.
            time.sleep(0.2)
            assert bus.time == before
            drive.wait(2.0)
            assert drive.state is narx.State.HALL_CLOSED_LOOP and not drive.faults
        finally:
            notifier.stop()
        passed = [narx.decode(message) for message in seen]
        assert {"MOTOR_CMD", "STATUS_WORD"} <= {message.name for message in passed if message is not None}


def test_each_master_sends_while_another_one_waits() -> None:
    options = OPTIONS | {"channel": "two masters", "realtime": False, "tx_drivers": [2]}
    with can.Bus(interface="narx", **options) as bus, can.Bus(interface="narx", channel="two masters", realtime=False) as other:
        with narx.Drive(bus) as drive, narx.TxDriver(other, 2) as tx:
            drive.start(2000)
            tx.start()
            assert len(tx.record(5.0, period=0.01)) > 400
            drive.wait(0.1)
            assert drive.state is narx.State.HALL_CLOSED_LOOP and not drive.faults
        # Without a master time passes again while anybody receives.
        assert isinstance(other, NarxBus)
        before = other.time
        while other.recv(0.0) is not None:
            pass
        assert other.recv(1.0) is not None and other.time > before


def test_a_drive_and_a_listener_do_not_share_a_bus(bus: can.BusABC) -> None:
    notifier = can.Notifier(bus, [], timeout=0.01)
    try:
        with pytest.raises(narx.RefusedError, match="a can.Notifier reads this bus: without realtime the drive and a listener need a can.Bus each"):
            narx.Drive(bus)
    finally:
        notifier.stop()


def test_a_calibration_is_waited_for_on_a_bus_too(bus: can.BusABC) -> None:
    # On a bus the master does not know the state between a status word and the answer about the exact state.
    drive = narx.Drive(bus, read_parameters=False)
    drive.calibrate_hall(run=True)
    assert drive.parameters["Hall calibration state"] == 2 and drive.state is narx.State.STANDBY
    drive.close()


def test_clients_of_a_channel_share_one_drive(bus: can.BusABC) -> None:
    with can.Bus(interface="narx", channel="test_clients_of_a_channel_share_one_drive") as other:
        bus.send(STANDBY)
        received = other.recv(1.0)
        assert received is not None
        while received is not None and received.arbitration_id != STANDBY.arbitration_id:
            received = other.recv(1.0)
        assert received is not None and bytes(received.data) == bytes(8)
        # A client does not receive its own frames.
        own = [bus.recv(0.0) for _ in range(200)]
        assert all(message is None or message.arbitration_id != STANDBY.arbitration_id for message in own)


def test_another_drive_cannot_have_the_channel(bus: can.BusABC) -> None:
    channel = bus.channel_info.split(": ")[1]
    with pytest.raises(can.CanInitializationError, match="is there already, with other options"):
        can.Bus(interface="narx", channel=channel, supply_voltage=24.0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"bitrate": 250_000}, "bitrate 250000: the drive's bus has 500000"),
        ({"moter": "bly172s-24v"}, 'there is no option "moter"; did you mean "motor".*; there are channel, .*, drives$'),
        ({"fd": True}, "fd True: the drive's bus has no CAN FD"),
        ({"motor": "nema17"}, 'there is no preset "nema17"'),
        ({"supply_voltage": 12.0}, "supply voltage 12 V is outside 18 to 60 V"),
    ],
)
def test_a_bus_that_cannot_be(options: dict[str, Any], message: str) -> None:
    with pytest.raises(can.CanInitializationError, match=message):
        can.Bus(interface="narx", channel="cannot be", **options)


def test_options_of_every_bus_of_python_can_are_allowed() -> None:
    # `python -m can.logger` passes them to whatever interface it opens.
    generic: dict[str, Any] = {"single_handle": True, "fd": False, "data_bitrate": None, "timing": None, "can_filters": None}
    with can.Bus(interface="narx", channel="generic", bitrate=500_000, realtime=False, **generic, **OPTIONS) as bus:
        assert bus.recv(1.0) is not None


def test_the_clock_paces_a_real_time_bus() -> None:
    with can.Bus(interface="narx", channel="paced", **OPTIONS) as bus:
        assert isinstance(bus, NarxBus)
        first, begin = bus.time, time.monotonic()
        time.sleep(0.5)
        simulated, real = bus.time - first, time.monotonic() - begin
        assert simulated == pytest.approx(real, abs=0.25)


def test_connect_operates_and_lets_go() -> None:
    with narx.connect("narx", "connected", **OPTIONS) as drive:
        drive.start(2000)
        threads = {thread.name for thread in threading.enumerate()}
        assert "narx master" in threads and drive.state is narx.State.HALL_CLOSED_LOOP
        with can.Bus(interface="narx", channel="connected") as listener:
            seen = {message.name for message in decoded(listener, 0.3)}
            assert {"MOTOR_CMD", "REQUEST_WORD", "STATUS_WORD", "MEASUREMENT_0"} <= seen
            drive.close()
            modes = [message["Motor mode"] for message in decoded(listener, 0.3) if message.name == "STATUS_WORD"]
    # Closing the drive has stopped the motor.
    assert modes[-1] == "Standby"
    assert "narx master" not in {thread.name for thread in threading.enumerate()}
    with pytest.raises(narx.BusError, match="closed"):
        drive.info  # noqa: B018


def test_nobody_answers() -> None:
    begin = time.monotonic()
    with pytest.raises(narx.NoAnswerError, match="no frame of drive 170 was received on virtual nobody within 0.5 s"):
        narx.connect("virtual", "nobody", timeout=0.5)
    assert time.monotonic() - begin < 5.0


def test_a_silent_master_sends_nothing() -> None:
    with can.Bus(interface="virtual", channel="silent") as bus, can.Bus(interface="virtual", channel="silent") as tap:
        with narx.Drive(bus, silent=True) as drive:
            tap.send(STATUS)
            assert drive.wait_for(lambda: drive.connected, 1.0) and drive.status["Motor mode"] == "Standby"
            commands: list[Callable[[], object]] = [
                lambda: drive.start(1000, wait=False), lambda: drive.set_speed(1000), drive.stop, drive.shut_down, lambda: drive.parameters[78],
            ]  # fmt: skip
            for command in commands:
                with pytest.raises(narx.RefusedError, match="the master is silent"):
                    command()
            drive.wait(0.3)
        assert tap.recv(0.2) is None


def test_a_drive_on_the_same_machine_is_received() -> None:
    """Frames of another program on the same machine are accepted.

    Drivers mark such frames like own ones, for example on a `vcan`.
    """

    class Local(VirtualBus):
        def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
            message, filtered = super()._recv_internal(timeout)
            if message is not None:
                message.is_rx = False
            return message, filtered

    with Local(channel="local") as bus, VirtualBus(channel="local") as tap, narx.Drive(bus, silent=True) as drive:
        tap.send(STATUS)
        assert drive.wait_for(lambda: drive.connected, 1.0)


def test_a_lost_adapter_is_told() -> None:
    class Broken(VirtualBus):
        broken = False

        def send(self, msg: can.Message, timeout: float | None = None) -> None:
            if self.broken:
                raise can.CanOperationError("no such device")
            super().send(msg, timeout)

    with Broken(channel="broken") as bus:
        drive = narx.Drive(bus)
        drive.wait(0.1)
        bus.broken = True
        with pytest.raises(narx.BusError, match="the bus does not work any more: no such device"):
            drive.wait(1.0)
        with pytest.raises(narx.BusError):
            drive.start(1000)
        with pytest.raises(narx.BusError):
            drive.close()


def test_an_adapter_that_cannot_be_read_any_more_is_told() -> None:
    class Broken(VirtualBus):
        broken = False

        def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
            if self.broken:
                raise can.CanOperationError("unplugged")
            return super()._recv_internal(timeout)

    with Broken(channel="unplugged") as bus, narx.Drive(bus, silent=True) as drive:
        drive.wait(0.01)
        bus.broken = True
        with pytest.raises(narx.BusError, match="the bus does not work any more: unplugged"):
            drive.wait(5.0)


def decoded(bus: can.BusABC, seconds: float) -> list[narx.Message]:
    """Returns the messages that pass within `seconds`."""
    end = time.monotonic() + seconds
    messages = []
    while (left := end - time.monotonic()) > 0:
        frame = bus.recv(left)
        message = None if frame is None else narx.decode(frame)
        if isinstance(message, narx.Message):
            messages.append(message)
    return messages


def test_several_drives_have_motors_and_loads_of_their_own(request: pytest.FixtureRequest) -> None:
    further = [
        {"motor": "bly172s-24v", "mode": "hall", "load": narx.Load(constant=0.05)},
        {"motor": "ec45-flat-50w-18v", "mode": "hall", "slave": 200, "seed": 7, "parameters": {"Phase current limit": 4.0}},
    ]
    shared: dict[str, Any] = {"interface": "narx", "channel": request.node.name, "realtime": False}
    with can.Bus(**shared, **OPTIONS, tx_drivers=[2], drives=further) as bus, can.Bus(**shared) as second, can.Bus(**shared) as third, can.Bus(**shared) as fourth:
        with narx.Drive(bus) as one, narx.Drive(second, slave=171) as two, narx.Drive(third, slave=200) as three, narx.TxDriver(fourth, 2) as tx:
            for drive, rpm in ((one, 1000), (two, 2000), (three, -1500)):
                drive.start(rpm)
            tx.start()
            one.wait(1.0)
            # Each master reads its own bus when it waits.
            two.wait(0.05)
            three.wait(0.05)
            for drive, rpm in ((one, 1000), (two, 2000), (three, -1500)):
                assert drive.state is narx.State.HALL_CLOSED_LOOP and not drive.faults
                assert drive.measurements.speed == pytest.approx(rpm, rel=0.02)
            currents = [drive.measurements["HV Current"] for drive in (one, two)]
            assert currents[1] > currents[0] + 0.2 and two.measurements["HV Voltage"] == pytest.approx(24, abs=0.5)
            assert three.info.address == 200 and three.parameters["Phase current limit"] == 4.0
            assert two.parameters["Phase current limit"] != 4.0 and len(tx.positions) == 1
            # One stops, the others go on.
            two.stop()
            one.wait(0.5)
            two.wait(0.05)
            three.wait(0.05)
            assert two.state is narx.State.STANDBY and three.state is narx.State.HALL_CLOSED_LOOP


def test_further_drives_that_cannot_be_are_named(request: pytest.FixtureRequest) -> None:
    for drives, message in [
        ([{"moto": "x"}], 'drives: there is no option "moto"; did you mean "motor"'),
        ([{"slave": 256}], "slave 256: must be a whole number from 0 to 255"),
        ([5], "drives 5: must be dictionaries"),
        (5, "drives 5: must be a list"),
        ([{"motor": "x"}], 'there is no preset "x"'),
    ]:
        with pytest.raises(can.CanInitializationError, match=message):
            can.Bus(interface="narx", channel=request.node.name, drives=drives, **OPTIONS)
