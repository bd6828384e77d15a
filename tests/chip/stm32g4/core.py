"""The processor's own registers: NVIC, SysTick, SCB (ARMv7-M, DDI 0403, section B3), and DBGMCU."""

from stm32g4.processor import EXTERNAL, SYSTICK
from stm32g4.registers import NEVER, Peripheral

KEY = 0x05FA


class Core(Peripheral):
    """System control space."""

    def __init__(self, chip: object) -> None:
        super().__init__(chip, "SCS", 0xE000_E000)
        processor = chip.processor
        for word in range(4):
            self._interrupts(0x100, "ISER", word, processor.enabled.add)
            self._interrupts(0x180, "ICER", word, processor.enabled.discard)
            self._interrupts(0x200, "ISPR", word, processor.pending.add)
            self._interrupts(0x280, "ICPR", word, processor.pending.discard)
        self.register(0xD88, "CPACR", 0x00F0_0000)
        self.register(0xD08, "VTOR", 0xFFFF_FF80, value=processor.vectors, write=self._vectors)
        self.register(0xD0C, "AIRCR", 0xFFFF_0704, read=lambda: 0xFA05_0000, write=self._reset)
        self.register(0xD14, "CCR", 0x21A, value=0x200)
        self.register(0xF34, "FPCCR", 0xC000_0000, value=0xC000_0000)
        self.systick_started = NEVER
        self.flag = False
        self.register(0x010, "SYST_CSR", 0x1_0007, read=self._systick, write=self._start_systick)
        self.register(0x014, "SYST_RVR", 0xFF_FFFF)
        self.register(0x018, "SYST_CVR", 0xFFFF_FFFF, write=self._clear_systick)
        debug = Peripheral(chip, "DBGMCU", 0xE004_2000)
        # RM0440 section 47.16: what stands still under a debugger, which the model has not.
        debug.register(0x04, "CR", 0x7)
        debug.register(0x08, "APB1FZR1", 0x1 << 12)
        debug.register(0x10, "APB2FZR", 0x1 << 11)

    def _interrupts(self, offset: int, name: str, word: int, act: object) -> None:
        def write(value: int) -> None:
            for bit in range(32):
                if value >> bit & 1:
                    act(EXTERNAL + 32 * word + bit)

        self.register(offset + 4 * word, f"{name}{word}", 0xFFFF_FFFF, read=lambda: 0, write=write)

    def set_priority(self, place: int, value: int) -> None:
        """A byte of NVIC_IPR."""
        self.chip.processor.priority[EXTERNAL + place] = value

    def _vectors(self, value: int) -> None:
        self.registers["VTOR"].value = self.chip.processor.vectors = value

    def _reset(self, value: int) -> None:
        if value >> 16 != KEY:
            self.undefined(f"AIRCR with the key {value >> 16:#x}")
        if value & 4:
            self.chip.request_reset("software")

    # SysTick counts down from RVR; COUNTFLAG is cleared by reading.

    def _start_systick(self, value: int) -> None:
        self.registers["SYST_CSR"].value = value & 7
        self.systick_started = self.chip.now if value & 1 else NEVER
        self._schedule()

    def _clear_systick(self, value: int) -> None:
        self.flag = False
        if self.registers["SYST_CSR"].value & 1:
            self.systick_started = self.chip.now
        self._schedule()

    def _schedule(self) -> None:
        period = (self.registers["SYST_RVR"].value + 1) * self.chip.clocks.unit
        self.due = self.systick_started + period if self.registers["SYST_CSR"].value & 1 else NEVER
        self.chip.reschedule()

    def _systick(self) -> int:
        flag, self.flag = self.flag, False
        return self.registers["SYST_CSR"].value | flag << 16

    def step(self) -> None:
        self.flag = True
        self.systick_started = self.due
        if self.registers["SYST_CSR"].value & 2:
            self.chip.processor.pending.add(SYSTICK)
        self._schedule()
