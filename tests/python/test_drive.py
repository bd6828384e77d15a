"""`narx.Drive` behaves alike on a bench, on a bus in simulated time, and on a bus in real time."""

import json
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import can
import numpy as np
import pytest
import tqdm.auto

import narx

BUS: dict[str, Any] = {"interface": "narx", "motor": "ec45-flat-50w-18v", "supply_voltage": 18.0, "mode": "hall"}


@pytest.fixture(params=["bench", "stepped", "realtime"])
def drive(request: pytest.FixtureRequest, motor: narx.Motor) -> Iterator[narx.Drive]:
    """A drive with hall sensors just after power-up."""
    if request.param == "bench":
        yield narx.Bench(motor, supply_voltage=18.0, mode="hall").drive
        return
    realtime = request.param == "realtime"
    with can.Bus(channel=request.node.name, realtime=realtime, **BUS) as bus, narx.Drive(bus) as drive:
        assert drive.wait_for(lambda: drive.state is not None)
        yield drive


def test_a_motor_is_operated(drive: narx.Drive) -> None:
    drive.start(3000)
    assert drive.state is narx.State.HALL_CLOSED_LOOP
    drive.wait(1.0)
    assert drive.measurements.speed == pytest.approx(3000, rel=0.01)
    assert drive.measurements["HV Voltage"] == pytest.approx(18.0, abs=0.2)
    assert drive.measurements.full("hv current").unit == "A"
    assert drive.status["Motor mode"] == "Drive" and drive.connected and not drive.faults
    drive.set_speed(2000)
    drive.wait(1.0)
    assert drive.measurements.speed == pytest.approx(2000, rel=0.01)
    drive.start(-1500)
    assert drive.status["Motor mode"] == "Reverse"
    drive.wait(1.0)
    assert drive.measurements.speed == pytest.approx(-1500, rel=0.02)
    drive.stop()
    assert drive.wait_for(lambda: drive.state is narx.State.STANDBY)


def test_identity(drive: narx.Drive) -> None:
    info = drive.info
    assert (info.address, info.device_number, info.software) == (170, 1, "0.1")
    assert 20_260_000 < info.build_date < 20_300_000


def test_parameters(drive: narx.Drive, tmp_path: Path) -> None:
    parameters = drive.parameters
    assert drive.wait_for(lambda: drive.state is narx.State.STANDBY)
    assert parameters["Motor pair poles"] == parameters["motor PAIR poles"] == parameters[78] == 8
    assert parameters["Nominal supply voltage"] == 18.0 and parameters.row(266).unit == "V"
    parameters["Phase current limit"] = 4.5
    assert parameters[269] == 4.5
    file = tmp_path / "parameters.json"
    parameters.save(file)
    saved = json.loads(file.read_text())
    assert saved["Phase current limit"] == 4.5 and len(saved) > 100
    parameters["Phase current limit"] = 6.0
    assert parameters.diff(saved) == {"Phase current limit": (4.5, 6.0)}
    assert parameters.load_file(file) == ["Phase current limit"] and parameters.diff(saved) == {}
    assert "Phase current limit" in parameters and "Face current limit" not in parameters
    assert [row.number for row in parameters.find("phase current limit")] == [269]


def test_what_is_stored_survives_a_reboot(drive: narx.Drive) -> None:
    assert drive.wait_for(lambda: drive.state is narx.State.STANDBY)
    drive.parameters["Winding resistance"] = 1.234
    drive.parameters.store()
    drive.parameters["Winding inductance"] = 0.000321
    drive.reboot()
    assert drive.parameters["Winding resistance"] == 1.234 and drive.parameters["Winding inductance"] == 0.000321
    drive.parameters["Automatic store"] = 0
    drive.parameters["Winding inductance"] = 0.000432
    drive.reboot()
    assert drive.parameters["Winding inductance"] == 0.000321


def test_a_restore_is_in_force_after_the_reboot(drive: narx.Drive) -> None:
    assert drive.wait_for(lambda: drive.state is narx.State.STANDBY)
    drive.parameters["Hall effect offset angle"] = 12.0
    drive.parameters["Device Number"] = 9  # counts from the next reboot on
    drive.start(2000)
    drive.parameters.restore_factory()
    assert drive.parameters["Hall effect offset angle"] == 12.0 and drive.state is narx.State.HALL_CLOSED_LOOP
    drive.stop()
    drive.reboot()
    offset = drive.parameters.row("Hall effect offset angle")
    assert drive.parameters[offset.number] == offset.factory


REFUSED: list[tuple[Callable[[narx.Parameters], object], type[narx.NarxError], str]] = [
    (lambda p: p["Motor pair pole"], narx.ParameterError, 'no parameter "Motor pair pole"; did you mean "Motor pair poles"'),
    (lambda p: p[999], narx.ParameterError, "there is no parameter 999"),
    (lambda p: p.__setitem__(78, 51), narx.ParameterError, 'parameter 78 "Motor pair poles": 51 is outside 1 to 50'),
    (lambda p: p.__setitem__(78, float("nan")), narx.ParameterError, 'parameter 78 "Motor pair poles": NaN is outside'),
    (lambda p: p.__setitem__(78, float("inf")), narx.ParameterError, 'parameter 78 "Motor pair poles": inf is outside'),
    (lambda p: p.__setitem__(78, 2.5), narx.ParameterError, 'parameter 78 "Motor pair poles": 2.5 is not a whole number from 1 to 50'),
    (lambda p: p.__setitem__(78, True), narx.ParameterError, 'parameter 78 "Motor pair poles": True is not a whole number from 1 to 50'),
    (lambda p: p.__setitem__(78, json.loads('"٨"')), narx.ParameterError, "parameter 78 \"Motor pair poles\": '٨' is not a whole number from 1 to 50"),
    (lambda p: p.load({78: 2.5}), narx.ParameterError, 'parameter 78 "Motor pair poles": 2.5 is not a whole number'),
    (lambda p: p.__setitem__("Build number", 1), narx.ParameterError, 'parameter 5 "Build number": only the drive writes it'),
    (lambda p: p.load({78: 4, 5: 1}), narx.ParameterError, 'parameter 5 "Build number": read-only'),
    (lambda p: p.load({78: 4, 266: 1000}), narx.ParameterError, 'parameter 266 "Nominal supply voltage": 1000 V is outside'),
]


def test_a_refused_parameter_is_named_and_nothing_changes(drive: narx.Drive) -> None:
    assert drive.wait_for(lambda: drive.state is narx.State.STANDBY)
    before = drive.parameters.to_dict()
    for call, kind, message in REFUSED:
        with pytest.raises(kind, match=message):
            call(drive.parameters)
    assert drive.parameters.to_dict() == before
    drive.start(2000)
    with pytest.raises(narx.RefusedError, match='parameter 78 "Motor pair poles"'):
        drive.parameters[78] = 4
    with pytest.raises(narx.RefusedError):
        drive.parameters.store()


def test_scope_captures_what_is_asked_for(drive: narx.Drive) -> None:
    drive.start(3000)
    drive.wait(0.7)
    seen = drive.scope.capture(["Hall code", "Duty"], samples=400, before=100)
    assert list(seen) == ["time", "Duty", "Hall code"] and len(seen) == 400
    assert seen.time[100] == 0.0 and np.diff(seen.time) == pytest.approx(1e-4)
    assert set(seen["Hall code"]) == {1.0, 2.0, 3.0, 4.0, 5.0, 6.0}
    # 3000 rpm at 8 pole pairs: 400 electrical revolutions a second with six hall codes each.
    changes = np.count_nonzero(np.diff(seen["Hall code"])) / (len(seen) * 1e-4)
    assert changes == pytest.approx(2400, rel=0.02)
    drive.scope.arm(["Drive state"], samples=50, before=10, trigger=narx.Trigger.state_change())
    assert drive.scope.state is narx.ScopeState.ARMED
    drive.stop()
    drive.scope.wait()
    states = drive.scope.download()["Drive state"]
    assert states[9] == narx.State.HALL_CLOSED_LOOP and states[11] == narx.State.STANDBY


def test_scope_records_what_runs_again(bench: narx.Bench, tmp_path: Path) -> None:
    drive = bench.drive
    drive.start(1500)
    drive.scope.arm_inputs(ticks=300, before=200, trigger=narx.Trigger.fault())
    bench.run(0.1)
    bench.inject("driver", phase="A")
    drive.scope.wait()
    with pytest.raises(narx.RefusedError, match=r"has recorded inputs: download_recording\(\) reads it"):
        drive.scope.download()
    record = drive.scope.download_recording()
    record.save(tmp_path / "fault.narxrec")
    again = narx.replay(tmp_path / "fault.narxrec")
    assert again.identical and again.ticks >= 300 and record.agrees is not False
    # The bench has recorded the same ticks.
    whole = narx.replay(bench.run(0.0).recording())
    assert whole.identical
    rows = slice(record.first_tick, record.first_tick + again.ticks)
    for name in ("state", "duty", "step", "hall"):
        assert np.array_equal(again[name], whole[name][rows]), name
    assert set(again["state"]) == {narx.State.HALL_CLOSED_LOOP, narx.State.FAULT}


def test_scope_records_inputs_at_once(drive: narx.Drive) -> None:
    drive.start(1500)
    record = drive.scope.record(ticks=200, before=50)
    assert narx.replay(record.recording).identical
    drive.scope.capture(["Duty"], samples=10)
    with pytest.raises(narx.RefusedError, match=r"has recorded signals: download\(\) reads it"):
        drive.scope.download_recording()


def test_two_threads_share_the_scope(request: pytest.FixtureRequest) -> None:
    """A record that one thread awaits is forced by another; a second record is refused, and the first goes on."""
    with can.Bus(channel=request.node.name, realtime=True, **BUS) as bus, narx.Drive(bus) as drive, ThreadPoolExecutor(1) as thread:
        assert drive.wait_for(lambda: drive.state is narx.State.STANDBY)
        awaited = thread.submit(drive.scope.capture, ["Duty"], samples=20, trigger=narx.Trigger.forced())
        assert drive.wait_for(lambda: drive.scope.state.name == "ARMED")
        with pytest.raises(narx.RefusedError, match="^arm scope: another thread records with the scope, or erases the log$"):
            drive.scope.arm(["Duty"])
        drive.scope.force()
        assert len(awaited.result(timeout=10)) == 20


def test_scope_refuses(drive: narx.Drive) -> None:
    with pytest.raises(narx.SignalError, match='no scope signal "Duti"; did you mean "Duty"'):
        drive.scope.arm(["Duti"])
    with pytest.raises(narx.ParameterError, match="signals: must name at least one signal"):
        drive.scope.arm([])
    with pytest.raises(narx.RefusedError, match="the scope is idle: no record is stored"):
        drive.scope.download()
    # A request that does not fit is refused, never shortened: nine signals have room for 455 samples in 4096
    # words, at 0.3 ms.
    nine = list(drive.scope.signals)[:9]
    with pytest.raises(narx.ParameterError, match=r"^samples 2000: must be 1 to 455 for 9 signals, .* 4096 words; prescaler 3 or more"):
        drive.scope.capture(nine, samples=2000)
    with pytest.raises(narx.ParameterError, match=r"^prescaler 1: must be at least 3 for 9 signals: the drive reads 4 signals per control tick"):
        drive.scope.capture(nine, samples=455)
    with pytest.raises(narx.ParameterError, match=r"^before 10: must be 0 to 9, fewer than samples 10"):
        drive.scope.capture(["Duty"], samples=10, before=10)
    seen = drive.scope.capture(nine, samples=455, prescaler=3)
    assert len(seen) == 455 and np.diff(seen.time) == pytest.approx(3e-4)
    # What only the drive checks it refuses itself, with its reason.
    with pytest.raises(narx.ParameterError, match=r'"Virtual Scop Sampling Prescaler": 20000 is outside 1 to 10000'):
        drive.scope.arm(["Duty"], prescaler=20_000)
    with pytest.raises(narx.ParameterError, match=r"^samples 2.5: must be a whole number"):
        drive.scope.arm(["Duty"], samples=2.5)  # type: ignore[arg-type]
    assert drive.scope.state is narx.ScopeState.DONE
    drive.scope.arm(["Duty"], trigger=narx.Trigger.rising("HV Voltage", 25.0))
    with pytest.raises(narx.RefusedError, match="the scope is armed: force it"):
        drive.scope.arm(["Duty"])
    with pytest.raises(narx.NoAnswerError, match="armed after 0.2 s: the trigger has not occurred"):
        drive.scope.wait(0.2)
    drive.scope.force()
    drive.scope.wait()
    assert len(drive.scope.download()) == 256


def test_scope_records_a_start_that_is_under_way(drive: narx.Drive) -> None:
    drive.start(1500, wait=False)
    states = drive.scope.capture(["Drive state"], 100, before=20, trigger=narx.Trigger.state_change())["Drive state"]
    assert states[19] != states[21]
    assert drive.wait_for(lambda: drive.state is narx.State.HALL_CLOSED_LOOP)


def test_log_is_written_downloaded_and_erased(drive: narx.Drive) -> None:
    log = drive.log
    assert drive.wait_for(lambda: drive.state is narx.State.STANDBY)
    assert log.capacity > 100_000 and len(log) == 0 and len(log.download()) == 0
    log.configure({"HV Voltage": "mean", "Mechanical estimated speed HES": "max", "Drive state": "live"}, period=0.01)
    assert log.slots == {"HV Voltage": "mean", "Mechanical estimated speed HES": "max", "Drive state": "live"}
    drive.start(2500)
    # A second of wall time may be much less than a second of the drive's time.
    assert drive.wait_for(lambda: (drive.measurements.speed or 0.0) > 2450)
    drive.wait(1.0)
    drive.stop()
    log.configure([], period=1.0)
    told: list[tuple[int, int]] = []
    records = log.download(progress=lambda received, total: told.append((received, total)))
    assert list(records) == ["index", "time", "HV Voltage mean", "Mechanical estimated speed HES max", "Drive state"]
    assert len(records) == len(log) > 20 and told[-1][0] == told[-1][1] > 0
    assert records["index"].tolist() == list(range(len(records)))
    # While the slots were being written, and once they are taken back, the period was another one.
    moving = records.time[records["Mechanical estimated speed HES max"] > 0]
    assert len(moving) > 10 and np.diff(moving)[:-1] == pytest.approx(0.01)
    assert records["Mechanical estimated speed HES max"].max() == pytest.approx(2500, rel=0.05)
    part = log.download(first=20, count=5)
    assert part["index"].tolist() == [20, 21, 22, 23, 24] and (part["time"] == records["time"][20:25]).all()
    with pytest.raises(narx.ParameterError, match="the log has"):
        log.download(first=len(log), count=1)
    assert drive.wait_for(lambda: drive.state is narx.State.STANDBY)
    log.erase()
    assert len(log) == 0


def test_log_refuses(drive: narx.Drive) -> None:
    with pytest.raises(narx.ParameterError, match='no parameter or measurement "HV Volt"; did you mean "HV Voltage"'):
        drive.log.configure(["HV Volt"], period=0.1)
    with pytest.raises(narx.ParameterError, match='kept value "first": must be one of live, min, max, mean'):
        drive.log.configure({"HV Voltage": "first"}, period=0.1)
    with pytest.raises(narx.ParameterError, match="^period 0 s: must be a number from 0.001 to 3600 s"):
        drive.log.configure(["HV Voltage"], period=0.0)


def test_the_description_comes_from_the_drive(drive: narx.Drive) -> None:
    text = drive.description()
    assert text.startswith("<?xml") and text.rstrip().endswith("</description>")
    assert 'name="Motor pair poles"' in text


def test_a_download_that_is_interrupted_leaves_the_drive_ready(drive: narx.Drive) -> None:
    def interrupt(received: int, _: int) -> None:
        if received > 300:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        drive.description(progress=interrupt)
    assert drive.info.address == 170


def test_lines_and_services(drive: narx.Drive) -> None:
    assert drive.wait_for(lambda: drive.state is narx.State.STANDBY)
    drive.set_outputs(dsio1=True)
    drive.wait(0.3)
    assert drive.measurements["DSI1_DSP"] == 1.0
    drive.set_outputs()
    drive.set_position()
    drive.set_hall_supply(False)
    drive.set_hall_supply(True)
    drive.auto_calibrate()
    drive.shut_down()
    assert drive.wait_for(lambda: drive.state is narx.State.FAULT)
    assert drive.wait_for(lambda: drive.fault is not None) and drive.faults == {"external_shutdown"}
    with pytest.raises(narx.StartError, match="the drive is in Fault"):
        drive.start(1000)
    drive.stop()
    assert drive.wait_for(lambda: drive.state is narx.State.STANDBY)


class SlowBus:
    """A simulated bus with a slow drive: one second of the drive takes eight seconds of the master.

    This is the behaviour of an emulator on a busy host.
    """

    realtime = False

    def __init__(self, bus: Any) -> None:
        self._bus = bus
        self.send = bus.send

    @property
    def time(self) -> float:
        return 8.0 * float(self._bus.time)

    def recv(self, timeout: float) -> can.Message | None:
        message: can.Message | None = self._bus.recv(timeout / 8.0)
        return message


def test_a_slow_drive_has_its_time_to_start_and_to_refuse() -> None:
    slow: Any = SlowBus(can.Bus(channel="slow", realtime=False, **BUS))
    with slow._bus, narx.Drive(slow) as drive:
        assert drive.wait_for(lambda: drive.state is narx.State.STANDBY)
        enable = "Closed-loop Hall Effect Sensors enable"
        drive.parameters[enable] = 0
        with pytest.raises(narx.StartError, match="the drive refused the start: no mode is enabled"):
            drive.start(2000)
        drive.parameters[enable] = 1
        drive.start(2000)
        assert drive.state is narx.State.HALL_CLOSED_LOOP


def test_what_is_no_fault_is_told() -> None:
    bench = narx.Bench(narx.Motor.preset("bly172s-24v"), supply_voltage=24, mode="sensorless")
    bench.run(0.6)
    assert bench.drive.diagnostics == set()
    bench.drive.parameters["Back-EMF constant"] = 0
    assert bench.drive.diagnostics == {"wrong_lock_unseen"}


def test_open_loop_has_a_speed() -> None:
    bench = narx.Bench(narx.Motor.preset("bly172s-24v"), supply_voltage=24, mode="open-loop")
    speed = bench.drive.parameters["Open-loop speed setpoint"]
    bench.drive.start(int(speed))
    bench.run(2.0)
    assert bench.drive.measurements.speed == speed
    assert bench.run(0.1)["speed_estimated"][-1] == pytest.approx(speed, abs=1)


def test_a_short_run_makes_no_bar(bench: narx.Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    """An experiment runs a bench some milliseconds at a time: a notebook would show a bar for each."""
    made: list[float] = []
    real = tqdm.auto.tqdm

    def counted(*arguments: Any, **options: Any) -> Any:
        made.append(options["total"])
        return real(*arguments, **options)

    monkeypatch.setattr(tqdm.auto, "tqdm", counted)
    bench.run(1.5)
    assert made == [], "nobody sees it"
    monkeypatch.setattr("narx.progress.is_watched", lambda: True)
    bench.run(0.002)
    bench.run(1.5)
    assert made == [1.5]


def test_progress_is_a_bar_or_a_function(bench: narx.Bench, capsys: pytest.CaptureFixture[str]) -> None:
    seen: list[tuple[int, int]] = []
    bench.run(0.2)
    bench.drive.description(lambda done, total: seen.append((done, total)))
    assert seen[-1][0] == seen[-1][1] > 0 and capsys.readouterr().err == ""
    for show in (lambda: bench.drive.description(True), lambda: bench.run(0.1, progress=True), lambda: bench.drive.scope.capture(["Duty"], samples=20)):
        show()
    shown = capsys.readouterr().err
    assert "100%" in shown and "0.1/0.1 s" in shown
    bench.run(1.5)
    bench.drive.description()
    # No bar by itself where the output is no terminal.
    assert capsys.readouterr().err == ""
