"""A master of TX-Drivers on the virtual drive's bus: python-canopen, and python-can for what that cannot send or read.

Time on the bus is told by the drive's own status words, so nothing here depends on how fast the simulation runs.
"""

import math
import threading
import time

import can
import canopen
from virtual_drive import BROADCAST_SECONDS, DATABASE, ROOT

# Table 3 of the eddyCAN specification.
NMT, SYNC, ERROR, PDO1, PDO2, PDO3, ANSWER, REQUEST, HEARTBEAT = (
    0x000, 0x080, 0x080, 0x180, 0x280, 0x380, 0x580, 0x600, 0x700,
)  # fmt: skip
# Table 11.
START, STOP, PRE_OPERATIONAL, RESET = 0x01, 0x02, 0x80, 0x81
# Table 12.
BOOT_UP, IS_STOPPED, IS_OPERATIONAL, IS_PRE_OPERATIONAL = b"\x00", b"\x04", b"\x05", b"\x7f"
# Table 10.
COMMAND_UNKNOWN, NO_INDEX, NO_SUBINDEX, RANGE_EXCEEDED = 0x05040001, 0x06020000, 0x06090011, 0x06090030
WRITE_ONLY, READ_ONLY, GENERAL = 0x06010001, 0x06010002, 0x08000000

PATIENCE = 30.0
"""Seconds on the clock for what comes within milliseconds on the bus: other programs may have the machine."""

STATUS = DATABASE.get_message_by_name("STATUS_WORD").frame_id
PARAMETER = DATABASE.get_message_by_name("PARAMETER").frame_id


class Ears(can.Listener):
    """Keeps every frame in the order in which it passed."""

    def __init__(self):
        self.frames = []
        self.came = threading.Condition()

    def on_message_received(self, message):
        with self.came:
            self.frames.append(message)
            self.came.notify_all()

    def stop(self):
        pass


class Master:
    """One client of the virtual drive."""

    def __init__(self, drive):
        self.ears = Ears()
        self.network = canopen.Network(drive.bus())
        self.network.listeners.append(self.ears)
        self.network.connect()

    def close(self):
        self.network.disconnect()

    def node(self, number, layout="single"):
        """A TX-Driver with the EDS of what its PDOs carry."""
        node = self.network.add_node(number, str(ROOT / "docs" / f"eddycan-{layout}.eds"))
        node.sdo.RESPONSE_TIMEOUT = PATIENCE
        node.tpdo.read(from_od=True)
        return node

    def send(self, identifier, data=b""):
        """A data frame, by python-can."""
        self._send(can.Message(arbitration_id=identifier, data=data, is_extended_id=False))

    def send_remote(self, identifier, length):
        """A remote frame with a data length code of its own, which python-canopen cannot give it."""
        self._send(can.Message(arbitration_id=identifier, dlc=length, is_remote_frame=True, is_extended_id=False))

    def _send(self, message):
        with self.network.send_lock:
            self.network.bus.send(message)

    @property
    def now(self):
        """A place among the frames heard."""
        return len(self.ears.frames)

    def heard(self, identifier, since, until=None):
        """Data of all frames with an identifier from one place to another."""
        frames = self.ears.frames[since:until]
        return [bytes(frame.data) for frame in frames if frame.arbitration_id == identifier and not frame.is_remote_frame]

    def wait(self, identifier, since, count=1):
        """Data of the frames with an identifier, as soon as there are so many."""
        end = time.monotonic() + PATIENCE
        with self.ears.came:
            while len(found := self.heard(identifier, since)) < count:
                left = end - time.monotonic()
                assert left > 0, f"{len(found)} of {count} frames {identifier:03X}h after {PATIENCE} s"
                self.ears.came.wait(left)
        return found

    def let_pass(self, seconds):
        """Simulated time, by whole periods of the status word."""
        self.wait(STATUS, self.now, math.ceil(seconds / BROADCAST_SECONDS) + 1)

    def settle(self):
        """Until everything sent has passed over the bus and whoever has an answer has given it: a client's frames stay in order, and the drive answers,
        too."""
        since = self.now
        identifier = DATABASE.get_message_by_name("PARAMETER_REQUEST").frame_id
        self._send(can.Message(arbitration_id=identifier, data=bytes([0, 99]).ljust(8, b"\0"), is_extended_id=True))
        self.wait(PARAMETER, since)
        self.let_pass(BROADCAST_SECONDS)

    def ask(self, node, request):
        """The answer of a node to the 8 bytes of a request."""
        since = self.now
        self.send(REQUEST + node, request)
        return self.wait(ANSWER + node, since)[0]

    def command(self, command, target):
        """NMT by python-canopen, and until it has been obeyed."""
        nmt = self.network.nmt if target == 0 else self.network[target].nmt
        nmt.send_command(command)
        self.settle()

    def restart(self, node, number=None):
        """NMT reset; waits for the boot-up message of the node, which may have another number now."""
        since = self.now
        self.network[node].nmt.send_command(RESET)
        number = number or node
        assert self.wait(HEARTBEAT + number, since)[0] == BOOT_UP
        self.settle()
        return self.heard(HEARTBEAT + number, since)


def sdo(command, index, subindex=0, data=b""):
    """The 8 bytes of a request or an answer (figure 6)."""
    return bytes([command]) + index.to_bytes(2, "little") + bytes([subindex]) + data.ljust(4, b"\0")


def aborted(index, subindex, code):
    """An answer with an error code (section 3.3.3)."""
    return sdo(0x80, index, subindex, code.to_bytes(4, "little"))


def later(action, *arguments):
    """Does something while the caller already waits for what comes of it."""
    timer = threading.Timer(0.1, action, arguments)
    timer.start()
