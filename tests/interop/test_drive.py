"""`cargo xtask drive`, commanded by unmodified python-can clients over TCP and a pseudo-terminal, read with cantools."""

import os
import signal
import socket
import struct
import subprocess
import time
import xml.etree.ElementTree as ElementTree

import can
import pytest
from virtual_drive import BROADCAST_SECONDS, DATABASE, ROOT, TERMINAL, Drive

SNAPSHOT = ROOT / "tests/protocol/snapshots/protocol__description__text_of_the_description.snap"

STATE, SCOPE_STATE, SPEED_RATE = 261, 260, 99
STANDBY, HALL_CLOSED_LOOP = 1, 5
SCOPE_ARMED, SCOPE_DONE = 1, 3


@pytest.fixture
def drive(tmp_path):
    drive = Drive("--pty", "--link", str(tmp_path / "drive"))
    try:
        yield drive
    finally:
        assert drive.end() == 0


@pytest.fixture
def connect(drive):
    buses = []

    def connect(door="tcp", **options):
        buses.append(drive.bus(door, **options))
        return buses[-1]

    yield connect
    for bus in buses:
        bus.shutdown()


class Client:
    """Somebody on the bus: keeps what it receives, and commands once it has a mode."""

    def __init__(self, bus):
        self.bus = bus
        self.received = []
        self.mode = None
        self.rpm = 0
        self._due = 0.0

    def send(self, name, *words):
        data = b"".join(word.to_bytes(2, "big") for word in words).ljust(8, b"\0")
        identifier = DATABASE.get_message_by_name(name).frame_id
        self.bus.send(can.Message(arbitration_id=identifier, data=data, is_extended_id=True))

    def pump(self):
        if self.mode is not None and time.monotonic() >= self._due:
            self._due = time.monotonic() + 0.05
            self.send("MOTOR_CMD_SET", self.rpm)
            self.send("REQUEST_WORD", 0, self.mode)
        message = self.bus.recv(0.01)
        if message is not None:
            self.received.append((message.arbitration_id, bytes(message.data)))
        return message

    def run(self, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.pump()

    def wait(self, seconds, until, what):
        end = time.monotonic() + seconds
        while not until():
            self.pump()
            assert time.monotonic() < end, f"no {what} after {seconds} s"

    def last(self, name):
        """The last message of this name, decoded; None if there is none."""
        identifier = DATABASE.get_message_by_name(name).frame_id
        data = next((data for received, data in reversed(self.received) if received == identifier), None)
        return None if data is None else DATABASE.decode_message(identifier, data, decode_choices=False)

    @property
    def speed(self):
        return self.last("MEASUREMENT_5")["Mechanical_estimated_speed_HES"]

    def answers(self, number, since=0):
        """The drive's words about a parameter among what was received since: raw values, each with its status."""
        identifier = DATABASE.get_message_by_name("PARAMETER").frame_id
        words = (struct.unpack(">HiH", data) for received, data in self.received[since:] if received == identifier)
        return [(value, status) for about, value, status in words if about == number]

    def ask(self, number, message, *words):
        since = len(self.received)
        self.send(message, number, *words)
        self.wait(5.0, lambda: self.answers(number, since), f"answer about parameter {number}")
        return self.answers(number, since)[0]

    def read(self, number):
        value, status = self.ask(number, "PARAMETER_REQUEST")
        assert status == 0
        return value

    def write(self, number, value):
        return self.ask(number, "PARAMETER_SET", value >> 16 & 0xFFFF, value & 0xFFFF)

    def wait_for(self, number, value, seconds=5.0):
        self.wait(seconds, lambda: self.read(number) == value, f"{value} of parameter {number}")

    def download(self, request, words, data, count):
        """Asks, and puts three words of each data frame behind each other."""
        identifier = DATABASE.get_message_by_name(data).frame_id
        content, seen = bytearray(), len(self.received)

        def is_complete():
            nonlocal seen
            for received, payload in self.received[seen:]:
                if received == identifier:
                    assert 2 * int.from_bytes(payload[0:2], "big") == len(content), "in order and without a gap"
                    content.extend(payload[2:8])
            seen = len(self.received)
            return len(content) >= 2 * count

        self.send(request, *words)
        self.wait(30.0, is_complete, f"{count} words")
        assert not any(content[2 * count :]), "filled with zeros"
        return bytes(content[: 2 * count])

    def count(self, name, since=0):
        identifier = DATABASE.get_message_by_name(name).frame_id
        return sum(received == identifier for received, _ in self.received[since:])


def between_marks(client, own=()):
    """What a client received between the first and the last answer about the marks, without some messages."""
    answers = [place for place, (received, _) in enumerate(client.received) if received == DATABASE.get_message_by_name("PARAMETER").frame_id]
    ids = {DATABASE.get_message_by_name(name).frame_id for name in own}
    return [frame for frame in client.received[answers[0] : answers[-1] + 1] if frame[0] not in ids]


COMMANDS = ["REQUEST_WORD", "MOTOR_CMD_SET", "PARAMETER_REQUEST", "PARAMETER_SET"]


def test_one_client_spins_the_motor_and_another_overhears_every_frame(connect):
    master, listener = Client(connect("tcp")), Client(connect("pty"))
    for client in (master, listener):
        client.wait(5.0, lambda: client.last("STATUS_WORD"), "broadcast")
    master.mode = 0
    master.wait_for(STATE, STANDBY)
    master.mode, master.rpm = 1, 2000
    master.wait_for(STATE, HALL_CLOSED_LOOP)
    master.wait(5.0, lambda: abs(master.speed - 2000) <= 20, "set-point")
    master.run(0.5)
    assert abs(master.speed - 2000) <= 20
    assert not any(master.last("FAULT_WORD").values())
    status = master.last("STATUS_WORD")
    assert (status["Motor_mode"], status["Control_mode"]) == (1, 3)
    master.mode = 0
    master.wait(5.0, lambda: master.speed == 0, "standstill")
    master.wait_for(STATE, STANDBY)
    answers = master.count("PARAMETER")
    listener.wait(10.0, lambda: listener.count("PARAMETER") == answers, "last answer")

    ids = {DATABASE.get_message_by_name(name).frame_id for name in COMMANDS}
    assert not ids & {received for received, _ in master.received}, "nobody receives his own frames"
    assert ids - {DATABASE.get_message_by_name("PARAMETER_SET").frame_id} <= {received for received, _ in listener.received}
    of_the_drive = between_marks(master)
    assert len(of_the_drive) > 100
    assert between_marks(listener, COMMANDS) == of_the_drive
    assert max(abs(speed) for speed in speeds(listener)) >= 1980


def test_the_example_of_the_page_spins_the_motor(drive, capsys, monkeypatch):
    blocks = (ROOT / "docs" / "VIRTUAL-DRIVE.md").read_text().split("```python\n")[1:]
    (example,) = [text for text in (block.split("```")[0] for block in blocks) if "can.Bus" in text]
    monkeypatch.chdir(ROOT)
    # Twice: the second time the drive is in Fault, for its master had fallen silent.
    for door in ["tcp", "pty"]:
        example_here = example.replace("socket://127.0.0.1:2000", drive.channels[door])
        # On a busy machine the example may fall silent for longer than the drive waits: then once more.
        for _ in range(4):
            exec(example_here, {})
            lines = capsys.readouterr().out.splitlines()
            first, last = (int(line.removesuffix(" rpm")) for line in (lines[0], lines[-1]))
            # It has come to rest, or on a slow machine nearly so.
            assert len(lines) > 40 and first < 100
            time.sleep(1.0)
            if abs(last - 2000) <= 20:
                break
        else:
            raise AssertionError(f"{door}: {last} rpm")


def speeds(client):
    identifier = DATABASE.get_message_by_name("MEASUREMENT_5").frame_id
    name = "Mechanical_estimated_speed_HES"
    return [DATABASE.decode_message(received, data)[name] for received, data in client.received if received == identifier]


def test_parameters_are_read_and_written_and_everybody_sees_the_answers(connect):
    one, two = Client(connect("tcp")), Client(connect("tcp"))
    one.mode = 0
    one.wait_for(STATE, STANDBY)
    assert one.write(SPEED_RATE, 1234) == (1234, 0)
    assert two.read(SPEED_RATE) == 1234
    assert two.last("PARAMETER") == {"Number": SPEED_RATE, "P99_Speed_setpoint_rate": 1234, "Status": 0}
    one.wait(5.0, lambda: len(one.answers(SPEED_RATE)) == 2, "answer to the other one")
    assert one.write(SPEED_RATE, 0) == (1234, 3), "out of range, and kept"
    assert two.write(STATE, 1)[1] == 2, "read-only"
    assert one.write(200, 1) == (0, 1), "unknown"
    two.wait(5.0, lambda: two.answers(200) == [(0, 1)], "answer to the other one")
    assert one.answers(STATE)[-1][1] == 2


def test_the_description_is_the_one_of_the_snapshot(connect):
    client = Client(connect("pty"))
    text = description(client)
    committed = SNAPSHOT.read_text().split("---\n", 2)[2].splitlines()
    # An odd length is filled up with a line's end.
    lines = text.decode().rstrip("\n").splitlines()
    # The second line tells one board from another.
    assert lines[1].startswith("<description ") and committed[1].startswith("<description ")
    assert [lines[0], *lines[2:]] == [committed[0], *committed[2:]]


def description(client):
    client.send("XML_DOWNLOAD_REQUEST", 0)
    client.wait(5.0, lambda: client.last("XML_DOWNLOAD_ANSWER"), "length")
    length = int(client.last("XML_DOWNLOAD_ANSWER")["Length"])
    return client.download("XML_DOWNLOAD_REQUEST", [1], "XML_DOWNLOAD_DATA", length)


def test_the_scope_is_armed_forced_and_downloaded(connect):
    client = Client(connect("tcp"))
    client.mode = 0
    client.wait_for(STATE, STANDBY)
    signals = ElementTree.fromstring(description(client)).findall("scope/signal")
    voltage, state = (next(s for s in signals if s.get("name") == name) for name in ("HV Voltage", "Drive state"))
    assert int(voltage.get("bit")) < int(state.get("bit"))
    samples = 50
    assert client.write(22, 1 << int(voltage.get("bit")) | 1 << int(state.get("bit")))[1] == 0
    assert client.write(23, samples)[1] == 0
    client.send("LOG_VIRTUAL_SCOPE_SET", 0)
    client.wait_for(SCOPE_STATE, SCOPE_ARMED)
    client.send("LOG_VIRTUAL_SCOPE_SET", 0)
    client.wait_for(SCOPE_STATE, SCOPE_DONE)
    words = client.download("LOG_VIRTUAL_SCOPE_REQUEST", [0], "LOG_VIRTUAL_SCOPE", 2 * samples)
    record = struct.unpack(f">{2 * samples}h", words)
    volts = [raw / 4096 * float(voltage.get("base")) for raw in record[0::2]]
    assert all(abs(v - 18.0) < 0.3 for v in volts), volts
    assert all(raw / 4096 * float(state.get("base")) == STANDBY for raw in record[1::2])


def test_rubbish_and_clients_that_break_off_or_never_read_disturb_nobody(drive, connect):
    master = Client(connect("tcp"))
    master.mode = 0
    master.wait_for(STATE, STANDBY)
    master.mode, master.rpm = 1, 2000
    master.wait_for(STATE, HALL_CLOSED_LOOP)
    rubbish = bytes(range(256)) * 4096
    shouter, deaf, brief = (socket.create_connection(drive.address) for _ in range(3))
    shouter.sendall(b"O\r")
    shouter.setblocking(False)
    deaf.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    deaf.sendall(b"O\r")
    # Gone with a reset, in the middle of a frame.
    brief.sendall(b"O\rT0AAD520280000")
    brief.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    brief.close()
    before, start = len(master.received), time.monotonic()
    while time.monotonic() < start + 3.0:
        try:
            shouter.send(rubbish)
        except BlockingIOError:
            pass
        master.pump()
    # On a busy machine some come late; none is missing.
    due = 3.0 / BROADCAST_SECONDS - 2
    master.wait(3.0, lambda: master.count("STATUS_WORD", before) >= due, f"{due} broadcasts")
    assert master.count("STATUS_WORD", before) <= (time.monotonic() - start) / BROADCAST_SECONDS + 2
    assert not any(master.last("FAULT_WORD").values())
    assert abs(master.speed - 2000) <= 20
    shouter.close()
    deaf.close()
    assert master.read(STATE) == HALL_CLOSED_LOOP


def test_who_is_one_too_many_is_turned_away_until_another_leaves(drive):
    def is_served(client):
        client.settimeout(5.0)
        try:
            client.sendall(b"N\r")
            return client.recv(100) == b"NNARX\r"
        except ConnectionError:
            return False

    clients = [socket.create_connection(drive.address) for _ in range(32)]
    assert all(map(is_served, clients))
    with socket.create_connection(drive.address) as late:
        assert not is_served(late)
    clients.pop().close()
    end = time.monotonic() + 5.0
    while time.monotonic() < end:
        with socket.create_connection(drive.address) as late:
            if is_served(late):
                break
    else:
        raise AssertionError("no place becomes free")
    for client in clients:
        client.close()


@pytest.mark.parametrize("door", ["tcp", "pty"])
def test_a_client_may_leave_and_come_back(drive, door):
    for round in range(3):
        bus = drive.bus(door)
        client = Client(bus)
        assert client.bus.get_version(5) == (10, 10)
        assert client.read(STATE) in (0, STANDBY)
        if round == 1:
            # As if its program had crashed: no close of the channel.
            bus.serialPortOrig.close()
            bus.serialPortOrig = open(os.devnull, "wb")
        bus.shutdown()


def test_the_terminal_is_raw_and_quiet_until_its_channel_is_opened(drive):
    terminal = os.open(drive.channels["pty"], os.O_RDWR | os.O_NOCTTY)
    try:
        os.set_blocking(terminal, False)
        time.sleep(0.3)
        with pytest.raises(BlockingIOError):
            os.read(terminal, 100)
        os.write(terminal, b"N\rX\r")
        time.sleep(0.3)
        assert os.read(terminal, 100) == b"NNARX\r\a", "no echo, and bytes as they are"
    finally:
        os.close(terminal)


def test_who_listens_only_is_not_received(connect):
    listener, other = Client(connect("tcp", listen_only=True)), Client(connect("tcp"))
    other.wait(5.0, lambda: other.last("STATUS_WORD"), "broadcast")
    listener.send("PARAMETER_REQUEST", STATE)
    listener.wait(5.0, lambda: listener.last("STATUS_WORD"), "broadcast")
    listener.run(0.3)
    other.run(0.3)
    assert listener.last("PARAMETER") is None and other.last("PARAMETER") is None


def test_the_link_goes_with_the_drive(tmp_path):
    link = tmp_path / "terminal"
    link.symlink_to("/dev/null")
    drive = Drive("--pty", "--link", str(link))
    assert drive.channels["pty"] == str(link)
    assert str(link.resolve()).startswith("/dev/pts/")
    assert drive.end() == 0
    assert not link.is_symlink()


def test_simulated_time_follows_the_clock_and_makes_up_for_a_stall(drive, connect):
    client = Client(connect("tcp"))
    client.wait(5.0, lambda: client.last("STATUS_WORD"), "broadcast")
    client.received.clear()
    start = time.monotonic()
    client.run(1.0)
    drive.process.send_signal(signal.SIGSTOP)
    client.run(1.0)
    drive.process.send_signal(signal.SIGCONT)
    client.run(2.5)
    passed = time.monotonic() - start
    count = client.count("STATUS_WORD")
    assert abs(count - passed / BROADCAST_SECONDS) <= 4, f"{count} broadcasts in {passed:.2f} s"


def test_a_motor_runs_through_a_stall_of_the_program(drive, connect):
    master = Client(connect("tcp"))
    master.mode = 0
    master.wait_for(STATE, STANDBY)
    master.mode, master.rpm = 1, 2000
    master.wait(5.0, lambda: abs(master.speed - 2000) <= 20, "set-point")
    drive.process.send_signal(signal.SIGSTOP)
    # Four times the drive's time-out: but its time stands still, too.
    master.run(1.0)
    drive.process.send_signal(signal.SIGCONT)
    master.run(1.5)
    assert master.read(STATE) == HALL_CLOSED_LOOP
    assert not any(master.last("FAULT_WORD").values())


def test_it_ends_by_itself_and_may_run_faster():
    start = time.monotonic()
    drive = Drive("--seconds", "20", "--speed", "10", "--verbose")
    assert drive.process.wait(timeout=30) == 0
    assert 1.9 < time.monotonic() - start < 15
    assert "Standby" in drive.process.stdout.read()
    assert drive.end() == 0


@pytest.mark.parametrize(
    "arguments, reason",
    [
        (["--speed", "0"], "--speed 0: must be a number from 0.01 to 100 or max"),
        (["--speed", "fast"], "--speed fast: must be"),
        (["--seconds", "-1"], "--seconds -1: must be"),
        (["--motor", "mn7005"], "--motor mn7005: unknown motor"),
        (["--tx-drivers", "0"], "--tx-drivers 0: must be different node-ids"),
        (["--tx-drivers", "128"], "--tx-drivers 128: must be"),
        (["--tx-drivers", "2,2:dual"], "--tx-drivers 2,2:dual: must be"),
        (["--tx-drivers", "2:triple"], "--tx-drivers 2:triple: must be"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(arguments, reason):
    refused = subprocess.run([TERMINAL, "drive", *arguments], capture_output=True, text=True, timeout=10)
    assert refused.returncode == 2
    assert refused.stderr.startswith(reason) and refused.stderr.count("\n") == 1


def test_a_port_that_is_taken_is_named(drive):
    host, port = drive.address
    refused = subprocess.run([TERMINAL, "drive", "--tcp", f"{host}:{port}"], capture_output=True, text=True, timeout=10)
    assert refused.returncode == 1
    assert f"--tcp {host}:{port}" in refused.stderr


def test_a_link_replaces_no_file(tmp_path):
    precious = tmp_path / "precious"
    precious.write_text("kept")
    command = [TERMINAL, "drive", "--tcp", "127.0.0.1:0", "--pty", "--link", str(precious)]
    refused = subprocess.run(command, capture_output=True, text=True, timeout=10)
    assert refused.returncode == 1
    assert refused.stderr.startswith(f"--pty --link {precious}: ")
    assert precious.read_text() == "kept"
