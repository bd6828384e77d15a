"""TX-Drivers on the drive's bus, read by python-canopen with the committed EDS."""

from pathlib import Path
from typing import Any

import can
import canopen
import pytest

import narx

EDS = str(Path(__file__).parents[2] / "docs" / "eddycan-single.eds")
OPTIONS: dict[str, Any] = {"motor": "ec45-flat-50w-18v", "supply_voltage": 18.0, "mode": "hall"}


def test_a_sensor_is_read_beside_a_turning_motor() -> None:
    with can.Bus(interface="narx", channel="sensors", tx_drivers=[2], **OPTIONS) as bus:
        network = canopen.Network(bus)
        network.connect()
        try:
            node = network.add_node(2, EDS)
            assert node.sdo["Node-ID"].raw == 2
            with narx.Drive(bus) as drive:
                drive.start(2000)
                seen: list[int] = []
                node.tpdo.read(from_od=True)  # type: ignore[no-untyped-call]
                node.nmt.state = "OPERATIONAL"
                node.tpdo[2].add_callback(lambda message: seen.append(message[0].raw))
                for _ in range(40):
                    network.sync.transmit()
                    drive.wait(0.01)
                assert drive.state is narx.State.HALL_CLOSED_LOOP
        finally:
            # The network does not own the bus, so it must not shut it down.
            network.bus = None
            network.disconnect()
    # The surface runs out by some 20 um; the sensor is 1 mm away, the middle of its range of 2 mm.
    assert len(seen) >= 30
    positions = [raw / 2**27 for raw in seen]
    assert all(0.95 < position < 1.05 for position in positions) and max(positions) - min(positions) > 0.02


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"node_id": 0}, "node_id 0: must be a whole number from 1 to 127"),
        ({"node_id": 128}, "node_id 128: must be a whole number from 1 to 127"),
        ({"node_id": 2}, "node_id 2: there is a TX-Driver of this node-id already"),
        ({"node_id": 3, "channels": 3}, "channels 3: must be 1 or 2"),
        ({"node_id": 3, "encoder": 0}, "encoder 0: must be a whole number from 1 to 65535"),
        ({"node_id": 3, "measuring_range": 20.0}, "measuring range 20 mm: must be from 0.01 to 15.9 mm"),
    ],
)
def test_what_cannot_be_added(bench: narx.Bench, arguments: dict[str, Any], message: str) -> None:
    bench.add_tx_driver(2, channels=2, encoder=1024)
    with pytest.raises(narx.ParameterError, match=message):
        bench.add_tx_driver(**arguments)
    bench.drive.start(1000)
    assert bench.drive.state is narx.State.HALL_CLOSED_LOOP
