"""Fixtures that several test modules share."""

import pytest


@pytest.fixture
def master():
    """A function that powers up a virtual drive and connects to its bus.

    `master("2,3:dual")` adds these TX-Drivers. The drive runs at ten times real time, if the machine is fast
    enough.
    """
    # Imported here: tests without a drive do not need these modules.
    from tx_driver import Master
    from virtual_drive import Drive

    drives, masters = [], []

    def power_up(tx_drivers, speed="10"):
        drives.append(Drive("--tx-drivers", tx_drivers, "--speed", speed))
        masters.append(Master(drives[-1]))
        masters[-1].drive = drives[-1]
        # The first broadcast of the drive ends its power-up.
        masters[-1].settle()
        return masters[-1]

    yield power_up
    for master in masters:
        master.close()
    for drive in drives:
        assert drive.end() == 0
