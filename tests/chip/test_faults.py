"""Each deliberate fault of the drivers is seen by the examination, which finds nothing in the image as it is.

With NARX_LONG=1 all faults; without, of those that a motor must turn for, a few.
"""

import multiprocessing
import os

import pytest
from faults import AT_REST, FAULTS, SENSORLESS, TURNING, examine

AS_IT_IS = ("hall", "sensorless")
FEW = ["phases A and B swapped", "duty without preload", "comparator 2 does not break", "shunts A and C swapped"]
TRIED = [*AT_REST, *(TURNING if os.environ.get("NARX_LONG") == "1" else FEW)]


@pytest.fixture(scope="session")
def verdicts(image, hall_flash, sensorless_flash):
    """What the examination finds, by fault; on every processor core."""
    global work

    def work(name):
        sensorless = name in SENSORLESS or name == "sensorless"
        return name, examine(image, sensorless_flash if sensorless else hall_flash, FAULTS.get(name), sensorless)

    with multiprocessing.get_context("fork").Pool(os.cpu_count()) as pool:
        found = dict(pool.imap_unordered(call, [*AS_IT_IS, *TRIED]))
    for name, verdict in sorted(found.items()):
        print(f"{name}: {verdict}")
    return found


def call(name):
    return work(name)


@pytest.mark.parametrize("mode", AS_IT_IS)
def test_nothing_is_wrong_with_the_image_as_it_is(verdicts, mode):
    assert verdicts[mode] is None


@pytest.mark.parametrize("name", TRIED)
def test_a_fault_is_seen(verdicts, name):
    assert verdicts[name] is not None
