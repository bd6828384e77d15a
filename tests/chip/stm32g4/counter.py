"""TIM2 and TIM5: counters that run freely and interrupt at compare values (RM0440, section 29)."""

from stm32g4.processor import EXTERNAL
from stm32g4.registers import NEVER, Peripheral

CHANNELS = (1, 2, 3, 4)
UPDATE = 1


class Counter(Peripheral):
    """A timer that counts up."""

    takes_halfwords = True

    def __init__(self, chip: object, name: str, base: int, interrupt: int) -> None:
        super().__init__(chip, name, base)
        word = 0xFFFF_FFFF
        self.interrupt = EXTERNAL + interrupt
        # ARPE, URS, CEN.
        self.register(0x00, "CR1", 0x85, write=self._start)
        self.register(0x0C, "DIER", 0x1F, write=self._enable)
        self.register(0x10, "SR", word, read=self._status, write=self._clear)
        self.write_only(0x14, "EGR", UPDATE, self._generate)
        self.register(0x18, "CCMR1", 0x0)
        self.register(0x1C, "CCMR2", 0x0)
        self.register(0x20, "CCER", 0x0)
        self.register(0x24, "CNT", word, read=lambda: self.count(self.chip.now), write=self._set_count)
        self.register(0x28, "PSC", 0xFFFF)
        self.register(0x2C, "ARR", word, value=word, write=self._set_reload)
        for channel in CHANNELS:
            self.register(0x30 + 4 * channel, f"CCR{channel}", word, write=lambda value, channel=channel: self._compare(channel, value))
        self.range = 1 << 32
        self.prescaler = 0
        self.status = 0
        self.started: int | None = None
        """Time at which the count was 0; None while it stands still."""
        self.unit = chip.clocks.unit
        self.seen = 0
        """Counts since the start up to which flags are set."""

    def _position(self) -> int:
        return 0 if self.started is None else (self.chip.now - self.started) // self.unit

    def count(self, time: int) -> int:
        return 0 if self.started is None else (time - self.started) // self.unit % self.range

    def _start(self, value: int) -> None:
        self.registers["CR1"].value = value
        if value & 1 and self.started is None:
            # The prescaler is preloaded: EGR, or the next update.
            self.unit = self.chip.clocks.unit * (self.prescaler + 1)
            self.started = self.chip.now
            self.seen = 0
        elif not value & 1:
            self.started = None
        self._schedule()

    def _generate(self, value: int) -> None:
        if self.started is not None:
            self.undefined("an update is generated while it runs")
        self.prescaler = self.registers["PSC"].value
        if not self.registers["CR1"].value >> 2 & 1:
            self.status |= UPDATE

    def _set_count(self, value: int) -> None:
        if value or self.started is not None:
            self.undefined("its count is set while it runs")

    def _set_reload(self, value: int) -> None:
        if self.started is not None:
            self.undefined("its range changes while it runs")
        self.registers["ARR"].value, self.range = value, value + 1

    def _compare(self, channel: int, value: int) -> None:
        self._follow()
        self.registers[f"CCR{channel}"].value = value
        self._schedule()

    def _enable(self, value: int) -> None:
        self._follow()
        self.registers["DIER"].value = value
        self._signal()
        self._schedule()

    def _status(self) -> int:
        self._follow()
        return self.status

    def _clear(self, value: int) -> None:
        self._follow()
        self.status &= value
        self._signal()

    def _next(self, channel: int, position: int) -> int:
        """The first position behind `position` at which the channel's compare value is met."""
        compare = self.registers[f"CCR{channel}"].value
        return position + ((compare - position) % self.range or self.range) if compare < self.range else NEVER

    def _follow(self) -> None:
        """Sets the flags of what has been passed: whether or not somebody has asked for an interrupt."""
        if self.started is None:
            return
        position = self._position()
        for channel in CHANNELS:
            if self._next(channel, self.seen) <= position:
                self.status |= 1 << channel
        if position // self.range != self.seen // self.range:
            self.status |= UPDATE
        self.seen = position

    def _signal(self) -> None:
        self.chip.processor.set_level(self.interrupt, bool(self.status & self.registers["DIER"].value))
        self.chip.attend()

    def _schedule(self) -> None:
        """The next event that interrupts."""
        self.due = NEVER
        if self.started is not None:
            position, enabled = self._position(), self.registers["DIER"].value
            ahead = [self._next(channel, position) for channel in CHANNELS if enabled >> channel & 1]
            if enabled & UPDATE:
                ahead.append((position // self.range + 1) * self.range)
            if ahead:
                self.due = min(self.started + min(ahead) * self.unit, NEVER)
        self.chip.reschedule()

    def step(self) -> None:
        self._follow()
        self._signal()
        self._schedule()
