"""FDCAN as a classic controller, with its message memory (RM0440, section 44), and the bus that it is on."""

from collections import deque
from dataclasses import dataclass

from stm32g4.processor import EXTERNAL
from stm32g4.registers import NEVER, SECOND, Peripheral

FIFO_0, FIFO_1, TRANSMIT = 0xB0, 0x188, 0x278
FILTERS, SIZE = 28, 0x350
"""Word at which the extended filters begin, and bytes in all."""
ELEMENT, PLACES = 72, 3
NEW = (1 << 0, 1 << 3)
LOST = (1 << 2, 1 << 5)
COMPLETE, CANCELLED, BUS_OFF = 1 << 7, 1 << 8, 1 << 19
INIT, CCE = 1, 2
INTERMISSION = 3
PASSIVE, OFF = 128, 256


@dataclass(frozen=True)
class Frame:
    """A classic frame."""

    identifier: int
    extended: bool
    remote: bool
    data: bytes
    """Of a remote frame: as many bytes as its length code says."""

    def urgency(self) -> tuple[int, int, int, int]:
        """Frames in the order in which they win the bus."""
        if self.extended:
            return (self.identifier >> 18, 1, self.identifier & 0x3FFFF, int(self.remote))
        return (self.identifier, int(self.remote), 0, 0)

    def bits(self) -> int:
        """Bits on the bus with stuffing, without intermission (ISO 11898-1)."""
        length, sent = len(self.data), b"" if self.remote else self.data
        head = [0]
        if self.extended:
            head += binary(self.identifier >> 18, 11) + [1, 1] + binary(self.identifier & 0x3FFFF, 18) + [int(self.remote), 0, 0]
        else:
            head += binary(self.identifier, 11) + [int(self.remote), 0, 0]
        head += binary(length, 4)
        for byte in sent:
            head += binary(byte, 8)
        check = 0
        for bit in head:
            top = check >> 14 & 1
            check = check << 1 & 0x7FFF
            if top != bit:
                check ^= 0x4599
        head += binary(check, 15)
        stuffed, last, run = 0, None, 0
        for bit in head:
            run = run + 1 if bit == last else 1
            last = bit
            if run == 5:
                stuffed += 1
                last, run = 1 - bit, 1
        # Delimiter, acknowledge with delimiter, end of frame.
        return len(head) + stuffed + 10


def binary(value: int, width: int) -> list[int]:
    return [value >> place & 1 for place in reversed(range(width))]


class Fdcan(Peripheral):
    """The controller."""

    def __init__(self, chip: object) -> None:
        name, base, self.offset, interrupt = chip.board.can
        super().__init__(chip, name, base)
        self.interrupt = EXTERNAL + interrupt
        word = 0xFFFF_FFFF
        self.read_only(0x00, "CREL", lambda: 0x3214_1218)
        self.read_only(0x04, "ENDN", lambda: 0x8765_4321)
        # Bit rates of the data of CAN FD, which nobody sends.
        self.register(0x0C, "DBTP", 0x009F_1FFF, value=0xA33, write=self._configure("DBTP"))
        self.register(0x10, "TEST", 0x0)
        self.register(0x18, "CCCR", 0x7F, value=INIT, write=self._set_control)
        self.register(0x1C, "NBTP", 0xFFFF_FF7F, value=0x0600_0A03, write=self._configure("NBTP"))
        self.register(0x20, "TSCC", 0x000F_0003, write=self._configure("TSCC"))
        self.read_only(0x24, "TSCV", lambda: chip.now // self.bit() & 0xFFFF)
        self.read_only(0x40, "ECR", self._counters)
        self.read_only(0x44, "PSR", self._status)
        self.register(0x50, "IR", 0x00FF_FFFF, read=lambda: self.flags, write=self._clear)
        self.register(0x54, "IE", 0x00FF_FFFF, write=self._enable("IE"))
        self.register(0x5C, "ILE", 0x3, write=self._enable("ILE"))
        self.register(0x80, "RXGFC", 0x0F1F_033F, write=self._configure("RXGFC"))
        for fifo in (0, 1):
            self.read_only(0x90 + 8 * fifo, f"RXF{fifo}S", lambda fifo=fifo: self._fifo(fifo))
            self.register(0x94 + 8 * fifo, f"RXF{fifo}A", 0x7, write=lambda value, fifo=fifo: self._acknowledge(fifo, value))
        self.register(0xC0, "TXBC", 1 << 24, write=self._configure("TXBC"))
        self.read_only(0xC4, "TXFQS", self._queue)
        self.read_only(0xC8, "TXBRP", lambda: sum(1 << place for place in self.requests))
        # Of three bits; embassy-stm32 writes ones to the reserved ones as well.
        self.register(0xDC, "TXBTIE", word)
        self.write_only(0xCC, "TXBAR", 0x7, self._request)
        self.write_only(0xD0, "TXBCR", 0x7, self._cancel)
        self.memory = memoryview(bytearray(b"\xa5" * SIZE)).cast("I")
        self.flags = 0
        self.fill, self.get = [0, 0], [0, 0]
        self.requests: list[int] = []
        self.put = 0
        self.errors = 0
        self.bus_off = False
        self.returns = NEVER
        self.sending: int | None = None
        self.taken = 0
        """Received elements that the processor has acknowledged."""

    # Configuration (44.3.1, 44.4)

    def _set_control(self, value: int) -> None:
        register = self.registers["CCCR"]
        if value & CCE and not register.value & INIT:
            value &= ~CCE
        if not value & INIT:
            # CCE ends with INIT.
            value &= ~CCE
            if register.value & INIT:
                if self.bus_off:
                    # 129 times 11 recessive bits (44.3.2).
                    self.returns = self.chip.now + 129 * 11 * self.chip.bus.bit
                self.chip.bus.schedule()
        register.value = value

    def _configure(self, name: str):
        def write(value: int) -> None:
            if self.registers["CCCR"].value & 3 != 3:
                self.undefined(f"{name} is written outside of its configuration")
            self.registers[name].value = value

        return write

    def bit(self) -> int:
        """Time of a bit that the controller is set up for."""
        if self.chip.clocks.registers["CCIPR"].value >> 24 & 3 == 0:
            rate = self.chip.board.crystal
        else:
            self.undefined("runs from another clock than the crystal")
        value = self.registers["NBTP"].value
        quanta = 3 + (value >> 8 & 0xFF) + (value & 0x7F)
        return SECOND * quanta * ((value >> 16 & 0x1FF) + 1) // rate

    def is_on(self) -> bool:
        """Takes part in the bus."""
        works = self.chip.crystal_runs and self.chip.board.can_is_on(self.chip)
        return not self.registers["CCCR"].value & INIT and not self.bus_off and works

    # Errors (44.3.2)

    def fail(self, unheard: bool) -> None:
        """A frame of ours was not acknowledged by anybody, or did not come as it was sent."""
        # A passive node's counter stops rising when nobody acknowledges.
        if unheard and self.errors >= PASSIVE:
            return
        self.errors = min(self.errors + 8, OFF)
        if self.errors >= OFF:
            self.bus_off = True
            self.flags |= BUS_OFF
            self.registers["CCCR"].value |= INIT

    def _counters(self) -> int:
        return min(self.errors, 255)

    def _status(self) -> int:
        self._recover()
        return 0x707 | (self.errors >= PASSIVE) << 5 | (self.errors >= 96) << 6 | self.bus_off << 7

    def _recover(self) -> None:
        if self.bus_off and self.chip.now >= self.returns:
            self.bus_off, self.errors, self.returns = False, 0, NEVER

    # Interrupts

    def _clear(self, value: int) -> None:
        self.flags &= ~value
        self._signal()

    def _enable(self, name: str):
        def write(value: int) -> None:
            self.registers[name].value = value
            self._signal()

        return write

    def _signal(self) -> None:
        line = self.flags & self.registers["IE"].value and self.registers["ILE"].value & 1
        self.chip.processor.set_level(self.interrupt, bool(line))
        self.chip.attend()

    # Receiving (44.3.3)

    def receive(self, frame: Frame) -> None:
        """A frame of another node's has passed."""
        settings = self.registers["RXGFC"].value
        if frame.remote and settings >> (0 if frame.extended else 1) & 1:
            return
        # SFEC and EFEC, 0 is off (44.3.7 and 44.3.8).
        standard, extended = settings >> 16 & 0x1F, settings >> 24 & 0xF
        on = [self.memory[place] >> 27 & 7 for place in range(standard)]
        on += [self.memory[FILTERS + 2 * place] >> 29 for place in range(extended)]
        if any(on):
            self.undefined("has filters: the boards' images have none that is on")
        fifo = settings >> (2 if frame.extended else 4) & 3
        if fifo > 1:
            return
        if self.fill[fifo] == PLACES:
            self.flags |= LOST[fifo]
            if not settings >> (9 if fifo == 0 else 8) & 1:
                return
            self._release(fifo)
        place = (self.get[fifo] + self.fill[fifo]) % PLACES
        identifier = frame.identifier | 1 << 30 if frame.extended else frame.identifier << 18
        data = frame.data.ljust(8, b"\0") if not frame.remote else bytes(8)
        start = ((FIFO_0, FIFO_1)[fifo] + ELEMENT * place) // 4
        words = (identifier | frame.remote << 29, len(frame.data) << 16, *memoryview(data).cast("I"))
        for offset, value in enumerate(words):
            self.memory[start + offset] = value
        self.fill[fifo] += 1
        self.flags |= NEW[fifo]
        self._signal()

    def _fifo(self, fifo: int) -> int:
        fill, get = self.fill[fifo], self.get[fifo]
        return fill | get << 8 | (get + fill) % PLACES << 16 | (fill == PLACES) << 24

    def _acknowledge(self, fifo: int, place: int) -> None:
        if place != self.get[fifo] or self.fill[fifo] == 0:
            self.undefined(f"element {place} of FIFO {fifo} is acknowledged out of turn")
        self.taken += 1
        self._release(fifo)

    def _release(self, fifo: int) -> None:
        self.get[fifo] = (self.get[fifo] + 1) % PLACES
        self.fill[fifo] -= 1

    # Sending (44.3.4): the buffers as a FIFO

    def _queue(self) -> int:
        if self.registers["TXBC"].value:
            self.undefined("its buffers are a queue by urgency: the board's image uses a FIFO")
        free = PLACES - len(self.requests)
        first = self.requests[0] if self.requests else self.put
        return free | first << 8 | self.put << 16 | (free == 0) << 21

    def _request(self, value: int) -> None:
        for place in range(PLACES):
            if value >> place & 1:
                if place != self.put or len(self.requests) == PLACES:
                    self.undefined(f"buffer {place} is requested out of turn")
                self.requests.append(place)
                self.put = (place + 1) % PLACES
        self.chip.bus.schedule()

    def _cancel(self, value: int) -> None:
        for place in [place for place in self.requests if value >> place & 1 and place != self.sending]:
            self.requests.remove(place)
            self.flags |= CANCELLED

    def oldest(self) -> Frame | None:
        """The frame that would be sent next."""
        self._recover()
        if not self.requests or not self.is_on():
            return None
        start = (TRANSMIT + ELEMENT * self.requests[0]) // 4
        head, length, low, high = (self.memory[start + word] for word in range(4))
        extended, remote = bool(head >> 30 & 1), bool(head >> 29 & 1)
        if head >> 31 or length >> 20 & 3:
            self.undefined("sends a frame with the error state indicator, or of CAN FD")
        data = (low | high << 32).to_bytes(8, "little")[: min(length >> 16 & 0xF, 8)]
        return Frame(head & 0x1FFF_FFFF if extended else head >> 18 & 0x7FF, extended, remote, data)

    def sent(self) -> None:
        self.requests.pop(0)
        self.sending = None
        self.errors = max(self.errors - 1, 0)
        self.flags |= COMPLETE if self.registers["TXBTIE"].value & 7 else 0
        self._signal()


class MessageMemory(Peripheral):
    """The memory in which elements are: words only (44.3.6)."""

    def __init__(self, chip: object) -> None:
        super().__init__(chip, "SRAMCAN", 0x4000_A400 + chip.board.can[2])
        self.size = SIZE

    def read(self, offset: int) -> int:
        return self.chip.fdcan.memory[offset // 4]

    def write(self, offset: int, value: int) -> None:
        self.chip.fdcan.memory[offset // 4] = value


class Bus(Peripheral):
    """The bus with one other node, the host. `host` has its frames in the order in which they were sent."""

    RATE = 500_000

    def __init__(self, chip: object) -> None:
        super().__init__(chip, "bus", 0)
        self.bit = SECOND // self.RATE
        self.host: deque[Frame] = deque()
        self.passed: deque[tuple[int, bool, Frame]] = deque()
        """Frames that have passed: time, whether the host sent it, frame."""
        self.is_there = True
        """The host is on the bus, and acknowledges."""
        self.is_broken = False
        """The wires are shorted: no bit comes as it was sent."""
        self.on: tuple[bool, Frame] | None = None

    def send(self, frame: Frame) -> None:
        self.host.append(frame)
        self.schedule()

    def schedule(self) -> None:
        """Begins a frame if the bus is free."""
        if self.on is not None:
            return
        ours = self.chip.fdcan.oldest()
        theirs = self.host[0] if self.host and self.is_there and not self.is_broken else None
        if ours is None and theirs is None:
            self.due = self.chip.fdcan.returns
            self.chip.reschedule()
            return
        is_host = ours is None or (theirs is not None and theirs.urgency() < ours.urgency())
        frame = theirs if is_host else ours
        if not is_host:
            self.chip.fdcan.sending = self.chip.fdcan.requests[0]
        self.on = (is_host, frame)
        self.due = self.chip.now + (frame.bits() + INTERMISSION) * self.bit
        self.chip.reschedule()

    def step(self) -> None:
        self.due = NEVER
        if self.on is not None:
            (is_host, frame), self.on = self.on, None
            self._end(is_host, frame)
        self.schedule()

    def _end(self, is_host: bool, frame: Frame) -> None:
        fdcan = self.chip.fdcan
        agrees = abs(fdcan.bit() / self.bit - 1) < 0.01 if fdcan.is_on() else False
        if is_host:
            # Without another node that acknowledges the host repeats its frame for ever.
            if agrees:
                self.host.popleft()
                self.passed.append((self.chip.now, True, frame))
                fdcan.receive(frame)
        elif agrees and self.is_there and not self.is_broken and fdcan.requests:
            fdcan.sent()
            self.passed.append((self.chip.now, False, frame))
        else:
            fdcan.sending = None
            fdcan.fail(unheard=not self.is_broken and not self.is_there)
