"""A master of TX-Drivers on the virtual drive's bus, made of python-canopen and python-can.

python-can sends and receives the frames that python-canopen does not support. The drive's status words
measure the time on the bus, so nothing here depends on the speed of the simulation.
"""

import math
import threading
import time

import can
import canopen
from virtual_drive import BROADCAST_SECONDS, DATABASE, ROOT

# Function codes (table 3 of the eddyCAN specification).
NMT, SYNC, ERROR, PDO1, PDO2, PDO3, ANSWER, REQUEST, HEARTBEAT = (
    0x000, 0x080, 0x080, 0x180, 0x280, 0x380, 0x580, 0x600, 0x700,
)  # fmt: skip
# NMT commands (table 11).
START, STOP, PRE_OPERATIONAL, RESET = 0x01, 0x02, 0x80, 0x81
# States in the heartbeat (table 12).
BOOT_UP, IS_STOPPED, IS_OPERATIONAL, IS_PRE_OPERATIONAL = b"\x00", b"\x04", b"\x05", b"\x7f"
# Abort codes of SDO (table 10).
COMMAND_UNKNOWN, NO_INDEX, NO_SUBINDEX, RANGE_EXCEEDED = 0x05040001, 0x06020000, 0x06090011, 0x06090030
WRITE_ONLY, READ_ONLY, GENERAL = 0x06010001, 0x06010002, 0x08000000

PATIENCE = 30.0
"""Time-out in seconds of wall time, for frames that follow within milliseconds on the bus.

It is long because the machine may be busy.
"""

STATUS = DATABASE.get_message_by_name("STATUS_WORD").frame_id
PARAMETER = DATABASE.get_message_by_name("PARAMETER").frame_id


class Ears(can.Listener):
    """Stores all frames in the order of their reception."""

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
    """A client of the virtual drive."""

    def __init__(self, drive):
        self.ears = Ears()
        self.network = canopen.Network(drive.bus())
        self.network.listeners.append(self.ears)
        self.network.connect()

    def close(self):
        self.network.disconnect()

    def node(self, number, layout="single"):
        """Adds a TX-Driver with the EDS of its PDO layout."""
        node = self.network.add_node(number, str(ROOT / "docs" / f"eddycan-{layout}.eds"))
        node.sdo.RESPONSE_TIMEOUT = PATIENCE
        node.tpdo.read(from_od=True)
        return node

    def send(self, identifier, data=b""):
        """Sends a data frame through python-can."""
        self._send(can.Message(arbitration_id=identifier, data=data, is_extended_id=False))

    def send_remote(self, identifier, length):
        """Sends a remote frame with a chosen data length code, which python-canopen does not support."""
        self._send(can.Message(arbitration_id=identifier, dlc=length, is_remote_frame=True, is_extended_id=False))

    def _send(self, message):
        with self.network.send_lock:
            self.network.bus.send(message)

    @property
    def now(self):
        """Number of frames received so far: a position in the list of frames."""
        return len(self.ears.frames)

    def received(self, identifier, since, until=None):
        """Returns the data of all frames with an identifier between two positions of the list."""
        frames = self.ears.frames[since:until]
        return [bytes(frame.data) for frame in frames if frame.arbitration_id == identifier and not frame.is_remote_frame]

    def wait(self, identifier, since, count=1):
        """Waits for `count` frames with an identifier, and returns their data."""
        end = time.monotonic() + PATIENCE
        with self.ears.came:
            while len(found := self.received(identifier, since)) < count:
                left = end - time.monotonic()
                assert left > 0, f"{len(found)} of {count} frames {identifier:03X}h after {PATIENCE} s"
                self.ears.came.wait(left)
        return found

    def let_pass(self, seconds):
        """Waits for at least `seconds` of simulated time, in whole periods of the status word."""
        self.wait(STATUS, self.now, math.ceil(seconds / BROADCAST_SECONDS) + 1)

    def settle(self):
        """Waits until everything sent so far has passed over the bus and has been answered.

        Sends a parameter request to the drive, and waits for its answer and for one more broadcast period. A
        client's frames keep their order, so the request passes last.
        """
        since = self.now
        identifier = DATABASE.get_message_by_name("PARAMETER_REQUEST").frame_id
        self._send(can.Message(arbitration_id=identifier, data=bytes([0, 99]).ljust(8, b"\0"), is_extended_id=True))
        self.wait(PARAMETER, since)
        self.let_pass(BROADCAST_SECONDS)

    def ask(self, node, request):
        """Sends a request of 8 bytes to a node, and returns the answer."""
        since = self.now
        self.send(REQUEST + node, request)
        return self.wait(ANSWER + node, since)[0]

    def command(self, command, target):
        """Sends an NMT command through python-canopen, and waits until it has been carried out."""
        nmt = self.network.nmt if target == 0 else self.network[target].nmt
        nmt.send_command(command)
        self.settle()

    def restart(self, node, number=None):
        """Resets a node, and waits for its boot-up message, which may carry a new node-id."""
        since = self.now
        self.network[node].nmt.send_command(RESET)
        number = number or node
        assert self.wait(HEARTBEAT + number, since)[0] == BOOT_UP
        self.settle()
        return self.received(HEARTBEAT + number, since)


def sdo(command, index, subindex=0, data=b""):
    """Returns the 8 bytes of a request or an answer (figure 6)."""
    return bytes([command]) + index.to_bytes(2, "little") + bytes([subindex]) + data.ljust(4, b"\0")


def aborted(index, subindex, code):
    """Returns the answer with an abort code (section 3.3.3)."""
    return sdo(0x80, index, subindex, code.to_bytes(4, "little"))


def later(action, *arguments):
    """Calls `action` after 0.1 s, so that the caller is already waiting for its effect."""
    timer = threading.Timer(0.1, action, arguments)
    timer.start()
