"""A drive reduced to its protocol: it runs on a virtual bus of python-can, and serves any description."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any
from xml.etree import ElementTree
from zlib import crc32

import can

DRIVE, MASTER = 170, 85
STATUS, FAULTS, REBOOT, MOTOR, PARAMETER, SCOPE, XML, XML_DATA, M1, M2, M5 = 3, 4, 101, 102, 110, 112, 130, 131, 201, 202, 205
SET, ASK = 1, 2


class Peer:
    """The simulated drive; its parameters begin with the raw factory values of the description."""

    def __init__(self, bus: can.BusABC, description: str | None, build: int = 7, speed_max: int = 65_535) -> None:
        self.bus = bus
        text = b"" if description is None else description.encode()
        self.text = text + b"\n" * (len(text) % 2)
        self.check = crc32(self.text)
        self.build = build
        self.speed_max = speed_max
        self.downloads = 0
        self.rows: dict[int, Any] = {}
        self.raw: dict[int, int] = {}
        self.record: list[int] = []
        self.measured: dict[int, tuple[int, int, int, int]] = {}
        self.mode = 0
        root = ElementTree.fromstring(description) if description else ElementTree.Element("none")
        for row in root.iter("parameter"):
            number = int(row.attrib["number"])
            self.rows[number] = row.attrib
            self.raw[number] = round(float(row.attrib["factory"]) / float(row.attrib["scale"]))
        self.raw[305] = 4096  # words of the scope's memory
        self.raw |= {83: 1, 261: 1, 260: 0}

    def say(self, opcode: int, *words: int) -> None:
        number = 2 << 27 | DRIVE << 19 | MASTER << 11 | opcode
        data = b"".join((word & 0xFFFF).to_bytes(2, "big") for word in (*words, 0, 0, 0, 0)[:4])
        self.bus.send(can.Message(arbitration_id=number, is_extended_id=True, data=data))

    def stream(self, opcode: int, words: list[int]) -> None:
        for at in range(0, len(words), 3):
            self.say(opcode, at, *words[at : at + 3])

    def receive(self, message: can.Message) -> None:
        kind, opcode = message.arbitration_id >> 9 & 3, message.arbitration_id & 0x1FF
        words = [int.from_bytes(message.data[at : at + 2], "big") for at in range(0, 8, 2)]
        match kind, opcode:
            case 2, 0:
                self.say(0, self.build, 0, 20_261_123 >> 16, 20_261_123)
            case 2, 1:
                self.say(1, 1, 1, 1, DRIVE)
            case 1, 2:
                self.mode = words[1] & 0xF
                self.raw[261] = 5 if self.mode else 1
                self.broadcast()
            case 1, 102:
                self.say(MOTOR, min(words[0], self.speed_max))
                self.broadcast()
            case 2, 110:
                self.answer(words[0], 0)
            case 1, 110:
                self.write(words[0], words[1] << 16 | words[2])
            case 1, 112:
                self.raw[260] = 3 if self.raw[260] == 1 else 1
            case 2, 112:
                self.stream(SCOPE, self.record)
            case 2, 130 if self.text and words[0] == 0:
                self.say(XML, len(self.text) // 2, 0, self.check >> 16, self.check)
            case 2, 130 if self.text:
                self.downloads += 1
                self.stream(XML_DATA, [int.from_bytes(self.text[at : at + 2], "big") for at in range(0, len(self.text), 2)])

    def answer(self, number: int, status: int) -> None:
        raw = self.raw.get(number)
        self.say(PARAMETER, number, *(((raw or 0) >> 16), raw or 0), status if raw is not None else 1)

    def write(self, number: int, raw: int) -> None:
        row = self.rows.get(number)
        if row is None:
            return self.answer(number, 1)
        raw = raw - (1 << 32) if raw >> 31 and row["type"] == "int32" else raw
        low, high = (round(float(row[end]) / float(row["scale"])) for end in ("min", "max"))
        if not low <= raw <= high:
            return self.answer(number, 3)
        self.raw[number] = raw
        return self.answer(number, 0)

    def broadcast(self) -> None:
        self.say(STATUS, 0, (3 << 8 | self.mode) if self.mode else 0)
        self.say(FAULTS, 0, 0)
        for opcode, words in self.measured.items():
            self.say(opcode, *words)


@contextmanager
def peer(channel: str, description: str | None, **options: Any) -> Iterator[tuple[Peer, can.BusABC]]:
    """Runs a drive in a thread of its own, and yields it with a bus for its master."""
    with (
        can.Bus(interface="virtual", channel=channel) as own,
        can.Bus(interface="virtual", channel=channel) as bus,
    ):
        drive = Peer(own, description, **options)
        ended = threading.Event()

        def run() -> None:
            while not ended.is_set():
                message = own.recv(0.05)
                if message is not None:
                    drive.receive(message)

        thread = threading.Thread(target=run, daemon=True)
        thread.start()
        try:
            yield drive, bus
        finally:
            ended.set()
            thread.join()
