"""Deliberate faults of the drivers, and the examination that must see each of them.

A fault changes what a driver writes to a register, or reads from it, as a driver with that mistake would.
"""

import narx
from conftest import OFF, Bench
from stm32g4 import SECOND, Stopped

RESET_CAUSE, POWER_UP = 302, 1
SPEED = 1500


def writes(name, change):
    """The driver writes something else to this register."""

    def mutation(chip):
        chip.find(name).wrong_write = change

    return mutation


def reads(name, change):
    """The driver reads something else from this register."""

    def mutation(chip):
        chip.find(name).wrong_read = change

    return mutation


def both(*mutations):
    def mutation(chip):
        for one in mutations:
            one(chip)

    return mutation


def without(*bits):
    mask = ~sum(1 << bit for bit in bits)
    return lambda value: value & mask


def field(shift, width, new):
    mask = ((1 << width) - 1) << shift
    return lambda value: value & ~mask | new << shift


def swapped(shift, other, width):
    def change(value):
        mask = (1 << width) - 1
        a, b = value >> shift & mask, value >> other & mask
        return value & ~(mask << shift) & ~(mask << other) | b << shift | a << other

    return change


def exchanged(old, new):
    return lambda value: new if value == old else value


AT_REST = {
    "PLL multiplies by 84": writes("RCC.PLLCFGR", field(8, 7, 84)),
    "processor runs at 85 MHz": writes("RCC.CFGR", field(4, 4, 8)),
    "no intermediate step of the clock": writes("RCC.CFGR", field(4, 4, 0)),
    "one wait state too few": writes("FLASH.ACR", field(0, 4, 3)),
    "voltage range without boost": writes("PWR.CR5", field(8, 1, 1)),
    "CAN clocked by the bus": writes("RCC.CCIPR", field(24, 2, 2)),
    "TIM4 without clock": writes("RCC.APB1ENR1", without(2)),
    "shunt output A not analogue": writes("GPIOA.MODER", field(4, 2, 0)),
    "CAN transceiver off": writes("GPIOC.ODR", field(11, 1, 1)),
    "dead time 0": writes("TIM1.BDTR", field(0, 8, 0)),
    "dead time by half": writes("TIM1.BDTR", field(0, 8, 66)),
    "trigger from another channel": writes("TIM1.CR2", field(20, 4, 8)),
    "break of the wrong polarity": writes("TIM1.BDTR", without(13)),
    "outputs that float when off": writes("TIM1.BDTR", without(11)),
    "trigger of the sequence": writes("ADC1.JSQR", field(2, 5, 9)),
    "thermistor and potentiometer swapped": writes("ADC1.SQR1", exchanged(5 << 6, 11 << 6)),
    "converter clocked too fast": writes("ADC12.CCR", field(16, 2, 1)),
    "reference off": writes("ADC12.CCR", without(22)),
    "no calibration": writes("ADC1.CR", without(31)),
    "no interrupt of the converter": writes("ADC1.IER", lambda value: 0),
    "amplifiers' gain 8": both(*(writes(f"OPAMP.OPAMP{place}_CSR", field(14, 3, 2)) for place in (1, 2, 3))),
    "amplifier 2 off": writes("OPAMP.OPAMP2_CSR", without(0)),
    "DAC's timing": writes("DAC3.MCR", field(14, 2, 0)),
    "bits of 1 us": writes("FDCAN1.NBTP", field(8, 8, 5)),
    "filter rejects extended frames": writes("FDCAN1.RXGFC", field(2, 2, 2)),
    "no interrupt of FIFO 0": writes("FDCAN1.IE", without(0)),
    "transmit buffers as a queue": writes("FDCAN1.TXBC", field(24, 1, 1)),
    "acknowledges the next element": writes("FDCAN1.RXF0A", lambda value: (value + 1) % 3),
    "interrupt of the bus not enabled": writes("SCS.ISER0", without(21)),
    "watchdog's registers without their key": writes("IWDG.KR", exchanged(0x5555, 0)),
    "low-power timer from the bus clock": writes("RCC.CCIPR", field(18, 2, 0)),
    "words programmed without PG": writes("FLASH.CR", without(0)),
    "wrong key of the flash": writes("FLASH.KEYR", exchanged(0xCDEF_89AB, 0xCDEF_89AA)),
}
"""Faults that are seen before the motor turns."""
TURNING = {
    "alternate function of phase A's low side": writes("GPIOC.AFRH", field(20, 4, 6)),
    "hall line B analogue": writes("GPIOB.MODER", field(14, 2, 3)),
    "phases A and B swapped": both(writes("TIM1.CCMR1", swapped(0, 8, 8)), writes("TIM1.CCER", swapped(0, 4, 4))),
    "dead time doubled": writes("TIM1.BDTR", field(0, 8, 0xC2)),
    "duty without preload": both(writes("TIM1.CCMR1", without(3, 11)), writes("TIM1.CCMR2", without(3))),
    "update at both ends": writes("TIM1.RCR", field(0, 8, 0)),
    "break disabled": writes("TIM1.BDTR", without(12)),
    "slowest filter of the break": writes("TIM1.BDTR", field(16, 4, 15)),
    "comparator 2 does not break": writes("TIM1.AF1", without(2)),
    "outputs never on": writes("TIM1.BDTR", without(15)),
    "only rising edges captured": writes("TIM4.CCER", without(1, 5, 9)),
    "captures of lines A and B swapped": both(reads("TIM4.SR", swapped(1, 2, 1))),
    "no captures": writes("TIM4.CCER", lambda value: 0),
    "no interrupt at a commutation": writes("TIM4.DIER", lambda value: 0),
    "shunts A and C swapped": writes("ADC1.JSQR", swapped(15, 21, 5)),
    "terminals A and B swapped": writes("ADC2.JSQR", swapped(15, 21, 5)),
    "threshold of the comparators doubled": both(*(writes(f"DAC3.DHR12R{place}", lambda value: 2 * value) for place in (1, 2))),
    "comparator 1 against another reference": writes("COMP.C1CSR", field(4, 3, 3)),
    "comparator 4 off": writes("COMP.C4CSR", without(0)),
    "watchdog never started": writes("IWDG.KR", exchanged(0xCCCC, 0)),
    "watchdog of 2 s": writes("IWDG.RLR", lambda value: 0xFFF),
}
"""Faults that a motor must turn for."""
FAULTS = AT_REST | TURNING
SENSORLESS = {"terminals A and B swapped"}


STANDING = [
    # Measurement at rest, its value, and tolerance.
    ("HV Voltage", 24.0, 0.24),
    ("HV Current", 0.0, 0.05),
    ("Ambient Temperature", 25.0, 3.0),
    ("ASI_DSP", 2.0, 0.01),
    ("+0.383VREF", 0.383 * 3.3, 0.01),
]


class Edges:
    """Edges of the gates, as the motor gets them."""

    def __init__(self, chip):
        self.chip, self.falls, self.rises, self.dead = chip, [], [], []
        self.last = [0, 0, 0]
        chip.set_gates, self._set = self._note, chip.set_gates

    def _note(self, *gates):
        chip = self.chip
        for place, (before, after) in enumerate(zip(chip.gates, gates, strict=True)):
            if before == after:
                continue
            if after == "off":
                self.last[place] = chip.now
            elif before == "off" and self.last[place] and chip.now - self.last[place] < 2 * SECOND // 1_000_000:
                self.dead.append((chip.now - self.last[place]) / SECOND)
        self._set(*gates)


def watch_symmetry(chip):
    """Counts on which the two halves of a period's on-time differ, by leg, as long as the pattern stays."""
    differences = []
    timer = chip.power_timer
    update = timer._overflow

    def noted():
        compare = dict(timer.shadow)
        update()
        if timer.half and {1, 2, 3} & {channel for channel in (1, 2, 3) if timer.shadow[channel] != compare[channel]}:
            differences.append(chip.now)

    timer._overflow = noted
    direct = timer._compare

    def written(channel, value):
        before = timer.shadow[channel]
        direct(channel, value)
        if channel != 6 and timer.shadow[channel] != before:
            differences.append(chip.now)

    for channel in (1, 2, 3):
        chip.find(f"TIM1.CCR{channel}")._write = lambda value, channel=channel: written(channel, value)
    return differences


def examine(image, flash, mutation=None, sensorless=False):
    """Powers a board up and tries everything; returns what is wrong, or None."""
    return verdict(lambda: _examine(Bench(image, flash, mutation=mutation), sensorless))


def verdict(examination):
    """Calls an examination; returns what it finds wrong, or what has stopped it."""
    try:
        return examination()
    except Stopped as stopped:
        return str(stopped)
    except (narx.NarxError, AssertionError) as error:
        return f"{type(error).__name__}: {error}"


def _examine(bench, sensorless):
    chip, drive = bench.chip, bench.drive
    if not bench.wait(lambda: drive.state is not None, 0.4):
        return f"the drive is silent (resets: {chip.resets})"
    drive.stop()
    bench.run(0.12)
    if chip.resets:
        return f"it was reset by {chip.resets}"
    if chip.fdcan.taken == 0:
        return "the drive takes no frames"
    if (cause := drive.parameters[RESET_CAUSE]) != POWER_UP:
        return f"reason of the start: {cause}"
    period = 2 * chip.power_timer.reload * chip.power_timer.unit / SECOND
    if abs(period / 100e-6 - 1) > 1e-3:
        return f"a period of {period * 1e6:.2f} us"
    bench.stand_by()
    for name, value, tolerance in STANDING:
        if abs((seen := drive.measurements[name]) - value) > tolerance:
            return f"{name}: {seen:g} instead of {value:g}"
    drive.parameters["Winding resistance"] = drive.parameters["Winding resistance"] + 0.01
    drive.parameters.store()

    differences = watch_symmetry(chip)
    edges = Edges(chip)
    drive.start(SPEED)
    bench.run(0.4 if sensorless else 0.28)
    speed = bench.mean_speed(0.04)
    if abs(speed / SPEED - 1) > 5e-3:
        return f"{speed:.0f} rpm instead of {SPEED}"
    if chip.resets or drive.faults:
        return f"resets {chip.resets}, faults {drive.faults}"
    captures = chip.capture_timer
    if not sensorless and captures.taken < 0.95 * captures.edges:
        return f"{captures.taken} captures of {captures.edges} edges"
    if differences:
        return f"the duty changes inside a period, {len(differences)} times"
    dead = sorted(edges.dead)[len(edges.dead) // 2] if edges.dead else 0.0
    if abs(dead / 800e-9 - 1) > 0.02:
        return f"a dead time of {dead * 1e9:.0f} ns"
    if 16 + 30 not in chip.processor.longest:
        return "no commutation inside a period"
    if sensorless:
        return None
    bench.plant.set_load(narx.Load(constant=0.15))
    bench.run(0.15)
    time, charge = bench.plant.time, bench.plant.charge
    bench.run(0.05)
    current = (bench.plant.charge - charge) / (bench.plant.time - time)
    # A sample in the on-time does not show the current that returns to the bus in the off-time.
    if not 0.97 * current < drive.measurements["HV Current"] < 1.1 * current:
        return f"a bus current of {drive.measurements['HV Current']:.2f} A instead of {current:.2f}"
    return _protect(bench)


def _protect(bench):
    chip = bench.chip
    for place in (0, 1, 2):
        was = (list(chip.tripped), chip.power_timer.registers["BDTR"].value, chip.power_timer.status)
        chip.set_foreign_current(place, 27.0)
        chip.processor.clock.time += round(0.2e-6 * SECOND)
        chip.follow_plant()
        if chip.gates != OFF:
            return f"27 A through shunt {'ABC'[place]} do not turn the gates off within 0.2 us"
        chip.set_foreign_current(place, 0.0)
        chip.power_timer.registers["BDTR"].value, chip.power_timer.status = was[1:]
        chip.power_timer._drive()
    chip.find("TIM1.CR2").value = 0
    chip.run(0.13)
    if chip.resets != ["watchdog"]:
        return "no reset by the watchdog although the control ticks have ended"
    return None


__all__ = ["AT_REST", "FAULTS", "SENSORLESS", "TURNING", "both", "examine", "field", "reads", "swapped", "verdict", "watch_symmetry", "without", "writes"]
