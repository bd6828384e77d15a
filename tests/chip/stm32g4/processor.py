"""The processor: unicorn executes, exceptions are modelled here (ARMv7-M, DDI 0403, section B1.5).

Traps of unicorn that this file knows: it has no NVIC; a branch to EXC_RETURN comes as interrupt 8; it gives no
instruction count; the program counter that a callback reads is that of an older block; WFI ends emu_start, and WFE
with an error.
Memory that it executes cannot be watched, so of the flash only the running program is that; the rest are data.
"""

import ctypes
import mmap
import struct
import subprocess
import tempfile
from pathlib import Path

import unicorn
from unicorn import arm_const as arm
from unicorn.unicorn_py3.unicorn import uclib

from stm32g4.registers import NEVER, Stopped

FLASH, RAM, SYSTEM = 0x0800_0000, 0x2000_0000, 0x1FFF_7000
PAGE = 0x800
"""Page of the flash, and of the emulator."""
NMI, HARD_FAULT, SYSTICK, EXTERNAL = 2, 3, 15, 16
THREAD = 0x100
"""Priority of the program outside exceptions: below every other."""
EXC_RETURN, EXC_RETURN_NESTED, NO_FLOAT = 0xFFFF_FFE9, 0xFFFF_FFE1, 0x10
EXCEPTION_EXIT = 8
WFI, WFE = b"\x30\xbf", b"\x20\xbf"
FLOATS = [*(arm.UC_ARM_REG_S0 + index for index in range(16)), arm.UC_ARM_REG_FPSCR]
FRAME = [arm.UC_ARM_REG_R0, arm.UC_ARM_REG_R1, arm.UC_ARM_REG_R2, arm.UC_ARM_REG_R3, arm.UC_ARM_REG_R12, arm.UC_ARM_REG_LR]
ENTRY_CYCLES, EXIT_CYCLES = 12, 10
"""Cycles of an exception's entry and return without wait states (Cortex-M4 TRM, DDI 0439, section 3.9.1)."""
READ = ctypes.CFUNCTYPE(ctypes.c_uint64, ctypes.c_void_p, ctypes.c_uint64, ctypes.c_uint, ctypes.c_void_p)
WRITE = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_uint64, ctypes.c_uint, ctypes.c_uint64, ctypes.c_void_p)
"""Callbacks of the emulator. Its own Python wraps them three times, which half of a run's time would go into."""


class Clock(ctypes.Structure):
    """The structure of engine.c."""

    _fields_ = [
        *((name, ctypes.c_uint64) for name in ("time", "deadline", "per_cycle", "instructions", "block", "watches_mask", "start", "end", "lowest", "cause", "event", "ram", "size")),
        *((name, ctypes.c_void_p) for name in ("program", "memory", "stop", "read", "write")),
        *((name, ctypes.c_int32) for name in ("sp", "xpsr", "control", "primask")),
        ("frame", ctypes.c_int32 * len(FRAME)),
        ("floats", ctypes.c_int32 * len(FLOATS)),
    ]


def compiled() -> ctypes.CDLL:
    """Compiles engine.c, once."""
    if not hasattr(compiled, "library"):
        folder = tempfile.TemporaryDirectory()
        library = Path(folder.name) / "engine.so"
        source = Path(__file__).with_name("engine.c")
        subprocess.run(["cc", "-O2", "-shared", "-fPIC", "-Wall", "-Wextra", "-Werror", "-o", library, source], check=True)
        compiled.folder, compiled.library = folder, ctypes.CDLL(str(library))
        compiled.library.stack_frame.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_uint32]
        compiled.library.unstack_frame.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int]
        compiled.library.unstack_frame.restype = ctypes.c_uint32
    return compiled.library


class Processor:
    """Cortex-M4F with its NVIC. `bus` has `read(address, size)` and `write(address, size, value)`."""

    def __init__(self, bus: object, board: object) -> None:
        self.bus, self.board = bus, board
        engine = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB | unicorn.UC_MODE_MCLASS)
        engine.ctl_set_cpu_model(arm.UC_CPU_ARM_CORTEX_M4)
        engine.ctl_set_page_size(PAGE)
        self.engine = engine
        # A copy of this process has its own memories.
        private = mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS
        self.flash = mmap.mmap(-1, board.flash_size, flags=private)
        self.ram = mmap.mmap(-1, board.ram_size, flags=private)
        self._flash = ctypes.addressof((ctypes.c_char * board.flash_size).from_buffer(self.flash))
        ram = ctypes.addressof((ctypes.c_char * board.ram_size).from_buffer(self.ram))
        engine.mem_map(FLASH, board.flash_size, unicorn.UC_PROT_READ)
        engine.mem_map_ptr(RAM, board.ram_size, unicorn.UC_PROT_READ | unicorn.UC_PROT_WRITE, ram)
        engine.mem_map(SYSTEM, 0x1000, unicorn.UC_PROT_READ)
        self.native = compiled()
        self.clock = Clock(
            deadline=NEVER,
            start=FLASH,
            ram=RAM,
            size=board.ram_size,
            program=self._flash,
            memory=ram,
            stop=ctypes.cast(uclib.uc_emu_stop, ctypes.c_void_p).value,
            read=ctypes.cast(uclib.uc_reg_read, ctypes.c_void_p).value,
            write=ctypes.cast(uclib.uc_reg_write, ctypes.c_void_p).value,
            sp=arm.UC_ARM_REG_SP,
            xpsr=arm.UC_ARM_REG_XPSR,
            control=arm.UC_ARM_REG_CONTROL,
            primask=arm.UC_ARM_REG_PRIMASK,
            frame=(ctypes.c_int32 * len(FRAME))(*FRAME),
            floats=(ctypes.c_int32 * len(FLOATS))(*FLOATS),
        )
        self._emulator, self._clock = engine._uch, ctypes.addressof(self.clock)
        self._word = ctypes.c_uint32()
        self._callbacks: list[object] = []
        for start, size in ((0x4000_0000, 0x3_0000), (0x4800_0000, 0x2000), (0x5000_0000, 0x2000), (0xE000_0000, 0x10_0000)):
            self._map_registers(start, size)
        hook, everywhere = ctypes.c_size_t(), (ctypes.c_uint64(1), ctypes.c_uint64(0))
        for kind, function in ((unicorn.UC_HOOK_BLOCK, self.native.on_block), (unicorn.UC_HOOK_INTR, self.native.on_interrupt)):
            pointer = ctypes.cast(function, ctypes.c_void_p)
            uclib.uc_hook_add(engine._uch, ctypes.byref(hook), kind, pointer, self._clock, *everywhere)
        self.exception = 0
        self.reset_state()

    def load(self, end: int, stack_end: int) -> None:
        """What stands below `end` in the flash is the program from now on, with a stack down to `stack_end`. The pages
        behind it are registers to the emulator, so that writes and errors of a word are the flash controller's.
        """
        self.data_start = -(-end // PAGE) * PAGE
        self.stack_end = stack_end
        self.clock.end = self.data_start
        self.clock.lowest = NEVER
        self.engine.mem_unmap(FLASH, self.board.flash_size)
        size = self.data_start - FLASH
        self.engine.mem_map_ptr(FLASH, size, unicorn.UC_PROT_READ | unicorn.UC_PROT_EXEC, self._flash)
        self._map_registers(self.data_start, self.board.flash_size - size)
        # Code that was translated may have been written anew.
        self.engine.ctl_flush_tb()

    def _map_registers(self, start: int, size: int) -> None:
        bus = self.bus

        def read(_: int, offset: int, size: int, __: object) -> int:
            try:
                return bus.read(start + offset, size)
            except Exception as problem:
                self._stop(problem)
                return 0

        def write(_: int, offset: int, size: int, value: int, __: object) -> None:
            try:
                bus.write(start + offset, size, value)
            except Exception as problem:
                self._stop(problem)

        callbacks = READ(read), WRITE(write)
        self._callbacks += callbacks
        status = uclib.uc_mmio_map(self._emulator, start, size, callbacks[0], 0, callbacks[1], 0)
        if status != unicorn.UC_ERR_OK:
            raise unicorn.UcError(status)

    def _read(self, register: int) -> int:
        uclib.uc_reg_read(self._emulator, register, ctypes.byref(self._word))
        return self._word.value

    def _stop(self, problem: Exception) -> None:
        """Ends the run with this exception; a callback cannot raise it."""
        self._problem = self._problem or problem
        self.engine.emu_stop()

    def reset_state(self) -> None:
        """Everything but memory as a reset leaves it."""
        self.enabled: set[int] = set()
        self.priority = [0] * 128
        self.pending: set[int] = set()
        self.levels: set[int] = set()
        self.active: list[int] = []
        self.sleeps = False
        self.vectors = FLASH
        self.longest: dict[int, tuple[int, int]] = {}
        """Instructions and time of the longest run of every exception, without those that interrupt it."""
        self._entered: list[list[int]] = []

    def start(self) -> None:
        """Loads stack pointer and program counter from the vector table (B1.5.5)."""
        stack, entry = struct.unpack_from("<II", self.flash, self.vectors - FLASH)
        engine = self.engine
        for register in (*FRAME, *(arm.UC_ARM_REG_R4 + index for index in range(8))):
            engine.reg_write(register, 0)
        engine.reg_write(arm.UC_ARM_REG_XPSR, 1 << 24)
        engine.reg_write(arm.UC_ARM_REG_PRIMASK, 0)
        engine.reg_write(arm.UC_ARM_REG_CONTROL, 0)
        engine.reg_write(arm.UC_ARM_REG_SP, stack)
        engine.reg_write(arm.UC_ARM_REG_LR, 0xFFFF_FFFF)
        self.pc = entry & ~1

    # NVIC (B3.4)

    def set_level(self, number: int, is_high: bool) -> None:
        """The line of an interrupt: it is pending while it is high and not being handled."""
        if is_high:
            self.levels.add(number)
        else:
            self.levels.discard(number)

    def waiting(self) -> int | None:
        """The most urgent exception that would interrupt what runs, whether it is masked or not."""
        now = self._priority(self.active[-1]) if self.active else THREAD
        best, number = now, None
        for exception in self.pending | self.levels:
            if exception in self.active or (exception >= EXTERNAL and exception not in self.enabled):
                continue
            priority = self._priority(exception)
            if priority < best or (priority == best and number is not None and exception < number):
                best, number = priority, exception
        return number

    def attend(self) -> None:
        """Looks for an exception that waits, while the emulator runs: it stops when none of them is masked."""
        if self.waiting() is not None:
            self.clock.watches_mask = 1

    def _priority(self, exception: int) -> int:
        # STM32G4 implements the four upper bits.
        return {NMI: -2, HARD_FAULT: -1}.get(exception, self.priority[exception] & 0xF0)

    def is_masked(self, exception: int) -> bool:
        return exception > HARD_FAULT and bool(self._read(arm.UC_ARM_REG_PRIMASK) & 1)

    def enter(self, exception: int) -> None:
        """Exception entry (B1.5.6): stacks the frame, and branches to the vector."""
        has_floats = self.native.stack_frame(self._emulator, self._clock, self.pc)
        if has_floats < 0:
            raise Stopped(f"exception {exception} finds the stack outside of the RAM")
        link = (EXC_RETURN_NESTED if self.active else EXC_RETURN) | (0 if has_floats else NO_FLOAT)
        self.engine.reg_write(arm.UC_ARM_REG_LR, link)
        self.clock.time += ENTRY_CYCLES * self.clock.per_cycle
        self._branch(exception)

    def _branch(self, exception: int) -> None:
        self.active.append(exception)
        self.pending.discard(exception)
        self.engine.reg_write(arm.UC_ARM_REG_XPSR, 1 << 24 | exception)
        vector = struct.unpack_from("<I", self.flash, self.vectors - FLASH + 4 * exception)[0]
        self.pc = vector & ~1
        self._entered.append([exception, self.clock.instructions, self.clock.time])

    def leave(self) -> None:
        """Exception return (B1.5.8); an exception that waits is entered without unstacking (tail-chaining)."""
        link = self.pc | 1
        self.active.pop()
        exception, instructions, time = self._entered.pop()
        spent = (self.clock.instructions - instructions, self.clock.time - time)
        if self._entered:
            # What it has interrupted began as much later.
            outer = self._entered[-1]
            outer[1], outer[2] = outer[1] + spent[0], outer[2] + spent[1]
        self.longest[exception] = max(self.longest.get(exception, (0, 0)), spent)
        waiting = self.waiting()
        if waiting is not None and not self.is_masked(waiting):
            self.engine.reg_write(arm.UC_ARM_REG_LR, link)
            self.clock.time += 6 * self.clock.per_cycle
            self._branch(waiting)
            return
        self.pc = self.native.unstack_frame(self._emulator, self._clock, not link & NO_FLOAT)
        if not self.pc:
            raise Stopped(f"exception {exception} leaves the stack outside of the RAM")
        self.clock.time += EXIT_CYCLES * self.clock.per_cycle

    def run(self, deadline: int) -> None:
        """Executes until `deadline`, or until something else needs attention."""
        waiting = self.waiting()
        clock = self.clock
        clock.watches_mask = 0
        if waiting is not None:
            if not self.is_masked(waiting):
                self.enter(waiting)
            else:
                clock.watches_mask = 1
        clock.deadline = deadline
        clock.cause = 0
        self._problem: Exception | None = None
        status = uclib.uc_emu_start(self._emulator, self.pc | 1, 0xFFFF_FFFF, 0, 0)
        if self._problem is not None:
            raise self._problem
        self.pc = self._read(arm.UC_ARM_REG_PC)
        if status == unicorn.UC_ERR_INSN_INVALID and self._is_behind(WFE):
            self.sleeps, clock.event = not clock.event, 0
            return
        if status != unicorn.UC_ERR_OK:
            if status != unicorn.UC_ERR_FETCH_PROT or not self.data_start <= self.pc < FLASH + self.board.data:
                raise Stopped(f"the processor: {unicorn.UcError(status)}")
            self.bus.enter_slot()
            return
        if clock.lowest < self.stack_end:
            raise Stopped(f"the stack reaches down to {clock.lowest:#x}, into the variables below {self.stack_end:#x}")
        if clock.cause == EXCEPTION_EXIT:
            self.leave()
        elif clock.cause:
            raise Stopped(f"the processor takes exception {clock.cause} of the emulator")
        elif clock.time < deadline and self._is_behind(WFI):
            self.sleeps = True

    def _is_behind(self, instruction: bytes) -> bool:
        place = self.pc - FLASH - 2
        return bytes(self.flash[place : place + 2]) == instruction
