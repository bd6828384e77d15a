"""Sweeps: the table is the same on every executor, and every variant can be repeated bit for bit."""

import importlib.util
import itertools
import pickle
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from queue import LifoQueue
from typing import Any

import numpy as np
import pandas as pd
import pytest
from pandas.testing import assert_frame_equal

import narx

BENCH: dict[str, Any] = {"motor": "ec45-flat-50w-18v", "supply_voltage": 18.0, "mode": "hall", "seconds": 0.3}
GRID: dict[str, Any] = BENCH | {"rpm": [1000, 2000], "load_constant": [0.0, 0.02], "Phase current limit": [3, 6]}


def measure(variant: narx.Variant) -> dict[str, Any]:
    """A user's experiment, which fails for some variants."""
    if variant["rpm"] == 2000:
        raise ValueError(f"{variant['rpm']} rpm is too fast for variant {variant.index}")
    bench = variant.bench(mode="hall")
    bench.drive.start(variant["rpm"])
    trace = bench.run(0.1)
    return {"peak": float(trace["peak_current"].max()), "digest": bench.digest, "reached": variant.index > 0}


@pytest.fixture(scope="module")
def processes() -> Iterator[Executor]:
    """Two worker processes."""
    with ProcessPoolExecutor(2) as pool:
        yield pool


@pytest.fixture(scope="module")
def dask() -> Iterator[Executor]:
    """A Dask cluster of two worker processes."""
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0") as cluster,
        distributed.Client(cluster) as client,
    ):
        # The folder of the tests is not on the path of the workers.
        client.upload_file(__file__)
        yield client.get_executor()


@pytest.fixture(params=["processes", "dask", "threads", "backwards"])
def executor(request: pytest.FixtureRequest) -> Iterator[Executor]:
    """Each kind of executor in turn."""
    if request.param == "threads":
        with ThreadPoolExecutor(3) as pool:
            yield pool
    elif request.param == "backwards":
        with Backwards() as pool:
            yield pool
    else:
        yield request.getfixturevalue(request.param)


class Backwards(ThreadPoolExecutor):
    """Runs the newest of its tasks first, one at a time."""

    def __init__(self) -> None:
        super().__init__(1)
        self._work_queue = LifoQueue()  # type: ignore[assignment]
        self.submitted = self.most = 0

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future = super().submit(fn, *args, **kwargs)
        self.submitted += 1
        self.most = max(self.most, self._work_queue.qsize())
        return future


@pytest.fixture(scope="module")
def inside() -> narx.Sweep:
    """The built-in experiment on the threads of the Rust part."""
    return narx.sweep(GRID, samples=1)


def test_the_experiment_is_the_same_on_every_executor(executor: Executor, inside: narx.Sweep) -> None:
    outside = narx.sweep(GRID, executor, chunk=1)
    assert_frame_equal(outside.to_pandas(), inside.to_pandas())
    assert len(inside) == 8 and set(inside["outcome"]) == {"running"}


def test_a_function_is_the_same_on_every_executor(executor: Executor) -> None:
    grid = {name: values for name, values in GRID.items() if name != "seconds"}
    expected = narx.sweep(measure, grid=grid)
    found = narx.sweep(measure, executor, grid=grid)
    assert_frame_equal(found.to_pandas(), expected.to_pandas())
    assert found["outcome"].tolist() == ["ok"] * 4 + ["error"] * 4
    assert found["error"][4] == "ValueError: 2000 rpm is too fast for variant 4" and found["error"][0] == ""
    assert found["reached"].tolist() == [False, True, True, True] + [None] * 4
    assert np.isnan(found["peak"][4:]).all() and (found["peak"][:4] > 0.5).all()
    # Failures and results are the same on replay.
    assert found.replay(2)["digest"] == expected.replay(2)["digest"] == found.to_dict()[2]["digest"]
    with pytest.raises(ValueError, match="too fast for variant 6"):
        found.replay(6)


def test_a_variant_runs_again_bit_for_bit(inside: narx.Sweep) -> None:
    for number in (0, 5):
        trace = inside.replay(number)
        replay = narx.replay(trace.recording())
        assert replay.identical and f"{replay.digest:016x}" == inside["digest"][number]
        assert trace["peak_current"].max() == pytest.approx(inside["peak_current"][number], rel=1e-6)
    assert len(set(inside["digest"])) == len(inside)
    # A variant can also be repeated from a row of a saved table, which contains the seed.
    row = {name: inside.to_pandas().iloc[5][name] for name in ["seed", *inside.varied]}
    again = narx.sweep([row])
    assert again["digest"][0] == inside["digest"][5] and again["seed"][0] == inside["seed"][5]
    with pytest.raises(narx.ParameterError, match="variant 8: is not one of the 8 here"):
        inside.replay(8)


def test_the_experiment_is_what_a_user_would_run(inside: narx.Sweep) -> None:
    variant = inside.variants[3]
    assert (variant["rpm"], variant["load_constant"], variant["Phase current limit"]) == (1000, 0.02, 6)
    bench = narx.Bench(
        narx.Motor.preset(BENCH["motor"]), 18.0, narx.Load(constant=0.02), "hall", {"Phase current limit": 6},
        seed=variant.seed,
    )  # fmt: skip
    bench.drive.start(1000, wait=False)
    # The drive accepts the start after its self-tests.
    trace = bench.run(0.9)
    row = inside.to_dict()[3]
    assert f"{bench.digest:016x}" == row["digest"]
    started = float(trace.time[np.argmax(trace["state"] == narx.State.HALL_CLOSED_LOOP)])
    assert 0.6 + row["start_time"] == pytest.approx(started, abs=0.0015)
    assert row["peak_current"] == pytest.approx(trace["peak_current"].max(), rel=1e-6)
    fast = trace["speed"] >= 900
    assert 0.6 + row["time_to_speed"] == pytest.approx(trace.time[np.argmax(fast)], abs=2e-4)
    quarter = trace["speed"][-750:]
    assert row["speed"] == pytest.approx(quarter.mean(), rel=1e-3)
    assert row["ripple"] == pytest.approx((quarter.max() - quarter.min()) / 1000, rel=1e-3)
    assert row["bus_voltage_max"] == pytest.approx(trace["bus_voltage"][-3000:].max(), rel=1e-6)
    assert row["attempts"] == 1 and row["state"] == narx.State.HALL_CLOSED_LOOP


def test_a_start_that_fails_is_a_result() -> None:
    swept = narx.sweep(
        BENCH
        | {
            "rpm": 1500,
            "fault": [None, "open-phase"],
            "fault_phase": "B",
            "mode": ["hall", "sensorless"],
            "seconds": 1.5,
        }
    )
    # The columns vary in the order of their names in the grid, the last one fastest.
    assert list(zip(swept["mode"], swept["fault"], strict=True)) == [
        ("hall", ""), ("hall", "open-phase"), ("sensorless", ""), ("sensorless", "open-phase"),
    ]  # fmt: skip
    rows = swept.to_dict()
    assert rows[0]["outcome"] == rows[2]["outcome"] == "running" and swept.failures["variant"].tolist() == [1, 3]
    hall = rows[1]
    assert (hall["outcome"], hall["error"], hall["state"]) == ("fault", "", narx.State.FAULT)
    assert hall["faults"] == "legs_driver" and hall["extended_code"] == 0x0502
    assert hall["cause"].startswith("a phase carries no current")
    assert narx.replay(swept.failures.replay(3).recording()).identical


def test_a_set_point_that_the_drive_clamps_is_an_outcome() -> None:
    swept = narx.sweep(BENCH | {"rpm": [20_000, -20_000, 2000], "seconds": 0.5})
    most = round(narx.Motor.preset(BENCH["motor"]).operating_range(18.0, "hall").speed_max)
    assert swept["setpoint"].tolist() == [20_000, -20_000, 2000] and swept["accepted"].tolist() == [most, -most, 2000]
    assert swept["outcome"].tolist() == ["clamped", "clamped", "running"] and swept.failures["variant"].tolist() == [0, 1]
    assert swept.units["accepted"] == "rpm"


def test_rows_have_the_notes_of_their_benches() -> None:
    hot = narx.Motor.preset("ec45-flat-50w-18v").replace(thermal_resistance=1000.0, thermal_time=0.5)
    points = [("bly172s-24v", 24.0, 0.0), (hot, 18.0, 0.08)]
    swept = narx.sweep([{"motor": motor, "supply_voltage": volts, "load_constant": load, "mode": "hall"} for motor, volts, load in points])
    assert swept["notes"][0] == "; ".join(narx.Bench("bly172s-24v", 24.0, mode="hall").notes) and "speed is limited to" in swept["notes"][0]
    assert "the winding has reached" in swept["notes"][1] and "this motor would be damaged" in swept["notes"][1]
    assert swept["winding_temperature"][1] > hot.max_winding_temperature


def test_a_function_that_ends_the_program_ends_its_own_variant() -> None:
    swept = narx.sweep(lambda variant: sys.exit(3) if variant.index == 1 else variant.index, grid={"a": range(3)})
    assert swept["outcome"].tolist() == ["ok", "error", "ok"] and swept["error"][1] == "SystemExit: 3"


def test_a_fault_comes_when_it_is_to() -> None:
    swept = narx.sweep(BENCH | {"rpm": 1500, "fault": "hall-supply-lost", "fault_time": [0.2, 0.4], "seconds": 0.5})
    for number, time in enumerate((0.2, 0.4)):
        trace = swept.replay(number)
        broken = trace.time[np.argmax((trace["hall"] == 7) & (trace.time > 0.6))]
        assert broken - 0.6 == pytest.approx(time, abs=2e-4)


def test_a_variant_that_cannot_be_does_not_end_the_others(executor: Executor) -> None:
    grid = BENCH | {"rpm": 1000, "supply_voltage": [18.0, 61.0, 24.0], "seconds": 0.05}
    for swept in (narx.sweep(grid), narx.sweep(grid, executor)):
        assert swept["outcome"].tolist() == ["running", "error", "running"]
        assert swept["error"][1] == "ParameterError: supply voltage 61 V is outside 18 to 60 V"
        assert np.isnan(swept["speed"][1]) and swept["digest"][1] == ""


def test_seeds_follow_from_place_and_seed() -> None:
    grid = {"rpm": [1, 2]}

    def seeds(**options: Any) -> list[int]:
        return [variant.seed for variant in narx.sweep(lambda _: None, grid=grid, **options).variants]

    assert seeds() == seeds(seed=1) != seeds(seed=2)
    assert len(set(seeds(samples=50))) == 100 and seeds(samples=50)[:2] == seeds()
    assert max(seeds(samples=50)) < 2**53
    given = narx.sweep(lambda variant: variant.seed, grid=[{"seed": 7}, {"seed": 8}, {}])
    assert given["result"].tolist()[:2] == given["seed"].tolist()[:2] == [7, 8]


@pytest.mark.parametrize(
    ("grid", "points"),
    [
        ({"a": 1, "b": [1, 2], "c": ("x",)}, [(1, 1, "x"), (1, 2, "x")]),
        ({"a": range(2), "b": np.array([0.5]), "c": "xyz"}, [(0, 0.5, "xyz"), (1, 0.5, "xyz")]),
        ([{"a": 1}, {"b": 2, "c": None}], [(1, None, None), (None, 2, None)]),
        (pd.DataFrame({"a": [1, 2], "b": [0.5, np.nan], "c": ["x", None]}), [(1, 0.5, "x"), (2, None, None)]),
    ],
)
def test_grids_become_variants(grid: Any, points: list[tuple[Any, ...]]) -> None:
    swept = narx.sweep(lambda variant: None, grid=grid)
    assert [tuple(variant.get(name) for name in "abc") for variant in swept.variants] == points
    assert swept["variant"].tolist() == list(range(len(points)))


def test_motors_and_loads_are_varied_as_a_whole_and_by_figure() -> None:
    motor = narx.Motor.preset("ec45-flat-50w-18v")
    grid = BENCH | {
        "motor": [motor, motor.replace(resistance=2.0)],
        "load": [narx.Load(constant=0.01)],
        "rpm": 1000,
        "seconds": 0.1,
    }
    whole = narx.sweep(grid)
    figures = narx.sweep(
        BENCH | {"resistance": [motor.resistance, 2.0], "load_constant": 0.01, "rpm": 1000, "seconds": 0.1}
    )
    assert whole["digest"].tolist() == figures["digest"].tolist() and len(set(whole["digest"])) == 2
    assert whole["motor"][0] == "ec45-flat-50w-18v" and "2 ohm" in whole["motor"][1]


REFUSALS: list[tuple[Callable[[], object], str]] = [
    (lambda: narx.sweep({"resistence": [1, 2]}), 'there is no "resistence" to vary; did you mean "resistance"'),
    (
        lambda: narx.sweep({"Motor pair pole": 1}),
        'there is no "Motor pair pole" to vary; did you mean "Motor pair poles"',
    ),
    (lambda: narx.sweep({"rpm": []}), '"rpm" has no values to vary'),
    (lambda: narx.sweep({"rpm": [1000, float("nan")]}), '"rpm" nan: must not be NaN; None is a value that is not given'),
    (lambda: narx.sweep(abs, grid={"rpm": np.array([np.nan])}), '"rpm" nan: must not be NaN'),  # type: ignore[arg-type]
    (lambda: narx.sweep({"rpm": range(40_000), "supply_voltage": range(25_000)}), "1000000000 variants: must be at most 10000000"),
    (lambda: narx.sweep({"rpm": itertools.count()}), "10000001 variants: must be at most 10000000"),
    (lambda: narx.sweep([{"rpm": 1}], samples=10**9), "1000000000 variants: must be at most 10000000"),
    (lambda: narx.sweep([]), "the grid has no variant"),
    (lambda: narx.sweep([3]), "variant 3: must be a mapping"),  # type: ignore[list-item]
    (lambda: narx.sweep({"rpm": 1}, samples=0), "samples 0: must be a whole number, 1 or more"),
    (lambda: narx.sweep({"rpm": 1}, seed=-1), "seed -1: must be a whole number from 0 to 18446744073709551615"),
    (lambda: narx.sweep({"rpm": 1}, chunk=0), "chunk 0: must be a whole number, 1 or more"),
    (lambda: narx.sweep({"rpm": 1}, grid={"rpm": 1}), "grid: only together with a function"),
]


@pytest.mark.parametrize(("call", "message"), REFUSALS, ids=[message for _, message in REFUSALS])
def test_what_cannot_be_swept_is_named_before_anything_runs(call: Callable[[], object], message: str) -> None:
    with pytest.raises(narx.ParameterError) as caught:
        call()
    assert str(caught.value).startswith(message)


def test_a_motor_that_is_missing_is_named() -> None:
    swept = narx.sweep({"resistance": [0.3], "rpm": 1000})
    assert '"motor" is missing' in swept["error"][0] and "pole_pairs" in swept["error"][0]


def test_messages_in_flight_are_bounded() -> None:
    with Backwards() as backwards:
        swept = narx.sweep(lambda variant: variant.index, backwards, samples=2000, grid={}, chunk=2)
        assert swept["result"].tolist() == list(range(2000))
        assert backwards.submitted == 1000 and 100 < backwards.most <= 256
    with Backwards() as backwards:
        narx.sweep(lambda variant: variant.index, backwards, samples=10_000, grid={})
        assert backwards.submitted == 250


def test_a_pool_that_breaks_down_is_told(processes: Executor) -> None:
    # A local function cannot be pickled.
    unpicklable = narx.sweep(lambda variant: 1, processes, grid={"rpm": [1, 2]})
    assert set(unpicklable["outcome"]) == {"error"} and "ickl" in unpicklable["error"][0]
    with ProcessPoolExecutor(1) as pool:
        dead = narx.sweep(die, pool, grid={"rpm": [1, 2, 3]}, chunk=1)
    assert len(dead.failures) == 3 and all("Broken" in error for error in dead["error"])


def die(variant: narx.Variant) -> None:
    """Ends its process at once."""
    import os

    os._exit(1)


@pytest.mark.parametrize("outside", [False, True])
def test_ctrl_c_keeps_what_has_ended(outside: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    module = sys.modules["narx.sweep"]
    monkeypatch.setattr(module, "bar", interrupting)
    grid = BENCH | {"rpm": 1000, "seconds": [0.02] * 4 + [30.0] * 40}
    with ThreadPoolExecutor(1) as pool, pytest.raises(KeyboardInterrupt) as caught:
        narx.sweep(grid, pool if outside else None, chunk=1)
    assert isinstance(caught.value, narx.SweepInterrupted)
    partial = caught.value.sweep
    assert partial.interrupted and 3 <= len(partial) <= 4 and set(partial["outcome"]) == {"running"}
    # Which of the four short variants have ended depends on the machine.
    ended = int(partial["variant"][0])
    assert f"{narx.replay(partial.replay(ended).recording()).digest:016x}" == partial["digest"][0]


class interrupting:
    """A progress bar that raises KeyboardInterrupt at its third step."""

    def __init__(self, *_: object) -> None:
        self._left = 3

    def __enter__(self) -> Callable[[float], None]:
        return self.step

    def step(self, _: float) -> None:
        self._left -= 1
        if self._left == 0:
            raise KeyboardInterrupt

    def __exit__(self, *_: object) -> None:
        pass


def test_other_threads_run_while_a_sweep_does() -> None:
    over, counts = threading.Event(), 0

    def count() -> None:
        nonlocal counts
        while not over.wait(0.0005):
            counts += 1

    thread = threading.Thread(target=count)
    thread.start()
    try:
        narx.sweep(BENCH | {"rpm": 1000, "seconds": 5.0}, samples=4)
    finally:
        over.set()
        thread.join()
    assert counts >= 20


def test_tables_are_saved_and_read_back(inside: narx.Sweep, tmp_path: Path) -> None:
    for name, read in (("sweep.csv", pd.read_csv), ("sweep.parquet", pd.read_parquet), ("sweep.xlsx", pd.read_excel)):
        inside.save(tmp_path / name)
        back = read(tmp_path / name)
        assert list(back.columns) == list(inside) and back["seed"].tolist() == inside["seed"].tolist(), name
        assert np.allclose(back["speed"], inside["speed"]), name
    with pytest.raises(narx.ParameterError, match='".narxrec" must be one of .csv, .parquet, .xlsx$'):
        inside.save(tmp_path / "sweep.narxrec")


def test_columns_are_named(inside: narx.Sweep) -> None:
    assert inside["rpm"].dtype == np.int64 and inside["speed"].dtype == np.float64
    assert inside.units["peak_current"] == "A" and inside.units["Phase current limit"] == "A" and "rpm" in inside
    with pytest.raises(narx.SignalError, match='no column "sped"; did you mean "speed"'):
        inside["sped"]
    fast = inside.where(inside["rpm"] == 2000)
    assert fast["variant"].tolist() == [4, 5, 6, 7]
    assert repr(fast).startswith("<narx.Sweep of 4 variants, 0 failed: variant, seed, motor")
    assert pickle.loads(pickle.dumps(fast))["digest"].tolist() == fast["digest"].tolist()


def test_pandas_and_tqdm_are_extras() -> None:
    """A sweep runs in a Python without pandas and tqdm."""
    import subprocess

    program = (
        "import sys; sys.modules.update({'pandas': None, 'tqdm': None, 'tqdm.auto': None}); import narx\n"
        f"print(narx.sweep({BENCH | {'rpm': 1000, 'seconds': 0.01}!r})['outcome'][0])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.stdout.strip() == "running", done.stderr


@pytest.mark.skipif(importlib.util.find_spec("tqdm") is None, reason="needs tqdm")
def test_a_bar_shows_progress(capsys: pytest.CaptureFixture[str]) -> None:
    narx.sweep(lambda _: None, grid={}, samples=7, progress=True)
    assert "7/7" in capsys.readouterr().err
    narx.sweep(lambda _: None, grid={}, samples=7, progress=False)
    narx.sweep(lambda _: None, grid={}, samples=7)
    assert capsys.readouterr().err == ""
