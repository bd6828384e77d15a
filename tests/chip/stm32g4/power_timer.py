"""TIM1: centre-aligned PWM with complementary outputs, dead time, break and triggers (RM0440, section 28)."""

from stm32g4.registers import NANOSECOND, NEVER, Peripheral, Stopped

UP, CENTRE = 0, 1
FROZEN, INACTIVE, ACTIVE, PWM_1, PWM_2 = 0, 4, 5, 6, 7
OC6REF = 9
UIF, BIF, SBIF = 1 << 0, 1 << 7, 1 << 13
LEGS = "ABC"
MODES = {1: ("CCMR1", 0), 2: ("CCMR1", 8), 3: ("CCMR2", 0), 6: ("CCMR3", 8)}
"""Register and first bit of each channel's mode."""
DEAD_TIME_MIN_NS = 400
"""The board's MOSFETs need this long to turn off behind their drivers: an estimate, half of what ST drives it with."""


class Leg:
    """Channel 1, 2 or 3: reference signal and outputs."""

    def __init__(self) -> None:
        self.reference = False
        self.rose = self.fell = -NEVER
        self.high = self.low = False
        self.high_off = self.low_off = -NEVER


class PowerTimer(Peripheral):
    """TIM1."""

    def __init__(self, chip: object) -> None:
        super().__init__(chip, "TIM1", 0x4001_2C00)
        word = 0xFFFF_FFFF
        # Cleared by a 0; ST's own software writes ones to the reserved bits as well.
        self.register(0x10, "SR", word, read=lambda: self.status, write=self._clear)
        self.register(0x00, "CR1", 0x00E1, read=self._control, write=self._set_control)
        self.register(0x04, "CR2", 0x00F0_2A00)
        self.register(0x0C, "DIER", 0x0000)
        self.write_only(0x14, "EGR", 0x1, self._generate)
        self.register(0x18, "CCMR1", 0x7878, write=lambda value: self._modes("CCMR1", value))
        self.register(0x1C, "CCMR2", 0x0078, write=lambda value: self._modes("CCMR2", value))
        self.register(0x50, "CCMR3", 0x7800, write=lambda value: self._modes("CCMR3", value))
        self.register(0x20, "CCER", 0x0DDD, write=lambda value: self._modes("CCER", value))
        self.read_only(0x24, "CNT", lambda: self.count())
        self.register(0x28, "PSC", 0xFFFF)
        self.register(0x2C, "ARR", 0xFFFF, value=0xFFFF, write=self._set_reload)
        self.register(0x30, "RCR", 0xFF)
        for channel, offset in ((1, 0x34), (2, 0x38), (3, 0x3C), (6, 0x4C)):
            self.register(offset, f"CCR{channel}", 0xFFFF, write=lambda value, channel=channel: self._compare(channel, value))
        self.register(0x44, "BDTR", 0x000F_FFFF, write=self._set_break)
        self.register(0x60, "AF1", 0x001F, value=1, write=self._set_sources)
        self.status = 0
        self.reload = 0xFFFF
        self.repetitions = 0
        self.shadow = {1: 0, 2: 0, 3: 0, 6: 0}
        self.modes = dict.fromkeys(MODES, 0)
        self.legs = [Leg(), Leg(), Leg()]
        self.trigger_level = False
        self.boundary: int | None = None
        """Time at which the counter was 0 last, counting up; None while it stands still."""
        self.half = False
        """The counter counts down."""
        self.break_due = NEVER
        self.unit = chip.clocks.unit
        self.pins = [[self._pin(f"{leg} {side}") for side in ("high", "low")] for leg in LEGS]

    def _pin(self, name: str) -> tuple[object, int, int]:
        port, pin, function = self.chip.board.outputs[name]
        return self.chip.ports[port], pin, function

    # Counter (28.3.2, 28.3.4)

    def position(self) -> int:
        """Counts since the counter was 0."""
        return 0 if self.boundary is None else (self.chip.now - self.boundary) // self.unit

    def count(self) -> int:
        position = self.position()
        return position if position <= self.reload else 2 * self.reload - position

    def _control(self) -> int:
        down = self.boundary is not None and self.position() >= self.reload
        return self.registers["CR1"].value | down << 4

    def _set_control(self, value: int) -> None:
        self.registers["CR1"].value = value
        if value & 1 and self.boundary is None:
            if value >> 5 & 3 == 0:
                self.undefined("edge-aligned counting: the board's image centres its pulses")
            self.unit = self.chip.clocks.unit * (self.registers["PSC"].value + 1)
            self.boundary = self.chip.now
            self.half = False
            self._follow()
        elif not value & 1 and self.boundary is not None:
            self.undefined("is stopped")
        self._schedule()

    def _set_reload(self, value: int) -> None:
        self.registers["ARR"].value = value
        if not self.registers["CR1"].value & 0x80:
            self.reload = value

    def _generate(self, value: int) -> None:
        if value & 1:
            if self.boundary is not None:
                self.undefined("an update is generated while it runs")
            self._update()

    def _update(self) -> None:
        """What is preloaded takes effect (28.3.3)."""
        self.reload = self.registers["ARR"].value
        self.repetitions = self.registers["RCR"].value
        for channel in self.shadow:
            self.shadow[channel] = self.registers[f"CCR{channel}"].value
        self.status |= UIF

    def _overflow(self) -> None:
        """The counter turns round, at either end."""
        if self.repetitions == 0:
            self._update()
        else:
            self.repetitions -= 1

    # Compare and outputs (28.3.11 to 28.3.16)

    def _mode(self, channel: int) -> int:
        return self.modes[channel]

    def _compare(self, channel: int, value: int) -> None:
        self.registers[f"CCR{channel}"].value = value
        if not self._mode(channel) & 0x8:
            self.shadow[channel] = value
            self._follow()
            self._schedule()

    def _modes(self, name: str, value: int) -> None:
        self.registers[name].value = value
        for channel, (register, shift) in MODES.items():
            self.modes[channel] = self.registers[register].value >> shift
        self._follow()
        self._schedule()

    def _reference(self, channel: int, before: bool, now: int) -> bool:
        mode, compare = self._mode(channel) >> 4 & 7, self.shadow[channel]
        if mode in (PWM_1, PWM_2):
            if self.boundary is None:
                active = compare > 0
            elif self.half:
                active = now >= self.boundary + (2 * self.reload - compare) * self.unit
            else:
                active = now < self.boundary + compare * self.unit
            return active == (mode == PWM_1)
        if mode in (INACTIVE, ACTIVE):
            return mode == ACTIVE
        if mode == FROZEN:
            return before
        raise Stopped(f"TIM1: mode {mode} of channel {channel}")

    def _follow(self) -> None:
        """Brings references, outputs and triggers up to the present."""
        now = self.chip.now
        for place, leg in enumerate(self.legs):
            reference = self._reference(place + 1, leg.reference, now)
            if reference != leg.reference:
                leg.reference = reference
                if reference:
                    leg.rose = now
                else:
                    leg.fell = now
        self._drive()
        trigger = self._reference(6, self.trigger_level, now)
        if trigger and not self.trigger_level and self.registers["CR2"].value >> 20 & 0xF == OC6REF:
            self.chip.trigger("TIM1_TRGO2")
        self.trigger_level = trigger

    def dead_time(self) -> int:
        """Clocks of dead time (28.6.20: DTG)."""
        code = self.registers["BDTR"].value & 0xFF
        if code < 0x80:
            return code
        if code < 0xC0:
            return 2 * (64 + (code & 0x3F))
        return (32 + (code & 0x1F)) * (8 if code < 0xE0 else 16)

    def _drive(self) -> None:
        """Outputs of all legs (table of control bits in 28.6.11)."""
        now, break_register = self.chip.now, self.registers["BDTR"].value
        on, off_state = break_register >> 15 & 1, break_register >> 11 & 1
        dead = self.dead_time() * self.unit
        enables = self.registers["CCER"].value
        gates = []
        for place, leg in enumerate(self.legs):
            main, complementary = enables >> 4 * place & 1, enables >> 4 * place + 2 & 1
            high = low = False
            if on:
                if main and complementary:
                    high = leg.reference and now >= leg.rose + dead
                    low = not leg.reference and now >= leg.fell + dead
                elif main:
                    high = leg.reference
                elif complementary:
                    low = leg.reference
                if main != complementary and not off_state:
                    self.undefined(f"leg {LEGS[place]}: an output floats (OSSR 0)")
            high = high and self._is_connected(place, 0)
            low = self._level(place, on, enables, low) and self._is_connected(place, 1)
            if high != leg.high or low != leg.low:
                self._check(place, leg, high, low, now)
                leg.high, leg.low = high, low
            gates.append("high" if high else "low" if low else "off")
        self.chip.set_gates(*gates)

    def _level(self, place: int, on: int, enables: int, low: bool) -> bool:
        """The low side that a complementary output turns on: its polarity, its idle level, and what the driver takes
        for on (28.3.16).
        """
        inverted = enables >> 4 * place + 3 & 1
        idle = self.registers["CR2"].value >> 9 + 2 * place & 1
        level = low ^ inverted if on else idle
        return bool(level ^ self.chip.board.low_sides_active_low)

    def _is_connected(self, place: int, side: int) -> bool:
        port, pin, function = self.pins[place][side]
        return port.function(pin) == function

    def _check(self, place: int, leg: Leg, high: bool, low: bool, now: int) -> None:
        """Both switches of a leg need a pause between them."""
        least = DEAD_TIME_MIN_NS * NANOSECOND
        if high and low:
            self.undefined(f"leg {LEGS[place]}: both switches are on")
        if leg.high and not high:
            leg.high_off = now
        if leg.low and not low:
            leg.low_off = now
        before = leg.low_off if high and not leg.high else leg.high_off if low and not leg.low else -NEVER
        if now - before < least:
            self.undefined(f"leg {LEGS[place]}: {(now - before) / NANOSECOND:.0f} ns between its switches, {DEAD_TIME_MIN_NS} are needed")

    # Break (28.3.17)

    def _set_break(self, value: int) -> None:
        old = self.registers["BDTR"].value
        lock = old >> 8 & 3
        if lock:
            # Level 1 and above: dead time, polarities and sources stay (28.6.20); the level itself is written once.
            fixed = 0x000F_73FF
            value = value & ~fixed | old & fixed
        if self._is_broken() and value >> 12 & 1:
            value &= ~(1 << 15)
        self.registers["BDTR"].value = value
        self._drive()
        self._schedule()

    def _set_sources(self, value: int) -> None:
        if not self.registers["BDTR"].value >> 8 & 3:
            self.registers["AF1"].value = value

    def _is_broken(self) -> bool:
        sources = self.registers["AF1"].value
        level = self.chip.board.breaks(self.chip, sources)
        return level == bool(self.registers["BDTR"].value >> 13 & 1)

    def filter_time(self) -> int:
        """Time of the break's digital filter (28.6.20: BKF)."""
        setting = self.registers["BDTR"].value >> 16 & 0xF
        clocks = [0, 2, 4, 8, 12, 16, 24, 32, 48, 64, 80, 96, 128, 160, 192, 256][setting]
        return clocks * self.chip.clocks.unit

    def comparator_changed(self) -> None:
        """A comparator's output has changed."""
        if self._is_broken() and self.registers["BDTR"].value >> 12 & 1:
            self.break_due = min(self.break_due, self.chip.now + self.filter_time())
        else:
            self.break_due = NEVER

    def fail(self) -> None:
        """The clock has failed: always a source of the break (28.3.16)."""
        if self.registers["BDTR"].value >> 12 & 1:
            self.break_now(system=True)

    def break_now(self, system: bool = False) -> None:
        """All outputs go to their idle states: inactive here."""
        self.break_due = NEVER
        self.status |= SBIF if system else BIF
        self.registers["BDTR"].value &= ~(1 << 15)
        self._drive()
        self._schedule()

    def _clear(self, value: int) -> None:
        self.status &= value
        if self._is_broken() and self.registers["BDTR"].value >> 12 & 1:
            self.status |= BIF

    # Events

    def _schedule(self) -> None:
        if self.boundary is None:
            self.due = NEVER
            self.chip.reschedule()
            return
        now, unit = self.chip.now, self.unit
        turn = self.boundary + (2 if self.half else 1) * self.reload * unit
        due = turn
        enables, on = self.registers["CCER"].value, self.registers["BDTR"].value >> 15 & 1
        dead = self.dead_time() * unit
        for channel in (1, 2, 3, 6):
            if channel != 6 and not on:
                continue
            compare = self.shadow[channel]
            if self._mode(channel) >> 4 & 7 >= PWM_1:
                edge = self.boundary + (2 * self.reload - compare if self.half else compare) * unit
                if now < edge < due:
                    due = edge
            if channel != 6 and enables >> 4 * (channel - 1) & 5 == 5:
                leg = self.legs[channel - 1]
                over = (leg.rose if leg.reference else leg.fell) + dead
                if now < over < due:
                    due = over
        self.due = due
        self.chip.reschedule()

    def step(self) -> None:
        now = self.chip.now
        turn = self.boundary + (2 if self.half else 1) * self.reload * self.unit
        if now >= turn:
            if self.half:
                self.boundary = turn
            self.half = not self.half
            self._overflow()
        self._follow()
        self._schedule()
