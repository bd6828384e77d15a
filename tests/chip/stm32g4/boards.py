"""The boards that the model knows: what their chip has, and what is wired to it."""

from stm32g4.analog import Amplifiers, Comparators, Dac
from stm32g4.capture_timer import CaptureTimer
from stm32g4.counter import Counter
from stm32g4.gpio import ANALOG, LOW
from stm32g4.registers import NEVER, Peripheral, Stopped
from stm32g4.watchdog import LowPowerTimer

MHZ, KIB = 1_000_000, 1024
PULLED_UP = 1
SUPPLY = 3.3


class Board:
    """A chip and what is around it. Methods get the chip that they are asked for."""

    flash_size: int
    data: int
    """Offset in the flash of the records and parameters, where no program stands."""
    banks = 1
    """Banks of the flash. The processor waits for the bank that it executes from."""
    ram_size: int
    crystal: int
    """Hz."""
    can: tuple[str, int, int, int]
    """Controller: name, address, offset of its part of the message memory, number of its interrupt."""
    clocked: dict[str, tuple[str, int]]
    """Peripherals of this board's image alone that stand still without their clock: register and bit."""
    idle_clocks: dict[str, int] = {}
    """Clocks that the image turns on and does not need, by register."""
    resets: dict[str, int] = {}
    """Peripherals that the image resets before it uses them, by register."""
    outputs: dict[str, tuple[str, int, int]]
    """TIM1's outputs: port, pin, alternate function (the chip's data sheet)."""
    jumps_to_full_speed = False
    """The image goes above 80 MHz in one step: embassy-stm32 does, although the manual asks for two (section 7.2.7)."""
    low_sides_active_low = False
    """The gate drivers turn a low side on by a low level."""
    pwm_rate = 10_000
    parameters: dict[str, float]
    """Parameters that the board needs besides the motor's."""
    bus_divider: float
    terminal_divider = 2.2 / 12.2
    terminals: dict[tuple[int, int], tuple[int, str, int]]
    """Terminals by converter and channel: place, port, pin. Shunts likewise."""
    shunts: dict[tuple[int, int], tuple[int, str, int]]
    divider_pin: tuple[str, int]
    """Low, it connects the terminals' dividers."""

    def make(self, chip: object) -> list[Peripheral]:
        """Adds the peripherals of this board alone; returns those that have events."""
        raise NotImplementedError

    def trip(self, chip: object) -> list[float]:
        """Currents of the shunts from which on a comparator has tripped, A."""
        raise NotImplementedError

    def breaks(self, chip: object, sources: int) -> bool:
        """Level of TIM1's break input, of the sources that AF1 names."""
        raise NotImplementedError

    def hall(self, chip: object, time: int, code: int) -> None:
        """The hall lines have changed at `time`."""

    def levels(self, chip: object, letter: str) -> dict[int, int]:
        """What drives a port's pins from outside."""
        raise NotImplementedError

    def can_is_on(self, chip: object) -> bool:
        """The transceiver is on, and connected to the controller's pins."""
        raise NotImplementedError

    def shunt(self, chip: object, place: int) -> float:
        """Voltage of a shunt at its converter's pin."""
        raise NotImplementedError

    def other_channel(self, chip: object, name: tuple[int, int]) -> float | None:
        """Voltage of a channel that is no shunt and no terminal; None if the board does not use it."""
        raise NotImplementedError

    def channel(self, chip: object, converter: int, channel: int) -> float:
        """Voltage of a converter's channel."""
        name = (converter, channel)
        if name in self.shunts:
            place, port, pin = self.shunts[name]
            chip.need_analog(port, pin)
            return min(max(self.shunt(chip, place), 0.0), SUPPLY)
        if name in self.terminals:
            place, port, pin = self.terminals[name]
            chip.need_analog(port, pin)
            port, pin = self.divider_pin
            divided = chip.ports[port].output(pin) == LOW
            return max(chip.plant.terminals[place], 0.0) * (self.terminal_divider if divided else 1.0)
        volts = self.other_channel(chip, name)
        if volts is None:
            raise Stopped(f"ADC{converter} converts channel {channel}, which the board does not use")
        return volts


class Esc(Board):
    """ST's B-G431B-ESC1 with its STM32G431CB (docs/B-G431B-ESC1.md)."""

    flash_size, data, ram_size = 128 * KIB, 118 * KIB, 32 * KIB
    crystal = 8 * MHZ
    can = ("FDCAN1", 0x4000_6400, 0, 21)
    clocked = {"TIM4": ("APB1ENR1", 2), "LPTIM1": ("APB1ENR1", 31), "DAC3": ("AHB2ENR", 18)}
    outputs = {
        "A high": ("A", 8, 6),
        "A low": ("C", 13, 4),
        "B high": ("A", 9, 6),
        "B low": ("A", 12, 6),
        "C high": ("A", 10, 6),
        "C low": ("B", 15, 4),
    }
    # See docs/B-G431B-ESC1.md, section Parameters.
    parameters = {"Over-voltage HV threshold": 27.0, "Minimum on-time": 6000}
    bus_divider = 18 / 187
    terminals = {(2, 17): (0, "A", 4), (2, 5): (1, "C", 4), (2, 14): (2, "B", 11)}
    shunts = {(1, 3): (0, "A", 2), (2, 3): (1, "A", 6), (1, 12): (2, "B", 1)}
    divider_pin = ("B", 5)
    shunt_bias, shunt_scale = 0.128563, 0.001713
    """Voltage at a shunt's network: V without current, and V an ampere."""
    thermistor, reference = 1.055, 1.3342
    """Thermistor at 25 degrees Celsius; internal reference, V, as the maker's word has it."""

    def make(self, chip: object) -> list[Peripheral]:
        chip.low_power_timer = LowPowerTimer(chip)
        chip.dac = Dac(chip)
        chip.comparators = Comparators(chip)
        chip.amplifiers = Amplifiers(chip)
        chip.capture_timer = CaptureTimer(chip)
        chip.capture_timer.level = chip.plant.hall
        return [chip.capture_timer]

    def trip(self, chip: object) -> list[float]:
        thresholds = [chip.comparators.threshold(place) for place in range(3)]
        return [NEVER if volts is None else (volts - self.shunt_bias) / self.shunt_scale for volts in thresholds]

    def breaks(self, chip: object, sources: int) -> bool:
        # Comparators 1, 2 and 4 (section 28.6.26).
        return any(sources >> bit & 1 and chip.is_tripped(place) for place, bit in enumerate((1, 2, 4)))

    def hall(self, chip: object, time: int, code: int) -> None:
        chip.capture_timer.hall(time, code)

    def levels(self, chip: object, letter: str) -> dict[int, int]:
        match letter:
            case "A":
                return {15: int(chip.pwm_input), 11: PULLED_UP, 13: 1, 14: 0}
            case "B":
                hall = chip.plant.hall
                return {6: hall & 1, 7: hall >> 1 & 1, 8: hall >> 2 & 1}
            case _:
                return {10: 0 if chip.button_pressed else PULLED_UP}

    def can_is_on(self, chip: object) -> bool:
        a, b = chip.ports["A"], chip.ports["B"]
        return a.function(11) == 9 and b.function(9) == 9 and chip.ports["C"].output(11) == LOW

    def shunt(self, chip: object, place: int) -> float:
        return chip.amplifiers.output(place, self.shunt_bias + self.shunt_scale * chip.shunt_currents()[place])

    def other_channel(self, chip: object, name: tuple[int, int]) -> float | None:
        match name:
            case (1, 1):
                chip.need_analog("A", 0)
                return chip.plant.bus_voltage * self.bus_divider
            case (1, 5):
                chip.need_analog("B", 14)
                return self.thermistor
            case (1, 11):
                chip.need_analog("B", 12)
                return chip.potentiometer
            case (1, 18):
                if not chip.converters_common.registers["CCR"].value >> 22 & 1:
                    raise Stopped("ADC1 converts the internal reference, which is off")
                return self.reference * 3.0 / SUPPLY
        return None


class Nucleo(Board):
    """ST's NUCLEO-G474RE with the power board X-NUCLEO-IHM08M1 (examples/embassy-stm32): NuttX and SimpleFOC
    projects turn motors with that power board. The schematic's figures are those of NuttX:
    10 milliohm, a gain of 5.18, 169 kohm over 9.31 kohm; comparators at 30 A on the break input.
    """

    flash_size, data, ram_size = 512 * KIB, 504 * KIB, 128 * KIB
    banks = 2
    crystal = 24 * MHZ
    can = ("FDCAN2", 0x4000_6800, 0x350, 86)
    clocked = {"TIM2": ("APB1ENR1", 0), "TIM5": ("APB1ENR1", 3)}
    # Controllers of direct memory access, ports D to G, clock recovery.
    idle_clocks = {"AHB1ENR": 0x7, "AHB2ENR": 0x78, "APB1ENR1": 0x100}
    resets = {"AHB1RSTR": 0x107, "AHB2RSTR": 0x7F, "APB1RSTR1": 0x1200_0009, "APB2RSTR": 0x1}
    outputs = {
        "A high": ("A", 8, 6),
        "A low": ("A", 7, 6),
        "B high": ("A", 9, 6),
        "B low": ("B", 0, 6),
        "C high": ("A", 10, 6),
        "C low": ("B", 1, 6),
    }
    jumps_to_full_speed = True
    low_sides_active_low = True
    pwm_rate = 20_000
    # 48 V at most; twice the time from the middle of a pulse to the last conversion's end.
    parameters = {"Over-voltage HV threshold": 45.0, "Minimum on-time": 6000}
    bus_divider = 9.31 / 178.31
    terminals = {(2, 9): (0, "C", 3), (2, 5): (1, "C", 4), (2, 11): (2, "C", 5)}
    shunts = {(1, 1): (0, "A", 0), (2, 7): (1, "C", 1), (1, 6): (2, "C", 0)}
    divider_pin = ("C", 9)
    shunt_bias, shunt_scale = 1.71, 0.0518
    """Voltage behind a shunt's amplifier: V without current, and V an ampere."""
    trip_current = 30.0
    thermistor = 1.055

    def make(self, chip: object) -> list[Peripheral]:
        # TIM2 is the clock of the period, TIM5 that of embassy's tasks.
        chip.counters = [Counter(chip, "TIM2", 0x4000_0000, 28), Counter(chip, "TIM5", 0x4000_0C00, 50)]
        return chip.counters

    def trip(self, chip: object) -> list[float]:
        return [self.trip_current] * 3

    def breaks(self, chip: object, sources: int) -> bool:
        # The comparators pull the input down; without its function it reads low.
        is_connected = chip.ports["A"].function(6) == 6
        return bool(sources & 1) and is_connected and not any(chip.is_tripped(place) for place in range(3))

    def levels(self, chip: object, letter: str) -> dict[int, int]:
        hall = chip.plant.hall
        match letter:
            case "A":
                return {15: hall & 1, 13: 1, 14: 0}
            case "B":
                return {3: hall >> 1 & 1, 10: hall >> 2 & 1, 12: PULLED_UP}
            case _:
                return {}

    def can_is_on(self, chip: object) -> bool:
        b = chip.ports["B"]
        return b.function(12) == 9 and b.function(13) == 9

    def shunt(self, chip: object, place: int) -> float:
        return self.shunt_bias + self.shunt_scale * chip.shunt_currents()[place]

    def other_channel(self, chip: object, name: tuple[int, int]) -> float | None:
        match name:
            case (1, 2):
                chip.need_analog("A", 1)
                return chip.plant.bus_voltage * self.bus_divider
            case (1, 8):
                chip.need_analog("C", 2)
                return self.thermistor
        return None


B_G431B_ESC1, NUCLEO_G474RE = Esc(), Nucleo()
