"""`narx.TxDriver` behaves alike on a bench, on a bus in simulated time, and on a bus in real time."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import can
import canopen
import numpy as np
import pytest

import narx
from narx import link

BUS: dict[str, Any] = {"interface": "narx", "motor": "ec45-flat-50w-18v", "supply_voltage": 18.0, "mode": "hall"}
EDS = str(Path(__file__).parents[2] / "docs" / "eddycan-single.eds")


@pytest.fixture(params=["bench", "stepped", "realtime"])
def tx(request: pytest.FixtureRequest, bench: narx.Bench) -> Iterator[narx.TxDriver]:
    """A node with one channel and an encoder on the shaft, which stands."""
    if request.param == "bench":
        bench.add_tx_driver(2, encoder=4096)
        yield narx.TxDriver(bench, 2)
        return
    realtime = request.param == "realtime"
    with (
        can.Bus(channel=request.node.name, realtime=realtime, tx_drivers=[2], **BUS) as bus,
        narx.TxDriver(bus, 2) as tx,
    ):
        yield tx


def test_it_is_configured_by_name_with_units(tx: narx.TxDriver) -> None:
    parameters = tx.parameters
    assert parameters["Node-ID"] == parameters["node-id"] == parameters[0x2000] == parameters[0x2000, 0] == 2
    assert (parameters["Comparator 1"], parameters.row("update time").unit) == (0.5, "ms")
    parameters["Update Time"] = 5
    tx.comparators = (0.25, 1.0)
    assert tx.comparators == (parameters[0x2007, 1], parameters[0x2007, 2]) == (0.25, 1.0)
    saved = parameters.to_dict()
    assert len(saved) == 12 and "Reset Encoder" in parameters and "Reset Encoder" not in saved
    parameters["Filter 2"] = 3
    assert parameters.load(saved) == ["Filter 2"] and parameters["Filter 2"] == 0
    tx.reset()
    assert parameters["Update Time"] == 5, "kept over a restart"


def test_positions_on_demand_by_sync_and_by_itself(tx: narx.TxDriver, request: pytest.FixtureRequest) -> None:
    # In real time the number of PDOs that arrive depends on the machine.
    simulated = request.node.callspec.params["tx"] != "realtime"
    tx.sends_encoder = True
    tx.parameters["Update Time"] = 10
    tx.start()
    reading = tx.read()
    assert reading.positions == pytest.approx((1.02,), abs=0.01) and reading.encoder is not None
    assert reading.trigger == "remote" and tx.positions == pytest.approx((1.02,), abs=0.01)
    own = tx.record(0.1)
    # The factory setting is a linear encoder.
    assert own.signals == {"time": "s", "position_1": "mm", "encoder": "", "encoder_position": "mm"}
    assert not simulated or (9 <= len(own) <= 11 and np.diff(own.time) == pytest.approx(0.01, abs=1e-3))
    tx.preoperational()
    tx.parameters["Update Time"] = 0
    tx.start()
    synced = tx.record(0.1, period=0.005)
    assert synced["position_1"] == pytest.approx(1.02, abs=0.01)
    assert not simulated or 19 <= len(synced) <= 21
    tx.preoperational()
    assert len(tx.record(0.02, period=0.005)) == 0


def test_what_it_refuses_has_a_code(tx: narx.TxDriver) -> None:
    with pytest.raises(narx.AbortError, match='node 2, 2100h "Firmware Version": 06010002h: entry cannot be written') as refused:
        tx.parameters["Firmware Version"] = 1
    assert refused.value.code == 0x06010002 and isinstance(refused.value, narx.RefusedError)
    tx.start()
    with pytest.raises(narx.AbortError, match="08000000h: not in this state"):
        tx.parameters["Update Time"]
    tx.stop()
    with pytest.raises(narx.NoAnswerError, match='node 2, 2003h "Update Time": the node does not answer'):
        tx.parameters["Update Time"]
    with pytest.raises(narx.NoAnswerError, match="node 2 sends no positions within 1 s"):
        tx.read()
    tx.preoperational()
    assert tx.parameters["Update Time"] == 0


def test_another_address(tx: narx.TxDriver) -> None:
    tx.set_node_id(9)
    assert (tx.node_id, tx.parameters["Node-ID"]) == (9, 9)
    with pytest.raises(narx.ParameterError, match='object 2000h "Node-ID" 128: must be a whole number from 1 to 127'):
        tx.set_node_id(128)
    tx.set_bitrate(250_000)
    assert tx.parameters["Bitrate Index"] == 2
    with pytest.raises(narx.ParameterError, match="bitrate 42 bit/s: must be one of 50000, 100000,"):
        tx.set_bitrate(42)


def test_a_command_is_sent_before_its_call_returns(tx: narx.TxDriver, monkeypatch: pytest.MonkeyPatch) -> None:
    """The thread that sends may be late. A command that still waited was lost when the node-id changed."""
    send, due_since = link.send_due, math.inf

    def late(master: Any, bus: can.BusABC, now: float) -> None:
        nonlocal due_since
        due_since = min(due_since, now) if master.next_poll(now) < now + 1e-6 else math.inf
        if now - due_since >= 0.01:
            send(master, bus, now)
            due_since = math.inf

    monkeypatch.setattr(link, "send_due", late)
    tx.set_node_id(9)
    assert tx.parameters["Node-ID"] == 9


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("Update Tim", 1, 'there is no object "Update Tim"; did you mean "Update Time"'),
        (0x3000, 1, "there is no object 3000h$"),
        (0x1000, 1, "there is no object 1000h; eddyCAN has no communication profile: a TX-Driver has 2000h to 2100h"),
        ((0x2007, 3), 1, "there is no object 2007h, 0003h"),
        ("Update Time", 1.5, 'object 2003h "Update Time" 1.5 ms: must be a whole number from 0 to 65535 ms'),
        ("Comparator 1", 1.1, 'object 2007h "Comparator 1" 1.1: must be a number from 0 to 1'),
        ("Filter 1", "no", "object 2006h \"Filter 1\" 'no': must be a whole number from 0 to 4"),
    ],
)
def test_what_cannot_be_written(bench: narx.Bench, key: Any, value: Any, message: str) -> None:
    bench.add_tx_driver(2)
    tx = narx.TxDriver(bench, 2)
    before = tx.parameters.to_dict()
    with pytest.raises(narx.ParameterError, match=message):
        tx.parameters[key] = value
    assert tx.parameters.to_dict() == before


def test_who_cannot_be_a_node(bench: narx.Bench) -> None:
    for node_id in (0, 128, -1):
        with pytest.raises(narx.ParameterError, match=f"node_id {node_id}: must be a whole number from 1 to 127"):
            narx.TxDriver(bench, node_id)
    with pytest.raises(narx.ParameterError, match="channels 3: must be 1 or 2"):
        narx.TxDriver(bench, 1, channels=3)  # type: ignore[arg-type]
    nobody = narx.TxDriver(bench, 77)
    with pytest.raises(narx.NoAnswerError, match="node 77 does not answer"):
        nobody.start()
    assert not nobody.connected and nobody.state is None and nobody.reading is None


def test_heartbeats_tell_the_state(bench: narx.Bench) -> None:
    bench.add_tx_driver(3, channels=2)
    tx = narx.TxDriver(bench, 3, channels=2)
    tx.heartbeat = True
    assert tx.heartbeat
    tx.start()
    assert tx.wait_for(lambda: tx.state is narx.NodeState.OPERATIONAL, 2.5) and tx.connected
    assert len(tx.positions) == 2 and tx.encoder is None and tx.errors == set()
    # A master for one channel rejects the PDOs of a node with two.
    other = narx.TxDriver(bench, 3)
    other.sync()
    other.wait(0.01)
    assert other.malformed == 1 and other.reading is None


def test_a_run_out_is_recorded_beside_the_turning_motor(bench: narx.Bench) -> None:
    bench.add_tx_driver(2, encoder=1024)
    tx = narx.TxDriver(bench, 2)
    tx.sends_encoder = True
    tx.parameters["Basic Config Register"] = 2
    tx.parameters["Counts Per Revolution"] = 1024
    tx.start()
    bench.drive.start(3000)
    bench.run(1.0)
    trace = tx.record(0.2, period=0.001)
    assert len(trace) == 200
    # 50 revolutions a second are 51.2 counts a millisecond.
    counts = np.diff(np.unwrap(trace["encoder"], period=1024))
    assert np.abs(counts).mean() == pytest.approx(51.2, rel=0.02)
    assert trace["position_1"].max() - trace["position_1"].min() == pytest.approx(0.04, abs=0.03)


def test_what_a_node_complains_of() -> None:
    with (
        can.Bus(channel="complaints", realtime=False, tx_drivers=[2], **BUS) as bus,
        narx.TxDriver(bus, 2) as tx,
    ):
        # This NMT command does not exist.
        bus.send(can.Message(arbitration_id=0, data=[0x99, 2], is_extended_id=False))
        assert tx.wait_for(lambda: bool(tx.errors), 0.1)
        assert tx.errors == {"protocol error"}
        tx.clear_errors()
        assert tx.errors == set()


def test_the_eds_says_what_there_is_instead_of_mandatory_objects(tmp_path: Path) -> None:
    (tmp_path / "tx.eds").write_text(narx.eds(1))
    read = canopen.import_od(str(tmp_path / "tx.eds"), node_id=2)
    assert 0x1000 not in read and 0x2000 in read
    assert "Instead of 1000h, 1001h, 1017h and 1018h: its node-id 2000h" in read.comments
    bench = narx.Bench("ec45-flat-50w-18v", mode="hall")
    bench.add_tx_driver(2)
    with pytest.raises(narx.ParameterError, match="there is no object"):
        narx.TxDriver(bench, 2).parameters[0x1000]


def test_canopen_sees_what_was_configured() -> None:
    with can.Bus(channel="beside", tx_drivers=[2], **BUS) as bus, narx.TxDriver(bus, 2) as tx:
        tx.parameters["Update Time"] = 20
        network = canopen.Network(can.Bus(interface="narx", channel="beside"))
        network.connect()
        try:
            node = network.add_node(2, EDS)
            assert node.sdo["Update Time"].raw == 20
            node.sdo["Update Time"].raw = 30
            assert tx.parameters["Update Time"] == 30
            node.nmt.state = "OPERATIONAL"
            tx.wait(0.05)
            assert tx.reading is not None and tx.reading.trigger == "timer"
        finally:
            bus2 = network.bus
            network.disconnect()
            if bus2 is not None:
                bus2.shutdown()


def test_a_linear_encoder_has_a_position_in_length(bench: narx.Bench) -> None:
    bench.add_tx_driver(2, encoder=1024)
    tx = narx.TxDriver(bench, 2)
    tx.sends_encoder = True
    tx.parameters["Basic Config Register"] = 0
    tx.parameters["Encoder Resolution"] = 250
    tx.parameters["Update Time"] = 2
    tx.start()
    assert tx.encoder_position == 0.0
    bench.drive.start(-1000)
    tx.wait(0.5)
    reading = tx.read()
    assert reading.encoder is not None and reading.encoder < -1000
    assert reading.encoder_position == pytest.approx(reading.encoder * 250e-6)
    trace = tx.record(0.1)
    assert trace.signals["encoder_position"] == "mm"
    assert trace["encoder_position"] == pytest.approx(trace["encoder"] * 250e-6) and trace["encoder"].max() < 0
    tx.preoperational()
    tx.parameters["Basic Config Register"] = 2
    tx.start()
    reading = tx.read()
    assert reading.encoder is not None and 0 <= reading.encoder < 1024 and reading.encoder_position is None
