"""A second board: NUCLEO-G474RE with X-NUCLEO-IHM08M1, and the images of examples/embassy-stm32 and examples/rtic."""

import os
import pathlib

import pytest
from conftest import OFF, SPEED, Bench, stored
from faults import both, field, reads, swapped, verdict, watch_symmetry, without, writes
from narx import Load, State
from stm32g4 import SECOND
from stm32g4.boards import NUCLEO_G474RE
from stm32g4.chip import Image
from stm32g4.flash import PowerCut

IMAGES = pathlib.Path(os.environ["NARX_EXAMPLES"])


def set_up(example, mode):
    """A board that is set up for the motor, in Standby."""
    image = Image(IMAGES / f"{example}-drive")
    bench = Bench(image, stored(image, mode, NUCLEO_G474RE), board=NUCLEO_G474RE)
    bench.stand_by()
    return bench


def trip(bench):
    """32 A through a shunt: whether the gates are off within 0.2 us, while the processor does nothing."""
    chip = bench.chip
    instructions = chip.processor.clock.instructions
    chip.set_foreign_current(1, NUCLEO_G474RE.trip_current + 2.0)
    chip.processor.clock.time += round(0.2e-6 * SECOND)
    chip.follow_plant()
    return chip.gates == OFF and chip.processor.clock.instructions == instructions


@pytest.mark.parametrize(("example", "mode"), [("embassy-stm32", "hall"), ("embassy-stm32", "sensorless"), ("rtic", "hall")])
def test_the_motor_starts_holds_its_speed_under_load_stops_and_reverses(example, mode):
    bench = set_up(example, mode)
    bench.spin(mode)
    print(f"{example}, {mode}: {bench.chip.processor.longest}")


@pytest.fixture(scope="module")
def standing():
    return set_up("embassy-stm32", "hall")


def test_over_current_turns_the_gates_off_without_the_processor_and_the_motor_starts_again(standing):
    bench, chip = standing, standing.chip
    bench.drive.start(SPEED)
    bench.run(0.2)
    assert trip(bench)
    assert bench.wait(lambda: bench.drive.state is State.FAULT, 0.2)
    assert "emergency_shutdown" in bench.drive.faults
    chip.set_foreign_current(1, 0.0)
    assert bench.wait(lambda: abs(bench.plant.speed) < 50, 3.0)
    bench.drive.stop()
    bench.reach(State.STANDBY)
    assert bench.turns_at(SPEED)
    bench.drive.stop()
    bench.reach(State.STANDBY)
    assert bench.wait(lambda: abs(bench.plant.speed) < 50, 3.0)


def test_power_that_fails_while_it_stores_leaves_the_former_parameters(standing):
    bench, name = standing, "Over-temperature warning threshold"
    before = bench.drive.parameters[name]
    bench.drive.parameters[name] = before - 10
    bench.chip.flash.cut_at = bench.chip.flash.operations + 1
    with pytest.raises(PowerCut):
        bench.drive.parameters.store()
    again = Bench(bench.chip.image, bytes(bench.chip.processor.flash), board=NUCLEO_G474RE)
    again.chip.flash.torn = bench.chip.flash.torn
    again.stand_by()
    assert again.drive.parameters[name] == before


def test_control_ticks_that_end_are_a_reset_with_the_gates_off():
    bench = set_up("embassy-stm32", "hall")
    bench.drive.start(SPEED)
    bench.run(0.2)
    bench.chip.find("TIM1.CR2").value = 0
    bench.chip.run(0.2)
    assert bench.chip.resets == ["watchdog"] and bench.chip.gates == OFF


FAULTS = {
    "clock above what the voltage allows": writes("RCC.PLLCFGR", field(8, 7, 85)),
    "dead time 0": writes("TIM1.BDTR", field(0, 8, 0)),
    "low sides active high": writes("TIM1.CCER", without(3, 7, 11)),
    "transmit buffers as a queue": writes("FDCAN2.TXBC", field(24, 1, 1)),
    "filter rejects extended frames": writes("FDCAN2.RXGFC", field(2, 2, 2)),
    "shunts A and C swapped": writes("ADC1.JSQR", swapped(15, 21, 5)),
    "phases A and B swapped": both(writes("TIM1.CCMR1", swapped(0, 8, 8)), writes("TIM1.CCER", swapped(0, 4, 4))),
    "hall line A read twice": reads("GPIOB.IDR", lambda value: value | 1 << 3),
    "update at both ends": writes("TIM1.RCR", field(0, 8, 0)),
    "break disabled": writes("TIM1.BDTR", without(12)),
    "break of the wrong polarity": writes("TIM1.BDTR", field(13, 1, 1)),
    "no source of the break": writes("TIM1.AF1", without(0)),
    "words programmed without PG": writes("FLASH.CR", without(0)),
}
FEW = ["low sides active high", "transmit buffers as a queue", "no source of the break", "words programmed without PG"]


@pytest.fixture(scope="module")
def flash():
    return stored(Image(IMAGES / "embassy-stm32-drive"), "hall", NUCLEO_G474RE)


def examine(flash, mutation=None):
    """Powers the board up, stores, turns the motor and trips; returns what is wrong, or None."""
    return verdict(lambda: _examine(Bench(Image(IMAGES / "embassy-stm32-drive"), flash, mutation=mutation, board=NUCLEO_G474RE)))


def _examine(bench):
    drive = bench.drive
    bench.stand_by()
    drive.parameters["Over-temperature warning threshold"] = 80
    drive.parameters.store()
    differences = watch_symmetry(bench.chip)
    if not bench.turns_at(SPEED):
        return f"{bench.mean_speed():.0f} rpm instead of {SPEED}"
    if drive.faults or bench.chip.resets:
        return f"faults {drive.faults}, resets {bench.chip.resets}"
    if differences:
        return f"the duty changes inside a period, {len(differences)} times"
    bench.plant.set_load(Load(constant=0.08))
    bench.run(0.2)
    flows, shown = bench.bus_currents(0.1)
    if not flows < shown < 1.1 * flows:
        return f"a bus current of {shown:.2f} A instead of {flows:.2f}"
    return None if trip(bench) else "32 A through shunt B do not turn the gates off"


def test_nothing_is_wrong_with_the_image_as_it_is(flash):
    assert examine(flash) is None


@pytest.mark.parametrize("name", FAULTS if os.environ.get("NARX_LONG") == "1" else FEW)
def test_a_fault_is_seen(flash, name):
    found = examine(flash, FAULTS[name])
    assert found is not None
    print(f"{name}: {found}")
