"""What several tests begin with."""

import pytest


@pytest.fixture
def master():
    """`master("2,3:dual")` powers up a virtual drive with these TX-Drivers, ten times as fast as the clock if the machine can, and connects to its bus."""
    # Here, because tests that need no drive need none of this either.
    from tx_driver import Master
    from virtual_drive import Drive

    drives, masters = [], []

    def power_up(tx_drivers, speed="10"):
        drives.append(Drive("--tx-drivers", tx_drivers, "--speed", speed))
        masters.append(Master(drives[-1]))
        masters[-1].drive = drives[-1]
        # Power-up is over when the drive broadcasts.
        masters[-1].settle()
        return masters[-1]

    yield power_up
    for master in masters:
        master.close()
    for drive in drives:
        assert drive.end() == 0
