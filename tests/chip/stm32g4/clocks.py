"""Reset and clock control, power control, and what else is set once: SYSCFG (RM0440, sections 6, 7 and 10)."""

from stm32g4.processor import NMI
from stm32g4.registers import NEVER, SECOND, Peripheral

MHZ = 1_000_000
HSI = 16 * MHZ
LSI = 32_000
HSE_START, PLL_START, LSI_START = SECOND // 500, SECOND // 25_000, SECOND // 7_500
"""Start-up times: 2 ms, 40 us, 133 us (DS12589, section 5.3)."""
HSE_ON, SECURITY, PLL_ON, FAILURE = 1 << 16, 1 << 19, 1 << 24, 1 << 8
FLAGS = {"option": 25, "pin": 26, "power": 27, "software": 28, "watchdog": 29}
REMOVE_FLAGS = 1 << 23
GATES = {
    # Register, bit: peripherals of every board that stand still without it (section 7.4).
    ("AHB2ENR", 0): ("GPIOA",),
    ("AHB2ENR", 1): ("GPIOB",),
    ("AHB2ENR", 2): ("GPIOC",),
    ("AHB2ENR", 13): ("ADC1", "ADC2", "ADC12"),
    ("APB1ENR1", 10): ("TAMP",),
    ("APB1ENR1", 25): ("FDCAN1", "FDCAN2", "SRAMCAN"),
    ("APB1ENR1", 28): ("PWR",),
    ("APB2ENR", 0): ("SYSCFG", "COMP", "OPAMP"),
    ("APB2ENR", 11): ("TIM1",),
}


class Clocks(Peripheral):
    """RCC, PWR and SYSCFG."""

    def __init__(self, chip: object, causes: set[str]) -> None:
        super().__init__(chip, "RCC", 0x4002_1000)
        self.gates = GATES | {place: (name,) for name, place in chip.board.clocked.items()}
        self.ready: dict[str, int] = {}
        self.rate = HSI
        self.unit = SECOND // HSI
        self.register(0x00, "CR", 0x030F_0500, read=self._control, write=self._set_control)
        self.register(0x08, "CFGR", 0x0000_00FF, value=1, read=self._switches, write=self._switch)
        self.register(0x0C, "PLLCFGR", 0x0700_7FF3, value=0x1000, write=self._set_pll)
        self.read_only(0x1C, "CIFR", lambda: FAILURE if self.has_failed else 0)
        self.write_only(0x20, "CICR", FAILURE, self._acknowledge)
        self.has_failed = False
        self.on = 0x100
        for offset, name, start in ((0x48, "AHB1ENR", 0x100), (0x4C, "AHB2ENR", 0), (0x58, "APB1ENR1", 0x400), (0x60, "APB2ENR", 0)):
            known = start | chip.board.idle_clocks.get(name, 0) | sum(1 << bit for register, bit in self.gates if register == name)
            self.register(offset, name, known, value=start, write=lambda value, name=name: self._gate(name, value))
        for offset, name in ((0x28, "AHB1RSTR"), (0x2C, "AHB2RSTR"), (0x38, "APB1RSTR1"), (0x40, "APB2RSTR")):
            # Only of what nothing has been done to since its own reset, so it has no effect.
            self.register(offset, name, chip.board.resets.get(name, 0))
        # FDCAN and LPTIM1 have a clock of their own (section 7.4.27).
        self.register(0x88, "CCIPR", 0x030C_0000)
        self.register(0x9C, "CCIPR2", 0x0)
        self.flags = sum(1 << FLAGS[cause] for cause in causes)
        self.register(0x94, "CSR", 0xFFFF_FFFF, read=self._status, write=self._set_status)
        self.lsi_on = False
        # Oscillator of 48 MHz (section 7.4.30): on and ready. Clock of RTC (section 7.4.26): selected, and of no use here.
        self.register(0x98, "CRRCR", 0x1, read=lambda: self.registers["CRRCR"].value * 3, write=self._set_usb)
        self.register(0x90, "BDCR", 0x1_8300)

        power = self.power = Peripheral(chip, "PWR", 0x4000_7000)
        power.register(0x00, "CR1", 0x700, value=0x200)
        power.register(0x08, "CR3", 0xC000, value=0x8000)
        power.register(0x80, "CR5", 0x100, value=0x100)
        self.configuration = Peripheral(chip, "SYSCFG", 0x4001_0000)
        # Section 10.2.1: the first bank of the flash at its place.
        self.configuration.register(0x00, "MEMRMP", 0x0)
        # Section 10.2.7: lock-up of the processor breaks the timers.
        self.configuration.register(0x1C, "CFGR2", 0x1)
        # Writes to the backup registers need DBP (section 6.4.1).
        backup = self.backup = Peripheral(chip, "TAMP", 0x4000_2400)
        for number in range(4):
            backup.register(0x100 + 4 * number, f"BKP{number}R", 0xFFFF_FFFF, write=lambda value, number=number: self._keep(number, value))
        for names in self.gates.values():
            for name in names:
                chip.gated[name] = False
        chip.gated["TAMP"] = True

    def _set_usb(self, value: int) -> None:
        self.registers["CRRCR"].value = value & 1

    def _keep(self, number: int, value: int) -> None:
        if not self.power.registers["CR1"].value & 0x100:
            self.undefined("a backup register is written without DBP")
        self.backup.registers[f"BKP{number}R"].value = value

    def _gate(self, name: str, value: int) -> None:
        self.registers[name].value = value
        for (register, bit), names in self.gates.items():
            if register == name:
                for gated in names:
                    self.chip.gated[gated] = bool(value >> bit & 1)

    def is_ready(self, name: str) -> bool:
        return self.chip.now >= self.ready.get(name, 1 << 62)

    def _control(self) -> int:
        value = self.on | 0x400
        for name, bit in (("HSE", 17), ("PLL", 25)):
            value |= self.is_ready(name) << bit
        return value

    def _set_control(self, value: int) -> None:
        for name, bit, start in (("HSE", 16, HSE_START), ("PLL", 24, PLL_START)):
            if value >> bit & 1:
                self.ready.setdefault(name, self.chip.now + start if name != "HSE" or self.chip.crystal_runs else NEVER)
            else:
                self.ready.pop(name, None)
        if value >> 24 & 1 and not self.is_ready("HSE"):
            self.undefined("the PLL is started without its source")
        self.on = value & 0x0109_0100

    def set_crystal(self, runs: bool) -> None:
        """The crystal of the board stops, or starts again: clock security system (section 7.2.10)."""
        self.chip.crystal_runs = runs
        if not self.on & HSE_ON:
            return
        if runs:
            self.ready["HSE"] = self.chip.now + HSE_START
            return
        if not self.on & SECURITY:
            self.undefined("the crystal has stopped, and nobody watches it")
        del self.ready["HSE"]
        self.on &= ~HSE_ON
        if self.registers["PLLCFGR"].value & 3 == 3:
            self.on &= ~PLL_ON
            self.ready.pop("PLL", None)
        self._switch(1)
        self.has_failed = True
        self.chip.power_timer.fail()
        self.chip.processor.set_level(NMI, True)
        self.chip.attend()

    def _acknowledge(self, value: int) -> None:
        if value & FAILURE:
            self.has_failed = False
            self.chip.processor.set_level(NMI, False)

    def _set_pll(self, value: int) -> None:
        if self.on >> 24 & 1:
            self.undefined("PLLCFGR is written while the PLL is on")
        self.registers["PLLCFGR"].value = value

    def pll(self) -> float:
        """Frequency of PLL's output R, Hz (section 7.2.4)."""
        value = self.registers["PLLCFGR"].value
        source = {2: HSI, 3: self.chip.board.crystal}.get(value & 3)
        if source is None:
            self.undefined("the PLL has no source")
        reference = source / ((value >> 4 & 0xF) + 1)
        oscillator = reference * (value >> 8 & 0x7F)
        if not 2.66e6 <= reference <= 16e6 or not 96e6 <= oscillator <= 344e6:
            self.undefined(f"the PLL gets {reference / 1e6:g} MHz and makes {oscillator / 1e6:g} MHz")
        if not value >> 24 & 1:
            self.undefined("the output of the PLL is not enabled")
        return oscillator / (2 * (value >> 25 & 3) + 2)

    def _switches(self) -> int:
        value = self.registers["CFGR"].value
        return value | (value & 3) << 2

    def _switch(self, value: int) -> None:
        value &= ~0xC
        self.registers["CFGR"].value = value
        prescaler = value >> 4 & 0xF
        divider = 1 if prescaler < 8 else {8: 2, 9: 4, 10: 8, 11: 16}.get(prescaler, 64)
        match value & 3:
            case 1:
                rate = float(HSI)
            case 2:
                rate = float(self.chip.board.crystal)
            case 3:
                if not self.is_ready("PLL"):
                    self.undefined("the PLL is selected before it is ready")
                rate = self.pll()
            case _:
                self.undefined("no clock is selected")
        rate /= divider
        if rate > 80e6 and self.rate < 80e6 and divider == 1 and not self.chip.board.jumps_to_full_speed:
            self.undefined("the clock rises above 80 MHz in one step (section 7.2.7)")
        self._check(rate)
        self.rate = rate
        self.unit = round(SECOND / rate)
        self.chip.processor.clock.per_cycle = self.unit

    def _check(self, rate: float) -> None:
        """Voltage range and wait states (sections 6.1.5 and 3.3.3)."""
        boost = not self.power.registers["CR5"].value & 0x100
        if rate > (170e6 if boost else 150e6) + 1:
            self.undefined(f"{rate / 1e6:g} MHz are too fast{'' if boost else ' without boost'}")
        states = self.chip.flash.registers["ACR"].value & 0xF
        if rate > (34e6 if boost else 30e6) * (states + 1) + 1:
            self.undefined(f"{states} wait states are too few for {rate / 1e6:g} MHz")

    def _status(self) -> int:
        return self.flags | self.lsi_on | self.is_ready("LSI") << 1

    def _set_status(self, value: int) -> None:
        self.lsi_on = bool(value & 1)
        if self.lsi_on:
            self.ready.setdefault("LSI", self.chip.now + LSI_START)
        if value & REMOVE_FLAGS:
            self.flags = 0
