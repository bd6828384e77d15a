"""TIM4: free-running counter, captures of the hall lines, compare (RM0440, section 29)."""

from stm32g4.processor import EXTERNAL
from stm32g4.registers import NEVER, Peripheral

IRQ = EXTERNAL + 30
RANGE = 1 << 16
PINS = {1: 6, 2: 7, 3: 8}
"""Pin of port B of each channel; alternate function 2 (DS12589, table 13)."""
FUNCTION = 2
FILTERS = [(1, 0), (1, 2), (1, 4), (1, 8), (2, 6), (2, 8), (4, 6), (4, 8), (8, 6), (8, 8), (16, 5), (16, 6), (16, 8), (32, 5), (32, 6), (32, 8)]
"""Clocks between two samples of an input, and how many must agree, by the field ICxF (29.5.8)."""


class CaptureTimer(Peripheral):
    """TIM4."""

    def __init__(self, chip: object) -> None:
        super().__init__(chip, "TIM4", 0x4000_0800)
        self.register(0x00, "CR1", 0x1, write=self._start)
        self.register(0x0C, "DIER", 0x001F, write=self._enable)
        self.register(0x10, "SR", 0xFFFF_FFFF, read=self._status, write=self._clear)
        self.register(0x18, "CCMR1", 0xF3F3)
        self.register(0x1C, "CCMR2", 0x00F3)
        self.register(0x20, "CCER", 0x0FFF)
        self.read_only(0x24, "CNT", lambda: self.count(chip.now))
        self.register(0x28, "PSC", 0x0)
        self.register(0x2C, "ARR", 0xFFFF_FFFF, value=0xFFFF_FFFF)
        self.captured = [0, 0, 0]
        for channel in (1, 2, 3):
            self.register(0x30 + 4 * channel, f"CCR{channel}", 0xFFFF, read=lambda channel=channel: self._capture(channel))
        self.register(0x40, "CCR4", 0xFFFF, write=self._alarm)
        self.status = 0
        self.started: int | None = None
        self.unit = chip.clocks.unit
        self.level = 0
        self.waiting: list[tuple[int, int]] = []
        """Filtered edges to come: time and channel."""
        self.edges = self.taken = 0
        """Edges of the lines, and captures that the processor has read."""

    def count(self, time: int) -> int:
        return 0 if self.started is None else (time - self.started) // self.unit % RANGE

    def _start(self, value: int) -> None:
        self.registers["CR1"].value = value
        if value & 1 and self.started is None:
            if self.registers["ARR"].value & 0xFFFF != 0xFFFF:
                self.undefined("does not count to the end of its range")
            self.unit = self.chip.clocks.unit
            self.started = self.chip.now
            self._schedule()

    # Captures

    def hall(self, time: int, code: int) -> None:
        """The hall lines have changed at `time`."""
        changed, self.level = self.level ^ code, code
        self.edges += changed.bit_count()
        for channel, pin in PINS.items():
            if changed >> (channel - 1) & 1 and self.chip.ports["B"].function(pin) == FUNCTION and self.started is not None:
                self._edge(time, channel, bool(code >> (channel - 1) & 1))

    def _edge(self, time: int, channel: int, rises: bool) -> None:
        modes = self.registers["CCMR1" if channel < 3 else "CCMR2"].value >> (8 if channel == 2 else 0)
        enables = self.registers["CCER"].value >> 4 * (channel - 1)
        falling, rising = enables >> 1 & 1, not enables >> 1 & 1 or bool(enables >> 3 & 1)
        if not enables & 1 or modes & 3 != 1 or not (rising if rises else falling):
            return
        clocks, samples = FILTERS[modes >> 4 & 0xF]
        step = clocks * self.unit
        at = time if samples == 0 else (-(-(time - self.started) // step) + samples - 1) * step + self.started
        # A pulse that is shorter than the filter leaves no edge.
        if samples and (old := next((edge for edge in self.waiting if edge[1] == channel and edge[0] > time), None)):
            self.waiting.remove(old)
        else:
            self.waiting.append((at, channel))
            self.waiting.sort()

    def _take_edges(self) -> None:
        while self.waiting and self.waiting[0][0] <= self.chip.now:
            at, channel = self.waiting.pop(0)
            if self.status >> channel & 1:
                self.status |= 1 << (channel + 8)
            self.status |= 1 << channel
            self.captured[channel - 1] = self.count(at)

    def _capture(self, channel: int) -> int:
        self.chip.follow_plant()
        self._take_edges()
        self.taken += self.status >> channel & 1
        self.status &= ~(1 << channel)
        self._signal()
        return self.captured[channel - 1]

    def _status(self) -> int:
        self.chip.follow_plant()
        self._take_edges()
        return self.status

    def _clear(self, value: int) -> None:
        self._take_edges()
        self.status &= value
        self._signal()

    # Compare

    def _alarm(self, value: int) -> None:
        self.registers["CCR4"].value = value
        self._schedule()

    def _enable(self, value: int) -> None:
        self.registers["DIER"].value = value
        self._signal()

    def _signal(self) -> None:
        if self.registers["DIER"].value & 0xE:
            self.undefined("interrupts of captures: the board's image looks for them itself")
        self.chip.processor.set_level(IRQ, bool(self.status & self.registers["DIER"].value))
        self.chip.attend()

    def _schedule(self) -> None:
        if self.started is None:
            return
        now = self.chip.now
        counts = (self.registers["CCR4"].value - self.count(now)) % RANGE or RANGE
        position = (now - self.started) // self.unit
        self.due = self.started + (position + counts) * self.unit
        self.chip.reschedule()

    def step(self) -> None:
        # The flag is set whether or not somebody has asked for an interrupt.
        self.status |= 1 << 4
        self._signal()
        self._schedule()
