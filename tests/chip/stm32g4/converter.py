"""ADC1 and ADC2: injected sequences by a trigger, single regular conversions by software (RM0440, section 21)."""

from stm32g4.processor import EXTERNAL
from stm32g4.registers import NEVER, SECOND, Peripheral

IRQ = EXTERNAL + 18
ADEN, ADSTART, JADSTART, ADVREGEN, DEEPPWD, ADCAL = 1 << 0, 1 << 2, 1 << 3, 1 << 28, 1 << 29, 1 << 31
ADRDY, EOSMP, EOC, EOS, OVR, JEOC, JEOS = (1 << bit for bit in range(7))
SAMPLING = [2.5, 6.5, 12.5, 24.5, 47.5, 92.5, 247.5, 640.5]
"""Clocks of the sampling, by the field SMP (21.7.6)."""
CONVERSION = 12.5
REGULATOR, CALIBRATION = SECOND * 20 // 1_000_000, 112
TRIGGERS = {8: "TIM1_TRGO2"}
FASTEST = 60e6
"""Largest clock of one converter with 12 bits (DS12589, section 5.3.19)."""


class Converter(Peripheral):
    """ADC1 or ADC2."""

    def __init__(self, chip: object, number: int) -> None:
        super().__init__(chip, f"ADC{number}", 0x5000_0000 + 0x100 * (number - 1))
        self.number = number
        word = 0xFFFF_FFFF
        self.register(0x00, "ISR", 0x7FF, read=self._flags, write=self._clear)
        self.register(0x04, "IER", 0x7F, write=self._enable)
        self.register(0x08, "CR", 0xB000_000D, read=self._control, write=self._set_control)
        self.register(0x0C, "CFGR", 0x8000_1000, value=0x8000_0000)
        self.register(0x14, "SMPR1", 0x3FFF_FFFF)
        self.register(0x18, "SMPR2", 0x07FF_FFFF)
        self.register(0x30, "SQR1", 0x7DF)
        self.read_only(0x40, "DR", self._read)
        self.register(0x4C, "JSQR", word, write=self._set_sequence)
        self.results = [0, 0, 0, 0]
        for rank in range(4):
            self.read_only(0x80 + 4 * rank, f"JDR{rank + 1}", lambda rank=rank: self._result(rank))
        self.flags = 0
        self.control = DEEPPWD
        self.regulator_on = self.calibrated = self.ready = NEVER
        self.is_calibrated = False
        self.regular = 0
        self.plan: list[tuple[int, str, int]] = []
        """What is to come: time, "sample", "injected" or "regular", and its rank or channel."""
        self.sampled = 0.0

    def clock(self) -> int:
        """Time of a clock (21.4.3)."""
        common = self.chip.converters_common.registers["CCR"].value
        divider = {1: 1, 2: 2, 3: 4}.get(common >> 16 & 3)
        if divider is None:
            self.undefined("has no clock")
        if self.chip.clocks.rate / divider > FASTEST:
            self.undefined(f"{self.chip.clocks.rate / divider / 1e6:g} MHz are too fast for it")
        return self.chip.clocks.unit * divider

    # Control (21.4.6 to 21.4.12)

    def _control(self) -> int:
        self._settle()
        value = self.control & ~ADCAL
        if self.chip.now < self.calibrated < NEVER:
            value |= ADCAL
        return value

    def _set_control(self, value: int) -> None:
        self._settle()
        now = self.chip.now
        rises = value & ~self.control
        if value & ADVREGEN and value & DEEPPWD:
            self.undefined("its regulator is started in deep power-down")
        if rises & ADVREGEN:
            self.regulator_on = now + REGULATOR
        if rises & ADCAL:
            if now < self.regulator_on:
                self.undefined("is calibrated before its regulator is ready, 20 us")
            self.calibrated = now + CALIBRATION * self.clock()
            self.is_calibrated = True
        if rises & ADEN:
            if not self.is_calibrated or now < self.calibrated + 4 * self.clock():
                self.undefined("is enabled before its calibration and four clocks are over")
            self.flags |= ADRDY
        for start in (ADSTART, JADSTART):
            if rises & start and not value & ADEN:
                self.undefined("is started before it is enabled")
        # Set by software, cleared by the converter.
        self.control = (self.control | value) & (ADEN | ADSTART | JADSTART | ADVREGEN | ADCAL) & ~ADCAL | value & DEEPPWD
        if rises & ADSTART:
            self._start_regular()

    def _set_sequence(self, value: int) -> None:
        if self.control & JADSTART:
            self.undefined("JSQR is written while a sequence may be triggered, without its queue")
        self.registers["JSQR"].value = value

    def _flags(self) -> int:
        self._settle()
        return self.flags

    def _clear(self, value: int) -> None:
        self._settle()
        self.flags &= ~value
        self._signal()

    def _enable(self, value: int) -> None:
        self._settle()
        self.registers["IER"].value = value
        self._signal()
        self._schedule()

    def _signal(self) -> None:
        self.chip.converters_common.signal()

    def is_signalling(self) -> bool:
        return bool(self.flags & self.registers["IER"].value)

    # Conversions

    def _sampling(self, channel: int) -> float:
        times = self.registers["SMPR1"].value | self.registers["SMPR2"].value << 30
        return SAMPLING[times >> 3 * channel & 7]

    def _append(self, time: int, kind: str, place: int, channel: int) -> int:
        """Plans a conversion from `time` on; returns its end."""
        clock = self.clock()
        sampled = time + round(self._sampling(channel) * clock)
        end = sampled + round(CONVERSION * clock)
        self.plan += [(sampled, "sample", channel), (end, kind, place)]
        return end

    def trigger(self, name: str) -> None:
        self._settle()
        sequence = self.registers["JSQR"].value
        if not self.control & JADSTART or not sequence >> 7 & 3 or TRIGGERS.get(sequence >> 2 & 0x1F) != name:
            return
        if sequence >> 7 & 3 != 1:
            self.undefined("is triggered by an edge that the board's image does not use")
        if any(kind == "injected" for _, kind, _ in self.plan):
            self.undefined("is triggered while its sequence still runs")
        # An injected sequence interrupts a regular conversion, which begins anew behind it (21.4.13).
        repeat = bool(self.plan)
        self.plan = []
        time = self.chip.now
        for rank in range((sequence & 3) + 1):
            time = self._append(time, "injected", rank, sequence >> 9 + 6 * rank & 0x1F)
        if repeat:
            self._append(time, "regular", 0, self.registers["SQR1"].value >> 6 & 0x1F)
        self._schedule()

    def _start_regular(self) -> None:
        if self.registers["SQR1"].value & 0xF:
            self.undefined("more than one regular conversion")
        start = self.plan[-1][0] if self.plan else self.chip.now
        self._append(start, "regular", 0, self.registers["SQR1"].value >> 6 & 0x1F)
        self._schedule()

    def _schedule(self) -> None:
        """The next instant at which something is sampled, or may interrupt; other ends wait for who looks at them."""
        enabled = self.registers["IER"].value
        last = self.registers["JSQR"].value & 3
        for time, kind, place in self.plan:
            flags = JEOC | (JEOS if place == last else 0) if kind == "injected" else EOC | EOS | OVR
            if kind == "sample" or enabled & flags:
                self.due = time
                break
        else:
            self.due = NEVER
        self.chip.reschedule()

    def _settle(self) -> None:
        """Carries out what has ended by now."""
        now = self.chip.now
        ended = False
        while self.plan and self.plan[0][0] <= now:
            ended |= self._carry_out(*self.plan.pop(0)[1:])
        if ended:
            self._signal()

    def step(self) -> None:
        self._settle()
        self._schedule()

    def _carry_out(self, kind: str, place: int) -> bool:
        """True if a conversion has ended."""
        if kind == "sample":
            self.chip.follow_plant()
            self.sampled = self.chip.board.channel(self.chip, self.number, place)
            return False
        code = min(max(int(self.sampled / 3.3 * 4096), 0), 4095)
        if kind == "injected":
            self.results[place] = code
            self.flags |= JEOC
            if place == self.registers["JSQR"].value & 3:
                self.flags |= JEOS
        else:
            if self.flags & EOC:
                self.flags |= OVR
            self.regular = code
            self.flags |= EOC | EOS
            self.control &= ~ADSTART
        return True

    def _result(self, rank: int) -> int:
        self._settle()
        return self.results[rank]

    def _read(self) -> int:
        self._settle()
        self.flags &= ~EOC
        self._signal()
        return self.regular


class Common(Peripheral):
    """What both converters share: clock, interrupt."""

    def __init__(self, chip: object) -> None:
        super().__init__(chip, "ADC12", 0x5000_0300)
        self.register(0x08, "CCR", 0x0043_0000)

    def signal(self) -> None:
        self.chip.processor.set_level(IRQ, any(converter.is_signalling() for converter in self.chip.converters))
        self.chip.attend()
