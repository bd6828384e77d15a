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
"""Nothing takes longer, on however slow a machine."""
BROADCAST_SECONDS = 0.05
"""Between two status words (parameter 111), in the drive's time."""

REQUEST_WORD, MOTOR_CMD, REBOOT = 0x0AAD5202, 0x0AAD5266, 0x0AAD5265
PARAMETER_REQUEST, PARAMETER_SET, PARAMETER = 0x0AAD546E, 0x0AAD526E, 0x1552A86E
LOG_DATA = 0x1552A88C
REBOOT_ACKNOWLEDGED, STATUS_WORD, FAULT_WORD, MEASUREMENT_5 = 0x1552A865, 0x1552A803, 0x1552A804, 0x1552A8CD
XML_DOWNLOAD_REQUEST, XML_DOWNLOAD_ANSWER, XML_DOWNLOAD_DATA = 0x0AAD5482, 0x1552A882, 0x1552A883
STATE, RESET_CAUSE, FAILED_SELF_TESTS = 261, 302, 303


class Master:
    """Sends request and set-point every 50 ms, and remembers what the drive says."""

    def __init__(self, bus):
        self.bus = bus
        self.mode = None
        """Motor mode of the request word; None sends nothing."""
        self.rpm = 0
        self.seen = {}
        """The last data of every identifier."""
        self.log = []
        """The data of all frames of a log download."""
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
        """Keeps the drive informed, and takes a frame if there is one."""
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
        """Until the condition holds, for at most so many seconds of the drive's time."""
        start = self.broadcasts
        while not until():
            self.pump()
            assert (self.broadcasts - start) * BROADCAST_SECONDS <= seconds, f"no {what} after {seconds} s of drive time"

    def run(self, seconds):
        """Lets the drive's time pass."""
        start = self.broadcasts
        while (self.broadcasts - start) * BROADCAST_SECONDS < seconds:
            self.pump()

    def parameter(self, number, seconds=0.5):
        """Reads a parameter; asks anew with every broadcast, for a drive that reboots loses what arrives meanwhile."""
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
        """Writes a parameter; word 3 of the answer."""
        self.seen.pop(PARAMETER, None)
        self.send(PARAMETER_SET, number, value >> 16 & 0xFFFF, value & 0xFFFF)
        self.wait(seconds, lambda: self.answers(number), f"answer to the write of parameter {number}")
        return int.from_bytes(self.seen[PARAMETER][6:8], "big")

    def answers(self, number):
        """Whether the last answer is about this parameter; one may be a late answer to a question that was asked twice."""
        return PARAMETER in self.seen and int.from_bytes(self.seen[PARAMETER][0:2], "big") == number

    def wait_for_state(self, state, seconds):
        self.wait(seconds, lambda: self.parameter(STATE) == state, f"state {state}")


@pytest.fixture
def master(request):
    """A test marked with `arguments` gives them to the image."""
    marker = request.node.get_closest_marker("arguments")
    with virtual_drive(*(marker.args if marker else ())) as bus:
        yield Master(bus)


def pytest_configure(config):
    config.addinivalue_line("markers", "arguments(*words): what the image is started with")


def virtual_drive(*arguments):
    return running(with_arguments(*arguments))


def with_arguments(*arguments):
    # They stand behind the image's own name in an option of the emulator.
    return os.environ["NARX_QEMU"].replace(",arg=qemu", ",arg=".join([",arg=qemu", *arguments]))


def with_bootloader(flash):
    """The command for the emulator on this flash, from power-up until it is killed."""
    return os.environ["NARX_QEMU_BOOTLOADER"].replace("{flash}", str(flash))


class Emulator:
    """An image that a developer command knows how to start, one word a line with {port} in it: under power until it is cut."""

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
        """How python-can finds its bus."""
        self._output = tempfile.TemporaryFile()
        words = command.replace("{port}", str(port)).split("\n")
        self._process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=self._output)

    def connect(self, opened, **options):
        """A bus or a drive, as soon as the port is open."""
        deadline = time.monotonic() + 30
        while True:
            try:
                return opened(**self.bus, **options)
            except can.CanInitializationError:
                assert self._process.poll() is None, f"the emulator ended with {self._process.returncode}"
                assert time.monotonic() < deadline, "the emulator opens no port"
                time.sleep(0.05)

    def said(self):
        """What the image has printed."""
        # The emulator writes at the file's own position, which must stay where it is.
        output = self._output.fileno()
        return os.pread(output, os.fstat(output).st_size, 0).decode()

    def cut(self):
        """Cuts the power."""
        self._process.kill()
        self._process.wait()


@contextlib.contextmanager
def powered(command):
    """An emulator; what its image has said is shown with a test that fails."""
    emulator = Emulator(command)
    try:
        yield emulator
    finally:
        emulator.cut()
        print(emulator.said())


@contextlib.contextmanager
def running(command):
    """The bus of an image."""
    with powered(command) as emulator:
        bus = emulator.connect(can.Bus)
        try:
            yield bus
        finally:
            bus.shutdown()


@contextlib.contextmanager
def operated(command):
    """A drive of the Python package and the emulator that it runs in."""
    # A host that is busy may let the drive's self-tests take long.
    with powered(command) as emulator, emulator.connect(narx.connect, timeout=60.0) as drive:
        assert drive.wait_for(lambda: drive.state is narx.State.STANDBY, 60.0)
        yield drive, emulator


def spin(drive, rpm):
    """Starts the motor of the Python package's drive, however much slower than the wall's its time passes."""
    drive.start(rpm)
    assert drive.state is narx.State.HALL_CLOSED_LOOP
