"""Hostile input: each ends in an error of narx, or in a result that tells of it; never in a panic, a hang or a
memory that grows with it."""

import gzip
import json
import math
import os
import random
import resource
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import can
import numpy as np
import pytest

import narx
from narx import experiments

VECTORS = Path(__file__).parents[1] / "vectors"
BENCH = narx.Bench("ec45-flat-50w-18v", mode="hall")
NAN, INF = math.nan, math.inf

CALLS: list[Callable[[Any], object]] = [
    lambda value: BENCH.run(value),
    lambda value: BENCH.run(0.0, every=value),
    lambda value: BENCH.copy().set_load([value]),  # type: ignore[arg-type]
    lambda value: loaded(value).run(0.01),
    lambda value: BENCH.set_supply(resistance=value),
    lambda value: BENCH.copy().set_supply(([0.0, value], [1.0, value])),
    lambda value: narx.Load(machine=value),
    lambda value: narx.Load(constant=value),
    lambda value: narx.Motor.preset("bly172s-24v").replace(thermal_time=value),
    lambda value: BENCH.drive.wait(value),
    lambda value: BENCH.drive.start(value),
    lambda value: BENCH.inject("supply", value),
    lambda value: BENCH.add_tx_driver(value),
    lambda value: narx.Bridge(None, port=value),  # type: ignore[arg-type]
    lambda value: narx.Bench(value),
    lambda value: narx.replay(value),
    lambda value: narx.read_log(value),
    lambda value: narx.sweep({"rpm": value, "motor": value}),
    lambda value: experiments.torque_speed_map("bly172s-24v", speeds=[value], torques=[0.0]),
    lambda value: experiments.step_response(value, 1000),
]
VALUES: list[Any] = [NAN, -INF, -1.5, "x\0y", b"\xff", None, object(), [], {}, 10**400, 1j, np.array([1.0, 2.0]), lambda: None]


def loaded(value: Any) -> narx.Bench:
    """Returns a bench whose load is this value as time passes."""
    bench = BENCH.copy()
    bench.set_load(lambda time: value)
    return bench


@pytest.mark.parametrize("value", VALUES, ids=lambda value: repr(value)[:12])
@pytest.mark.parametrize("call", CALLS, ids=range(len(CALLS)))
def test_an_argument_is_refused(call: Callable[[Any], object], value: Any) -> None:
    time = BENCH.time
    try:
        call(value)
    except (narx.NarxError, FileNotFoundError) as error:
        assert str(error)
    # What is no error is a default (`None`), or a value that is one here.
    assert time <= BENCH.time < time + 0.5


def test_every_hundredth_byte_of_a_recording_flipped() -> None:
    recording = (VECTORS / "acknowledge.narxrec").read_bytes()
    seen = set()
    for place in range(0, len(recording), 100):
        broken = bytearray(recording)
        broken[place] ^= 0xFF
        try:
            narx.replay(broken)
        except narx.RecordingError as error:
            seen.add(str(error).partition(":")[0])
        else:
            pytest.fail(f"byte {place} may be anything")
    assert len(seen) >= 2


@pytest.mark.parametrize("ending", [".log", ".asc", ".csv", ".trc", ".blf", ".log.gz", ".asc.gz", ".narxrec", ".narximg", ".json"])
@pytest.mark.parametrize("kind", ["nothing", "zeros", "noise", "text", "one long line"])
def test_a_file_of_garbage(tmp_path: Path, ending: str, kind: str) -> None:
    noise = random.Random(1).randbytes(200_000)
    data = {"nothing": b"", "zeros": bytes(200_000), "noise": noise, "text": b"(1.0) can0 \xff\xfe#zz\r\n" * 5000, "one long line": b"(1.0) can0 123#" + b"0" * 2_000_000}[kind]
    file = tmp_path / f"garbage{ending}"
    file.write_bytes(gzip.compress(data, 1) if ending.endswith(".gz") and kind != "noise" else data)
    try:
        if ending == ".narxrec":
            narx.replay(file)
        elif ending == ".narximg":
            BENCH.copy().drive.update(file)
        elif ending == ".json":
            BENCH.copy().drive.parameters.load_file(file)
        else:
            log = narx.read_log(file)
            assert len(log.frames) == 0 and (kind in ("nothing", "zeros") or log.errors)
            assert all(len(error.text) < 500 for error in log.errors)
            return
    except narx.NarxError as error:
        assert len(str(error)) < 2000
        return
    pytest.fail("it was taken")


def test_a_bomb_of_zeros_is_not_unpacked(tmp_path: Path) -> None:
    file = tmp_path / "bomb.log.gz"
    with gzip.open(file, "wb", 9) as packed:
        for _ in range(400):
            packed.write(bytes(1 << 20))
    assert file.stat().st_size < 1 << 20
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    log = narx.read_log(file)
    assert any("expands more than" in error.reason for error in log.errors) and len(log.frames) == 0
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 250_000, "kB"


def test_a_deep_or_odd_parameter_file(tmp_path: Path) -> None:
    for text in ("[" * 100_000, json.dumps([1]), '{"Motor pair poles": 1e400}', '{"Motor pair poles": NaN}', '{"Motor pair poles": []}', '{"\\u0000": 1}', "{}" + " " * 10 + "x"):
        file = tmp_path / "drive.json"
        file.write_text(text)
        with pytest.raises(narx.ParameterError):
            BENCH.copy().drive.parameters.load_file(file)


def test_a_bus_that_was_shut_down() -> None:
    bus = can.Bus(interface="narx", channel="shut", motor="ec45-flat-50w-18v", supply_voltage=18.0, mode="hall", realtime=False)
    drive, tx = narx.Drive(bus), narx.TxDriver(can.Bus(interface="narx", channel="shut", realtime=False), 2)
    bus.shutdown()
    for call in (lambda: drive.start(1000), lambda: drive.wait(0.1), lambda: drive.info, lambda: drive.parameters[78], drive.log.erase):
        with pytest.raises((narx.NarxError, can.CanError)):
            call()
    tx._link._bus.shutdown()  # type: ignore[attr-defined]
    with pytest.raises((narx.NarxError, can.CanError)):
        tx.read()


def test_two_threads_on_one_bench() -> None:
    bench = narx.Bench("ec45-flat-50w-18v", mode="hall")
    bench.drive.start(2000)
    before, errors = bench.time, []

    def work(act: Callable[[], object]) -> None:
        try:
            for _ in range(20):
                act()
        except BaseException as error:  # noqa: BLE001
            errors.append(error)

    acts: list[Callable[[], object]] = [lambda: bench.run(0.01), lambda: bench.run(0.01, signals=["speed"], every=3), bench.copy, lambda: repr(bench), lambda: bench.set_load(0.01)]
    threads = [threading.Thread(target=work, args=(act,)) for act in acts]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
        assert not thread.is_alive()
    assert not errors and bench.time == pytest.approx(before + 0.4, abs=0.02) and not bench.drive.faults


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
def test_a_bench_in_a_forked_process() -> None:
    bench = narx.Bench("ec45-flat-50w-18v", mode="hall")
    bench.drive.start(2000)
    child = os.fork()
    if child == 0:
        try:
            trace = bench.run(0.1)
            os._exit(0 if len(trace) == 1000 and narx.replay(trace.recording()).identical else 1)
        finally:
            os._exit(2)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    assert len(bench.run(0.1)) == 1000
