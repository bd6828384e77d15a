"""Power-up, self-tests, resets, and what stops the model."""

import can
import pytest
from conftest import Bench, forked
from narx import State
from stm32g4 import SECOND, Stopped
from stm32g4.power_timer import OC6REF

RESET_CAUSE, FAILED_SELF_TESTS = 302, 303
POWER_UP, REQUESTED, WATCHDOG = 1, 3, 4
MARGIN = 512
"""Stack that is left at least, bytes."""


def test_a_blank_board_boots_tests_itself_and_waits_for_parameters(image):
    bench = Bench(image)
    assert bench.wait(lambda: bench.drive.state is State.FAULT, 1.0)
    assert bench.drive.faults == {"store_mismatch"}
    assert bench.chip.clocks.rate == 170e6
    assert bench.drive.parameters[FAILED_SELF_TESTS] == 0
    led = set()
    for _ in range(12):
        bench.run(0.1)
        led.add(bench.chip.ports["C"].output(6))
    assert led == {0, 1} and bench.chip.resets == []
    assert bench.drive.measurements["HV Voltage"] == pytest.approx(24.0, rel=0.01)
    assert bench.drive.measurements["HV Current"] == pytest.approx(0.0, abs=0.05)
    assert bench.chip.processor.clock.lowest - image.stack_end >= MARGIN


@forked
def test_a_reboot_is_reported_as_requested(standing):
    assert standing.drive.parameters[RESET_CAUSE] == POWER_UP
    standing.drive.reboot()
    assert standing.chip.resets == ["software"]
    assert standing.drive.parameters[RESET_CAUSE] == REQUESTED


@forked
def test_the_watchdog_resets_a_drive_whose_control_ticks_end(turning):
    chip = turning.chip
    triggers = chip.find("TIM1.CR2")
    assert triggers.value >> 20 == OC6REF
    triggers.value = 0
    chip.run(0.09)
    assert chip.resets == [], "not before its time"
    chip.run(0.03)
    assert chip.resets == ["watchdog"] and chip.gates == ("off", "off", "off")
    assert turning.wait(lambda: turning.drive.state is State.STANDBY, 1.5)
    assert turning.drive.parameters[RESET_CAUSE] == WATCHDOG
    turning.run(0.3)
    assert turning.drive.state is State.STANDBY, "nothing starts by itself"


@forked
def test_frames_of_other_nodes_and_remote_frames_do_no_harm(standing):
    chip, bus = standing.chip, standing.bus
    for identifier in (0x000, 0x7FF, 0x123):
        bus.send(can.Message(arbitration_id=identifier, is_extended_id=False, data=b"12345678"))
        bus.send(can.Message(arbitration_id=identifier, is_extended_id=True, is_remote_frame=True, dlc=8))
    standing.run(0.1)
    assert chip.resets == [] and standing.drive.state is State.STANDBY


def wrong(name, change):
    def mutation(chip):
        chip.find(name).wrong_write = change

    return mutation


@pytest.mark.parametrize(
    ("mutation", "message"),
    [
        (wrong("RCC.APB2ENR", lambda value: value & ~(1 << 11)), r"TIM1 has no clock .*power_stage\.rs"),
        (wrong("TIM1.CR1", lambda value: value | 1 << 12), r"TIM1\.CR1: writes 0x000010a1, of which the model knows 0x000000e1"),
        (lambda chip: chip.map.pop(0x4001_2C60), r"writes 4 bytes at 0x40012c60, which the model does not know .*power_stage\.rs"),
    ],
)
def test_an_access_that_the_chip_does_not_have_stops_the_run_with_its_line(image, mutation, message):
    bench = Bench(image, mutation=mutation)
    with pytest.raises(Stopped, match=message):
        bench.chip.run(0.15)


def test_bits_of_a_frame_on_the_bus(image):
    bench = Bench(image)
    assert bench.wait(lambda: bench.drive.state is not None, 1.0)
    chip = bench.chip
    first = None
    while first is None:
        chip.run(0.001)
        if chip.bus.on is not None:
            first = chip.bus.on[1]
    # 67 bits of an extended frame's frame without stuffing, and its data.
    least = 67 + 8 * len(first.data)
    assert least <= first.bits() <= least + (54 + 8 * len(first.data)) // 4
    assert chip.bus.bit == 2 * SECOND // 1_000_000
