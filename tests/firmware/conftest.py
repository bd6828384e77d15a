"""The virtual drive in the emulator, and a master on its bus: python-can's slcan through a TCP port."""

import contextlib
import os
import socket
import subprocess
import tempfile
import time

import can
import narx
import pytest

WALL_SECONDS = 300
"""Limit of a test's duration, in seconds of wall time, on a machine of any speed."""
BROADCAST_SECONDS = 0.05
"""Time between two status words (parameter 111), in the drive's time."""

REQUEST_WORD, MOTOR_CMD, REBOOT = 0x0AAD5202, 0x0AAD5266, 0x0AAD5265
PARAMETER_REQUEST, PARAMETER_SET, PARAMETER = 0x0AAD546E, 0x0AAD526E, 0x1552A86E
LOG_DATA = 0x1552A88C
REBOOT_ACKNOWLEDGED, STATUS_WORD, FAULT_WORD, MEASUREMENT_5 = 0x1552A865, 0x1552A803, 0x1552A804, 0x1552A8CD
XML_DOWNLOAD_REQUEST, XML_DOWNLOAD_ANSWER, XML_DOWNLOAD_DATA = 0x0AAD5482, 0x1552A882, 0x1552A883
STATE, RESET_CAUSE, FAILED_SELF_TESTS = 261, 302, 303


class Master:
    """Sends request word and set-point every 50 ms, and stores the frames that the drive sends."""

    def __init__(self, bus):
        self.bus = bus
        self.mode = None
        """Motor mode of the request word; None sends no request word."""
        self.rpm = 0
        self.seen = {}
        """Data of the last frame of every identifier."""
        self.log = []
        """Data of all frames of a log download."""
        self.broadcasts = 0
        self._due = 0.0
        self._deadline = time.monotonic() + WALL_SECONDS

    @property
    def speed(self):
        return int.from_bytes(self.seen[MEASUREMENT_5][0:2], "big", signed=True)

    def send(self, identifier, *words):
        data = b"".join(word.to_bytes(2, "big") for word in words)
        self.bus.send(can.Message(arbitration_id=identifier, data=data.ljust(8, b"\0"), is_extended_id=True))

    def pump(self):
        """Sends request word and set-point when they are due, and receives one frame if one is waiting."""
        assert time.monotonic() < self._deadline, f"{WALL_SECONDS} s are over"
        if self.mode is not None and time.monotonic() >= self._due:
            self._due = time.monotonic() + 0.05
            self.send(MOTOR_CMD, self.rpm)
            self.send(REQUEST_WORD, 0, self.mode)
        message = self.bus.recv(0.01)
        if message is not None:
            self.seen[message.arbitration_id] = bytes(message.data)
            if message.arbitration_id == LOG_DATA:
                self.log.append(bytes(message.data))
            self.broadcasts += message.arbitration_id == STATUS_WORD
        return message

    def wait(self, seconds, until, what):
        """Waits until the condition holds, for at most `seconds` of the drive's time."""
        start = self.broadcasts
        while not until():
            self.pump()
            assert (self.broadcasts - start) * BROADCAST_SECONDS <= seconds, f"no {what} after {seconds} s of drive time"

    def run(self, seconds):
        """Waits for `seconds` of the drive's time."""
        start = self.broadcasts
        while (self.broadcasts - start) * BROADCAST_SECONDS < seconds:
            self.pump()

    def parameter(self, number, seconds=0.5):
        """Reads a parameter.

        Repeats the request with every broadcast: a frame that arrives while the drive reboots is lost.
        """
        self.seen.pop(PARAMETER, None)
        asked = None

        def answered():
            nonlocal asked
            if not self.answers(number) and asked != self.broadcasts:
                asked = self.broadcasts
                self.send(PARAMETER_REQUEST, number)
            return self.answers(number)

        self.wait(seconds, answered, f"answer about parameter {number}")
        answer = self.seen[PARAMETER]
        assert answer[6:8] == b"\0\0"
        return int.from_bytes(answer[2:6], "big", signed=True)

    def write(self, number, value, seconds=1.0):
        """Writes a parameter and returns word 3 of the answer, its status."""
        self.seen.pop(PARAMETER, None)
        self.send(PARAMETER_SET, number, value >> 16 & 0xFFFF, value & 0xFFFF)
        self.wait(seconds, lambda: self.answers(number), f"answer to the write of parameter {number}")
        return int.from_bytes(self.seen[PARAMETER][6:8], "big")

    def answers(self, number):
        """Returns whether the last answer is about this parameter.

        It can also be a late answer to an earlier request that was repeated.
        """
        return PARAMETER in self.seen and int.from_bytes(self.seen[PARAMETER][0:2], "big") == number

    def wait_for_state(self, state, seconds):
        self.wait(seconds, lambda: self.parameter(STATE) == state, f"state {state}")


@pytest.fixture
def master(request):
    """A master on the bus of the virtual drive; the marker `arguments`, or a parameter, gives arguments for the image."""
    marker = request.node.get_closest_marker("arguments")
    with virtual_drive(*(marker.args if marker else getattr(request, "param", ()))) as bus:
        yield Master(bus)


def pytest_configure(config):
    config.addinivalue_line("markers", "arguments(*words): what the image is started with")


def virtual_drive(*arguments):
    return running(with_arguments(*arguments))


def with_arguments(*arguments):
    # The arguments stand behind the image's own name in an option of the emulator.
    return os.environ["NARX_QEMU"].replace(",arg=qemu", ",arg=".join([",arg=qemu", *arguments]))


def with_bootloader(flash):
    """Returns the command that runs the emulator on this flash, from power-up until it is killed."""
    return os.environ["NARX_QEMU_BOOTLOADER"].replace("{flash}", str(flash))


class Emulator:
    """The emulator, running an image from power-up until `cut`.

    The command comes from `cargo xtask` with one word a line; `{port}` in it stands for the TCP port.
    """

    def __init__(self, command):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        self.bus = {
            "interface": "slcan",
            "channel": f"socket://127.0.0.1:{port}",
            "bitrate": 500_000,
            "sleep_after_open": 0.0,
        }
        """Arguments for python-can that open this bus."""
        self._output = tempfile.TemporaryFile()
        words = command.replace("{port}", str(port)).split("\n")
        self._process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=self._output)

    def connect(self, opened, **options):
        """Opens a bus or a drive as soon as the emulator has opened its port."""
        deadline = time.monotonic() + 30
        while True:
            try:
                return opened(**self.bus, **options)
            except (can.CanInitializationError, narx.BusError) as error:
                if isinstance(error, narx.BusError) and not isinstance(error.__cause__, can.CanError):
                    raise
                assert self._process.poll() is None, f"the emulator ended with {self._process.returncode}"
                assert time.monotonic() < deadline, "the emulator opens no port"
                time.sleep(0.05)

    def said(self):
        """Returns everything that the image has printed."""
        # The emulator writes at the position of the shared file description, which must not move.
        output = self._output.fileno()
        return os.pread(output, os.fstat(output).st_size, 0).decode()

    def cut(self):
        """Cuts the power."""
        self._process.kill()
        self._process.wait()


@contextlib.contextmanager
def powered(command):
    """Runs an emulator, and prints the image's output at the end: pytest shows it if the test fails."""
    emulator = Emulator(command)
    try:
        yield emulator
    finally:
        emulator.cut()
        print(emulator.said())


@contextlib.contextmanager
def running(command):
    """Runs an image and yields its bus."""
    with powered(command) as emulator:
        bus = emulator.connect(can.Bus)
        try:
            yield bus
        finally:
            bus.shutdown()


@contextlib.contextmanager
def operated(command):
    """Yields a drive of the Python package and the emulator that runs it."""
    # On a busy host the self-tests of the drive can take long.
    with powered(command) as emulator, emulator.connect(narx.connect, timeout=60.0) as drive:
        assert drive.wait_for(lambda: drive.state is narx.State.STANDBY, 60.0)
        yield drive, emulator


def spin(drive, rpm):
    """Starts the motor through the Python package, even if the drive's time is slower than wall time."""
    drive.start(rpm)
    assert drive.state is narx.State.HALL_CLOSED_LOOP


def run_for_a_broadcast(drive):
    """Waits for two voltages that the drive sends from now on: its own time between two of them has passed."""
    for _ in range(2):
        last = drive.measurements.full("HV Voltage").time
        assert drive.wait_for(lambda last=last: drive.measurements.full("HV Voltage").time > last, timeout=60.0)
