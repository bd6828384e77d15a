"""Independent watchdog and low-power timer, both from the oscillator of 32 kHz (RM0440, sections 34 and 42)."""

from stm32g4.registers import NEVER, SECOND, Peripheral

ARRIVAL = 5
"""Clocks of the oscillator that a new value takes to arrive."""


class Watchdog(Peripheral):
    """IWDG."""

    def __init__(self, chip: object) -> None:
        super().__init__(chip, "IWDG", 0x4000_3000)
        self.is_open = False
        self.prescaler, self.reload = 0, 0xFFF
        self.arrives = 0
        self.write_only(0x00, "KR", 0xFFFF, self._key)
        self.register(0x04, "PR", 0x7, read=lambda: self.prescaler, write=self._set_prescaler)
        self.register(0x08, "RLR", 0xFFF, value=0xFFF, read=lambda: self.reload, write=self._set_reload)
        self.read_only(0x0C, "SR", lambda: 3 if chip.now < self.arrives else 0)

    @property
    def lsi(self) -> int:
        return round(SECOND / self.chip.lsi_rate)

    def _key(self, value: int) -> None:
        match value:
            case 0xCCCC:
                self._feed()
            case 0x5555:
                self.is_open = True
            case 0xAAAA:
                self.is_open = False
                if self.due != NEVER:
                    self._feed()
            case _:
                self.is_open = False

    def _feed(self) -> None:
        self.due = self.chip.now + (self.reload + 1) * (4 << self.prescaler) * self.lsi
        self.chip.reschedule()

    def _set(self, name: str, value: int) -> None:
        if not self.is_open:
            self.undefined(f"{name} is written without the key")
        if self.chip.now < self.arrives and name == self.arriving:
            self.undefined(f"{name} is written before the last value has arrived")
        self.arriving = name
        self.arrives = self.chip.now + ARRIVAL * self.lsi

    def _set_prescaler(self, value: int) -> None:
        self._set("PR", value)
        self.prescaler = min(value, 6)

    def _set_reload(self, value: int) -> None:
        self._set("RLR", value)
        self.reload = value

    def step(self) -> None:
        self.due = NEVER
        self.chip.reschedule()
        self.chip.request_reset("watchdog")


class LowPowerTimer(Peripheral):
    """LPTIM1, which counts the oscillator."""

    def __init__(self, chip: object) -> None:
        super().__init__(chip, "LPTIM1", 0x4000_7C00)
        self.started: int | None = None
        self.register(0x10, "CR", 0x5, write=self._control)
        self.register(0x18, "ARR", 0xFFFF, value=1, write=self._limit)
        self.read_only(0x1C, "CNT", self._count)

    def _control(self, value: int) -> None:
        was = self.registers["CR"].value
        if value & 4 and not was & 1:
            self.undefined("is started before it is enabled (section 34.4.13)")
        if value & 4 and self.started is None:
            if self.chip.clocks.registers["CCIPR"].value >> 18 & 3 != 1 or not self.chip.clocks.is_ready("LSI"):
                self.undefined("counts without the oscillator")
            self.started = self.chip.now
        self.registers["CR"].value = value

    def _limit(self, value: int) -> None:
        if not self.registers["CR"].value & 1:
            self.undefined("ARR is written before it is enabled")
        self.registers["ARR"].value = value

    def _count(self) -> int:
        if self.started is None:
            return 0
        counts = (self.chip.now - self.started) * self.chip.lsi_rate // SECOND
        return counts % (self.registers["ARR"].value + 1)
