"""Comparators, operational amplifiers and DAC3 (RM0440, sections 22, 24 and 25)."""

from stm32g4.registers import SECOND, Peripheral

SUPPLY = 3.3
DELAY = SECOND * 31 // 1_000_000_000
"""From a comparator's input to its output (DS12589, section 5.3.22: typically 16.7 ns at 200 mV of overdrive, at most 31 ns)."""


class Dac(Peripheral):
    """DAC3: two channels for the comparators."""

    def __init__(self, chip: object) -> None:
        super().__init__(chip, "DAC3", 0x5000_1000)
        self.register(0x00, "CR", 0x0001_0001, write=self._enable)
        for channel in (0, 1):
            self.register(0x08 + 12 * channel, f"DHR12R{channel + 1}", 0xFFF, write=lambda value, channel=channel: self._set(channel, value))
        self.register(0x3C, "MCR", 0x0007_C007)
        self.codes = [0, 0]

    def _enable(self, value: int) -> None:
        # Section 22.4.1: the interface needs its timing for the bus clock.
        speed = self.registers["MCR"].value >> 14 & 3
        rate = self.chip.clocks.rate
        if value and (0 if rate <= 80e6 else 1 if rate <= 160e6 else 2) > speed:
            self.undefined(f"HFSEL {speed} is too slow for {rate / 1e6:g} MHz")
        self.registers["CR"].value = value
        self.chip.set_trip()

    def _set(self, channel: int, value: int) -> None:
        self.registers[f"DHR12R{channel + 1}"].value = self.codes[channel] = value
        self.chip.set_trip()

    def volts(self, channel: int) -> float | None:
        """Voltage of a channel; None if it is off, or not connected to the inside."""
        if not self.registers["CR"].value >> 16 * channel & 1 or self.registers["MCR"].value >> 16 * channel & 7 != 3:
            return None
        return self.codes[channel] * SUPPLY / 4096


class Comparators(Peripheral):
    """COMP1, COMP2 and COMP4, of shunts A, B and C; DAC3's channel 1 is the reference of the first, 2 of the others."""

    NUMBERS = (1, 2, 4)

    def __init__(self, chip: object) -> None:
        super().__init__(chip, "COMP", 0x4001_0200)
        for place, number in enumerate(self.NUMBERS):

            def write(value: int, number: int = number) -> None:
                self.registers[f"C{number}CSR"].value = value & ~(1 << 30)
                chip.set_trip()

            self.register(
                4 * (number - 1), f"C{number}CSR", 0x4000_0171, read=lambda place=place: self._read(place), write=write
            )  # fmt: skip

    def _read(self, place: int) -> int:
        return self.registers[f"C{self.NUMBERS[place]}CSR"].value | self.chip.is_tripped(place) << 30

    def threshold(self, place: int) -> float | None:
        """Voltage that comparator `place` compares shunt `place` with; None if it is off or compares something else."""
        value = self.registers[f"C{self.NUMBERS[place]}CSR"].value
        # INPSEL 0 is the shunt's pin, INMSEL 4 the DAC.
        if not value & 1 or value >> 8 & 1 or value >> 4 & 7 != 4:
            return None
        return self.chip.dac.volts(0 if place == 0 else 1)


class Amplifiers(Peripheral):
    """OPAMP1 to OPAMP3."""

    GAINS = {0: 2, 1: 4, 2: 8, 3: 16, 4: 32, 5: 64}

    def __init__(self, chip: object) -> None:
        super().__init__(chip, "OPAMP", 0x4001_0300)
        for place in range(3):
            self.register(4 * place, f"OPAMP{place + 1}_CSR", 0x0007_C1ED)

    def output(self, place: int, volts: float) -> float:
        """Voltage of amplifier `place` whose input pin is at `volts`."""
        value = self.registers[f"OPAMP{place + 1}_CSR"].value
        if not value & 1:
            return 0.0
        # VP_SEL 0: the shunt's pin; VM_SEL 2: the gain inside; PGA_GAIN 01xxx: bias at VINM0 (section 25.5.1).
        if value >> 2 & 3 or value >> 5 & 3 != 2 or value >> 17 & 3 != 1:
            self.undefined(f"OPAMP{place + 1} is connected to nothing that the board has: {value:#x}")
        return min(max(self.GAINS[value >> 14 & 7] * volts, 0.0), SUPPLY)
