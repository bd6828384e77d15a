"""The chip on its board: everything together, and the passing of time."""

import bisect
from collections.abc import Callable
from pathlib import Path

import narx
from elftools.elf.elffile import ELFFile

from stm32g4.analog import DELAY
from stm32g4.boards import B_G431B_ESC1, Board
from stm32g4.clocks import LSI, Clocks
from stm32g4.converter import Common, Converter
from stm32g4.core import Core
from stm32g4.fdcan import Bus, Fdcan, MessageMemory
from stm32g4.flash import Flash, PowerCut, blank
from stm32g4.gpio import ANALOG, Port
from stm32g4.power_timer import PowerTimer
from stm32g4.processor import FLASH, Processor
from stm32g4.registers import NEVER, SECOND, Register, Stopped
from stm32g4.watchdog import Watchdog

PRIORITY_BYTES = 0xE000_E400
REGISTRY = b"/registry/src/"
DEFAULT_MOTOR = "bly172s-24v"
LONGEST = 1.0
"""Time that the plant advances in one call, s."""


class Image:
    """An image's segments and source lines."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.places: list[tuple[int, str]] = []
        with path.open("rb") as file:
            elf = ELFFile(file)
            segments = [segment for segment in elf.iter_segments() if segment["p_type"] == "PT_LOAD" and segment["p_filesz"]]
            self.segments = [(segment["p_paddr"], segment.data()) for segment in segments]
            symbols = {symbol.name: symbol["st_value"] for symbol in elf.get_section_by_name(".symtab").iter_symbols()}
            self.stack_end = symbols["_stack_end"]
            self.vectors = elf.get_section_by_name(".vector_table")["sh_addr"]
        self.end = max(start + len(data) for start, data in self.segments)

    def line(self, address: int) -> str:
        """Source line of an address: the nearest one before it in this project's own files."""
        if not self.places:
            self.places = sorted(self._lines())
        place = bisect.bisect_right(self.places, (address, "\x7f")) - 1
        return self.places[place][1] if place >= 0 else "?"

    def _lines(self) -> list[tuple[int, str]]:
        found = []
        with self.path.open("rb") as file:
            information = ELFFile(file).get_dwarf_info()
            for unit in information.iter_CUs():
                if REGISTRY in unit.get_top_DIE().attributes["DW_AT_comp_dir"].value:
                    continue
                program = information.line_program_for_CU(unit)
                files, folders = program["file_entry"], program["include_directory"]
                for entry in program.get_entries():
                    if (state := entry.state) is None or state.end_sequence or state.address < FLASH:
                        continue
                    file_entry = files[state.file - 1]
                    folder = folders[file_entry.dir_index - 1].decode()
                    if not folder.startswith("/"):
                        found.append((state.address, f"{folder}/{file_entry.name.decode()}:{state.line}"))
        return found


class Chip:
    """An STM32G4 on its board with a motor.

    `image`: the drive's. It is put into the flash and started, unless there is a `boot`loader: then that is, and what
    it enters is what `flash` has in the slot. `flash`: contents of the whole flash before; blank by default.
    """

    def __init__(
        self,
        image: Image,
        plant: narx.Plant | None = None,
        flash: bytes | None = None,
        boot: Image | None = None,
        board: Board = B_G431B_ESC1,
    ) -> None:
        self.image, self.boot, self.board = image, boot, board
        self.plant = plant or narx.Plant(narx.Motor.preset(DEFAULT_MOTOR), supply_voltage=24.0)
        self.plant_start = 0
        self.lsi_rate = LSI
        self.processor = Processor(self, board)
        self.processor.flash[:] = flash or blank(board)
        for start, data in (boot or image).segments:
            self.processor.flash[start - FLASH : start - FLASH + len(data)] = data
        self.resets: list[str] = []
        self.has_lost_power = False
        self.button_pressed = self.pwm_input = False
        self.crystal_runs = True
        self.potentiometer = 2.0
        self.foreign_current = [0.0, 0.0, 0.0]
        """Currents that flow through the shunts beside the motor's, A: a fault of the wiring."""
        self.mutations: list[Callable[[Chip], None]] = []
        self.bus: Bus | None = None
        self._reset({"power", "pin"})

    @property
    def now(self) -> int:
        """Time since power-up, 1 / SECOND s."""
        return self._event if self._event is not None else self.processor.clock.time

    @property
    def time(self) -> float:
        """Time since power-up, s."""
        return self.processor.clock.time / SECOND

    def _reset(self, causes: set[str]) -> None:
        self._event: int | None = None
        self.request: str | None = None
        self.end = NEVER
        self.map: dict[int, Register] = {}
        self.gated: dict[str, bool] = {}
        self.due, self.first = NEVER, None
        """Time of the next event, and whose it is."""
        self.followed = -1
        """Time to which the motor was brought last."""
        self.break_delay = NEVER
        self.gates = ("off", "off", "off")
        self.processor.reset_state()
        first = self.boot or self.image
        self.processor.load(first.end, first.stack_end)
        self.processor.vectors = first.vectors
        self.peripherals = []
        kept = [register.value for register in self.clocks.backup.registers.values()] if hasattr(self, "clocks") else None
        self.clocks = Clocks(self, causes)
        if kept is not None and "power" not in causes:
            for register, value in zip(self.clocks.backup.registers.values(), kept, strict=True):
                register.value = value
        self.flash = Flash(self)
        self.core = Core(self)
        self.watchdog = Watchdog(self)
        self.ports = {letter: Port(self, letter) for letter in "ABC"}
        of_board = self.board.make(self)
        self.converters_common = Common(self)
        self.converters = [Converter(self, 1), Converter(self, 2)]
        old_bus = self.bus
        self.fdcan = Fdcan(self)
        self.message_memory = MessageMemory(self)
        self.bus = Bus(self)
        if old_bus is not None:
            for name in ("host", "passed", "is_there", "is_broken"):
                setattr(self.bus, name, getattr(old_bus, name))
        self.power_timer = PowerTimer(self)
        self.eventful = [self.power_timer, *self.converters, *of_board, self.bus, self.watchdog, self.core]
        self._find_trip()
        self.tripped = [False, False, False]
        self.processor.clock.per_cycle = self.clocks.unit
        self.plant.set_gates(*self.gates)
        for mutation in self.mutations:
            mutation(self)
        self.processor.start()

    def enter_slot(self) -> None:
        """The bootloader branches to the program in the slot."""
        if self.processor.vectors != self.image.vectors:
            raise Stopped(f"enters the slot with vectors at {self.processor.vectors:#x}")
        self.processor.load(FLASH + self.board.data, self.image.stack_end)

    def line(self, address: int) -> str:
        """Source line of an address."""
        in_boot = self.boot is not None and address < self.boot.end
        return (self.boot if in_boot else self.image).line(address)

    def mutate(self, mutation: "Callable[[Chip], None]") -> None:
        """A deliberate fault of the driver, from the next access on and after every reset."""
        self.mutations.append(mutation)
        mutation(self)

    def find(self, name: str) -> Register:
        """A register by its name, as in "TIM1.BDTR"."""
        return next(register for register in self.map.values() if str(register) == name)

    # Accesses of the processor

    def read(self, address: int, size: int) -> int:
        self._catch_up()
        register = self.map.get(address)
        if register is not None and (size == 4 or (size == 2 and register.peripheral.takes_halfwords)):
            self._check_clock(register.peripheral.name)
            return register.read()
        if FLASH <= address < FLASH + self.board.flash_size:
            return self.flash.read(address, size)
        memory = self.message_memory
        if memory.base <= address < memory.base + memory.size and size == 4:
            self._check_clock(memory.name)
            return memory.read(address - memory.base)
        raise Stopped(f"reads {size} bytes at {address:#010x}, which the model does not know")

    def write(self, address: int, size: int, value: int) -> None:
        self._catch_up()
        register = self.map.get(address)
        if register is not None and (size == 4 or (size == 2 and register.peripheral.takes_halfwords)):
            self._check_clock(register.peripheral.name)
            register.write(value)
            return
        if FLASH <= address < FLASH + self.board.flash_size:
            self.flash.write(address, size, value)
            return
        memory = self.message_memory
        if memory.base <= address < memory.base + memory.size and size == 4:
            self._check_clock(memory.name)
            memory.write(address - memory.base, value)
            return
        if PRIORITY_BYTES <= address < PRIORITY_BYTES + 112 and size == 1:
            self.core.set_priority(address - PRIORITY_BYTES, value)
            return
        raise Stopped(f"writes {size} bytes at {address:#010x}, which the model does not know")

    def _check_clock(self, name: str) -> None:
        if not self.gated.get(name, True):
            raise Stopped(f"{name} has no clock")

    # Time

    def reschedule(self) -> None:
        """An event has moved."""
        due = NEVER
        for peripheral in self.eventful:
            if peripheral.due < due:
                due, self.first = peripheral.due, peripheral
        self.due = due
        self.processor.clock.deadline = due if due < self.end else self.end

    def attend(self) -> None:
        """An interrupt may have come."""
        self.processor.attend()

    def _catch_up(self) -> None:
        if self.processor.clock.time >= self.due:
            self._run_events(self.processor.clock.time)

    def _run_events(self, until: int) -> None:
        while self.due <= until:
            first, self._event = self.first, self.due
            if first is self.power_timer:
                self.follow_plant()
            first.step()
            self._event = None
            if self.request:
                return

    def stall(self, time: int) -> None:
        """The processor waits for the flash."""
        clock = self.processor.clock
        clock.time += time
        self._catch_up()

    def request_reset(self, cause: str) -> None:
        self.request = cause
        self.end = 0
        self.processor.clock.deadline = 0

    def interrupt_now(self, exception: int) -> None:
        self.processor.pending.add(exception)
        self.attend()

    def run(self, seconds: float, until: Callable[[], bool] | None = None) -> bool:
        """Lets time pass; with `until` until that is true, which is returned."""
        end = self.processor.clock.time + round(seconds * SECOND)
        if self.has_lost_power:
            raise PowerCut
        try:
            return self._run(end, until)
        except PowerCut:
            self.has_lost_power = True
            raise
        except Stopped as stopped:
            block = self.processor.clock.block
            raise Stopped(f"{stopped} (at {self.time:.6f} s, {block:#010x}, {self.line(block)})") from None

    def _run(self, end: int, until: Callable[[], bool] | None) -> bool:
        processor, clock = self.processor, self.processor.clock
        self.end = end
        while clock.time < end:
            if until is not None and until():
                return True
            self._catch_up()
            if self.request:
                cause, self.request = self.request, None
                self.resets.append(cause)
                self._reset({cause, "pin"})
                self.end = end
                continue
            if processor.sleeps:
                if processor.waiting() is None:
                    clock.time = max(clock.time, min(self.due, end))
                    continue
                processor.sleeps = False
            processor.run(min(self.due, end))
        self.follow_plant()
        return until is not None and until()

    # The board

    def set_gates(self, a: str, b: str, c: str) -> None:
        if (a, b, c) != self.gates:
            self.follow_plant()
            self.gates = (a, b, c)
            self.plant.set_gates(a, b, c)

    def follow_plant(self) -> None:
        """Brings the motor up to the present."""
        now = self.now
        if now == self.followed:
            return
        plant = self.plant
        while (seconds := (now - self.plant_start) / SECOND - plant.time) > 1e-10:
            pending = self.power_timer.break_due
            if pending < now:
                seconds = (pending - self.plant_start) / SECOND - plant.time
            if seconds > 0:
                plant.advance(min(seconds, LONGEST), self.trip_limit)
                for time, code in plant.hall_edges:
                    self.board.hall(self, self.plant_start + round(time * SECOND), code)
                if self.trip_limit is not None:
                    self._compare(self.plant_start + round(plant.time * SECOND))
            if pending < now and plant.time >= (pending - self.plant_start) / SECOND - 1e-10:
                before, self._event = self._event, pending
                self.power_timer.break_now()
                self._event = before
        self.followed = now

    def _find_trip(self) -> None:
        self.trip = self.board.trip(self)
        active = [amperes for amperes in self.trip if amperes < NEVER]
        self.trip_limit = min(active) if active else None

    def set_trip(self) -> None:
        """What the comparators compare has changed."""
        self._find_trip()
        self.follow_plant()
        self._compare(self.now)

    def shunt_currents(self) -> list[float]:
        a, b, c = self.plant.shunts
        more = self.foreign_current
        return [a + more[0], b + more[1], c + more[2]]

    def _compare(self, time: int) -> None:
        """Comparators at `time`."""
        currents = self.shunt_currents()
        if (self.trip_limit is None or max(currents) < self.trip_limit) and not any(self.tripped):
            return
        tripped = [amperes >= limit for amperes, limit in zip(currents, self.trip, strict=True)]
        if tripped != self.tripped:
            self.tripped = tripped
            before, self._event = self._event, time + DELAY
            self.power_timer.comparator_changed()
            self._event = before

    def set_foreign_current(self, place: int, amperes: float) -> None:
        """A current beside the motor's begins or ends to flow through a shunt."""
        self.follow_plant()
        self.foreign_current[place] = amperes
        self._compare(self.now)

    def is_tripped(self, place: int) -> bool:
        return self.tripped[place]

    def trigger(self, name: str) -> None:
        for converter in self.converters:
            converter.trigger(name)

    def levels(self, letter: str) -> dict[int, int]:
        """What drives a port's pins from outside."""
        self.follow_plant()
        return self.board.levels(self, letter)

    def need_analog(self, port: str, pin: int) -> None:
        """A pin that a converter looks at."""
        if self.ports[port].mode(pin) != ANALOG:
            raise Stopped(f"P{port}{pin} is converted, but it is not analogue")


__all__ = ["Chip", "Image", "PowerCut"]
