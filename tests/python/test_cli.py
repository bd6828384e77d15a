"""The command `narx` on a virtual drive."""

import csv
import json
import os
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import can
import pytest
from signing import image as signed

import narx

VIRTUAL = ["-i", "narx", "-c", "cli", "-o", "motor=ec45-flat-50w-18v", "-o", "supply_voltage=18", "-o", "mode=hall"]
VECTORS = Path(__file__).parents[1] / "vectors"
SWEEP = ["--motor", "ec45-flat-50w-18v", "--mode", "hall", "--supply", "18", "--set", "seconds=0.2"]


def run(*arguments: str, virtual: bool = True) -> subprocess.CompletedProcess[str]:
    """Runs the command as a shell does."""
    command = [sys.executable, "-c", "import narx.cli; narx.cli.main()", *(VIRTUAL if virtual else []), *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


@pytest.mark.parametrize("argument", ["--load=٣", "--set=rpm=٣", "٣", "--set=rpm=١:٣:2"])
def test_digits_of_other_scripts_are_refused(argument: str) -> None:
    shown = run("sweep", "--motor", "ec45-flat-50w-18v", argument, virtual=False)
    assert shown.returncode == 2 and shown.stdout == ""
    assert f"{argument}: must have digits 0 to 9" in shown.stderr or "FIRST:LAST:COUNT must be numbers" in shown.stderr


def test_help_names_every_command() -> None:
    shown = run("--help", virtual=False)
    assert shown.returncode == 0
    for command in ("bench", "devices", "monitor", "info", "params", "scope", "log", "decode", "replay", "sweep", "update", "start", "stop", "calibrate-hall", "identify", "commission", "reboot", "coefficients", "serve"):
        assert command in shown.stdout
    assert "Exit codes: 0 done; 1 done, with a difference" in " ".join(shown.stdout.split())


@pytest.mark.parametrize(
    "command",
    ["bench", "devices", "monitor", "info", "params get", "params load", "scope", "log download", "replay", "sweep", "update", "start", "stop", "calibrate-hall", "identify", "commission", "reboot", "coefficients", "serve"],
)
def test_help_has_examples(command: str) -> None:
    shown = run(*command.split(), "--help", virtual=False)
    text = " ".join(shown.stdout.split())
    assert "Examples narx " in text and f"{command.split()[0]}" in text.split("Examples")[1]


def test_a_drive_is_commissioned_for_a_motor(tmp_path: Path) -> None:
    file, motor = tmp_path / "drive.json", narx.Motor.preset("bly172s-24v")
    shown = run("commission", "bly172s-24v", "--supply", "24", "--to", str(file), virtual=False)
    computed = {name: value for name, value in motor.commission(24).items() if name in narx.COMMISSIONED}
    assert shown.returncode == 0 and json.loads(file.read_text()) == computed
    shown = run("commission", "bly172s-24v", "--supply", "24", "--speed-min", "1000", "--bandwidth", "5", "--to", str(file), virtual=False)
    assert "speed loop: 5.0 Hz, phase margin" in shown.stderr
    assert json.loads(file.read_text()) == computed | motor.speed_loop(1000, 5).parameters
    # The virtual drive is commissioned for another motor.
    shown = run("commission", "bly172s-24v", "--supply", "24", "--mode", "hall")
    assert shown.returncode == 0 and shown.stdout.endswith(" parameters changed\n") and not shown.stdout.startswith("0 ")
    for arguments, message in [
        (["--bandwidth", "5"], "needs --speed-min"),
        (["--to", str(file), "--store"], "--to needs none"),
        (["--speed-min", "1000", "--bandwidth", "500"], "bandwidth 500 Hz"),
    ]:
        shown = run("commission", "bly172s-24v", "--supply", "24", *arguments)
        assert shown.returncode == 2 and message in shown.stderr


def test_coefficients_are_a_header_for_c(tmp_path: Path) -> None:
    example = (VECTORS.parents[1] / "ffi/examples/coefficients.h").read_text()
    shown = run("coefficients", "--motor", "bly172s-24v", "--mode", "hall", virtual=False)
    assert shown.stdout == example
    # A parameter file gives the same header. Another board has other scales.
    file, board = tmp_path / "drive.json", tmp_path / "board.toml"
    file.write_text(json.dumps(narx.Motor.preset("bly172s-24v").commission(24, "hall")))
    assert run("coefficients", str(file), virtual=False).stdout == example
    board.write_text("tick_rate = 20000\n[bus_current]\nzero = 100\nmicro_per_code = 500\n")
    other = run("coefficients", str(file), "--board", str(board), "--name", "pump", virtual=False).stdout
    assert "narx_coefficients_t pump = {" in other and ".ticks_per_ms = 5120," in other and other.count(".gain = 83885006") == 3 and example.count(".gain = 34359738") == 1
    for argument, message in [
        ("--name=2nd", 'name "2nd": is not a name in C'),
        (f"--board={file}", f'file "{file}": '),
        ("--supply=24", "--supply: belongs to a preset"),
    ]:
        wrong = run("coefficients", str(file), argument, virtual=False)
        assert wrong.returncode == 2 and message in wrong.stderr and wrong.stdout == ""
    with pytest.raises(narx.ParameterError, match='board: has no "rate"'):
        narx.coefficients({}, {"rate": 1})
    refused: list[tuple[dict[str, Any], str]] = [
        ({"tick_rate": 1}, "tick_rate 1: must be a whole number from 1000 to 100000"),
        ({"equipment": 128}, "equipment 128: must be a whole number from 0 to 127"),
        ({"hall_capture": 2}, "hall_capture 2: must be true or false"),
        ({"bus_current": {"zero": 4096, "micro_per_code": 1}}, "bus_current.zero 4096: must be a whole number from 0 to 4095"),
        ({"bus_current": {"zero": 0}}, "must have zero and micro_per_code"),
    ]
    for mine, told in refused:
        with pytest.raises(narx.ParameterError, match=told):
            narx.coefficients({}, mine)
    with pytest.raises(narx.ParameterError, match="does not fit the other parameters"):
        narx.coefficients({"Under-voltage HV threshold": 60.0})
    with pytest.raises(narx.ParameterError, match="there is no parameter"):
        narx.coefficients({"nonsense": 1.0})


def test_info_and_monitor_speak_json() -> None:
    info = json.loads(run("info", "--json").stdout)
    assert info["address"] == 170
    seen = json.loads(run("monitor", "--seconds", "1.5", "--json").stdout)
    assert seen["state"] == "standby" and seen["faults"] == []
    assert seen["measurements"]["HV Voltage"] == pytest.approx(18.0, abs=0.1)


def test_parameters(tmp_path: Path) -> None:
    assert run("params", "get", "78", "nominal supply voltage").stdout.splitlines() == [
        "78 Motor pair poles: 8", "266 Nominal supply voltage: 18 V",
    ]  # fmt: skip
    file = tmp_path / "drive.json"
    assert run("params", "dump", str(file)).returncode == 0
    values = json.loads(file.read_text())
    assert run("params", "diff", str(file)).returncode == 0
    file.write_text(json.dumps(values | {"Winding resistance": 1.5}))
    differs = run("params", "diff", "--json", str(file))
    assert differs.returncode == 1
    assert json.loads(differs.stdout) == {"Winding resistance": [1.5, values["Winding resistance"]]}
    assert run("params", "load", str(file)).stdout.split("\n") == ["Winding resistance", ""]
    assert "Winding resistance" in run("params", "list", "resistance", virtual=False).stdout


def test_a_scope_capture_is_a_file(tmp_path: Path) -> None:
    file = tmp_path / "scope.csv"
    done = run("scope", "HV Voltage", "Duty", "--samples", "100", "--to", str(file))
    assert done.returncode == 0 and done.stdout.startswith("100 samples in")
    lines = file.read_text().splitlines()
    assert lines[0] == "time,HV Voltage,Duty" and len(lines) == 101


def test_a_scope_records_what_replays(tmp_path: Path) -> None:
    file = tmp_path / "now.narxrec"
    done = run("scope", "--samples", "200", "--before", "50", "--to", str(file), "--json")
    assert done.returncode == 0 and json.loads(done.stdout)["samples"] >= 200
    assert narx.replay(file).identical
    assert run("scope").returncode == 2


def test_the_motor_is_started_stopped_and_calibrated() -> None:
    ran = run("start", "1500", "--reverse", "--seconds", "0.2", "--json")
    assert ran.returncode == 0 and json.loads(ran.stdout)["state"] == "hall_closed_loop"
    refused = run("start", "60000")
    assert refused.returncode == 2 and refused.stderr.startswith("narx: ")
    assert run("stop").stdout.startswith("Standby")
    assert json.loads(run("reboot", "--json").stdout)["state"] == "standby"
    assert json.loads(run("calibrate-hall", "--yes", "--json").stdout)["state"] == "standby"


def test_a_recording_is_replayed(tmp_path: Path) -> None:
    vector = VECTORS / "hall-forward.narxrec"
    assert run("replay", str(vector), virtual=False).returncode == 0
    assert f"{narx.replay(vector).digest:016x}: identical" in run("replay", str(vector), virtual=False).stdout
    broken = tmp_path / "broken.narxrec"
    broken.write_bytes(vector.read_bytes()[:1000])
    refused = run("replay", str(broken), virtual=False)
    assert refused.returncode == 2 and refused.stderr.startswith("narx: ")


def test_a_log_is_decoded(tmp_path: Path) -> None:
    file = tmp_path / "bus.log"
    with can.Bus(interface="narx", channel="logged", realtime=False) as bus, can.Logger(file) as logger:
        for _ in range(50):
            frame = bus.recv(1.0)
            assert frame is not None
            logger.on_message_received(frame)
    lines = [json.loads(line) for line in run("decode", "--json", str(file), virtual=False).stdout.splitlines()]
    assert len(lines) == 50 and {line["message"] for line in lines} >= {"STATUS_WORD", "FAULT_WORD"}


def test_a_log_is_summed_up_and_its_errors_are_told(tmp_path: Path) -> None:
    file = tmp_path / "bus.log"
    file.write_text("(1.5) can0 1552A8CA#0708000100020003\n(2.0) can0 1552A8\n(2.5) can0 1552A8CA#0708000000000000\n(3.5) can0 182#00000008\n")
    rows = run("decode", "--csv", str(file), virtual=False)
    assert rows.returncode == 1
    assert rows.stdout.splitlines()[:3] == ["time,message,signal,value,unit", "1.5,MEASUREMENT_2,HV Voltage,18.0,V", "1.5,MEASUREMENT_2,HV Current,0.001,A"]
    assert rows.stdout.splitlines()[-1] == "3.5,PDO1,Position 1,1.0,mm"
    assert rows.stderr == f"narx: {file}:2: no # between identifier and data: (2.0) can0 1552A8\n"
    told = run("decode", str(file), virtual=False)
    assert told.stdout.splitlines()[-1] == "3.500000 <- PDO1: Node 2, Position 1 1.0 mm" and told.returncode == 1
    summary = run("decode", "--summary", str(file), virtual=False)
    assert "4" not in summary.stdout.split("frames")[0] and "MEASUREMENT_2" in summary.stdout and "1.0" in summary.stdout
    counted = json.loads(run("decode", "--summary", "--json", str(file), virtual=False).stdout)
    assert counted == {
        "frames": 3, "messages": {"MEASUREMENT_2": 2, "PDO1": 1}, "unknown": 0, "malformed": 0, "error frames": 0, "errors": 1,
    }  # fmt: skip
    file.write_text("(1.5) can0 1552A8CA#0708000100020003\n")
    assert run("decode", str(file), virtual=False).returncode == 0


REFUSED = [
    (["params", "get", "motor pair pole"], 'narx: there is no parameter "motor pair pole"; did you mean'),
    (["params", "set", "78", "99"], 'narx: parameter 78 "Motor pair poles": 99 is outside 1 to 50'),
    (["params", "set", "78", "2.5"], 'narx: parameter 78 "Motor pair poles": 2.5 is not a whole number from 1 to 50'),
    (["params", "set", "78", "nan"], 'narx: parameter 78 "Motor pair poles": NaN is outside 1 to 50'),
    (["params", "set", "78", "٨"], "narx: ٨: must have digits 0 to 9"),
    (["params", "set", "٧٨", "8"], "narx: ٧٨: must have digits 0 to 9"),
    (["scope", "Duti"], 'narx: there is no scope signal "Duti"; did you mean "Duty"'),
    (["scope", "Duty", "--trigger", "sometimes"], "must be now, fault, state"),
    (["start", "1500", "--seconds", "nan"], "narx: seconds NaN s: must be a finite number, 0 or more"),
    (["monitor", "--seconds", "-1"], "narx: seconds -1 s: must be a finite number, 0 or more"),
    (["params", "diff", __file__], "is not a parameter file: "),
    (["decode", "/nowhere.log"], "narx: "),
    (["bench", "--tcp", "nowhere"], "narx: tcp 127.0.0.1:nowhere: must be a port, or HOST:PORT"),
    (["bench", "--tcp", "0", "--speed", "1000"], "narx: speed 1000: must be a number from 0.01 to 100"),
    (["bench", "--tx-drivers", "2,2"], "narx: tx_drivers 2,2: must be different node-ids from 1 to 127"),
    (["bench", "--link", "x"], "x: needs --pty"),
    (["sweep", "--set", "resistence=1"], 'narx: there is no "resistence" to vary; did you mean "resistance"'),
    (["sweep", "--set", "rpm=1:2:1000000000"], "rpm=1:2:1000000000: COUNT must be from 1 to"),
    (["sweep", "--set", "rpm"], "rpm: must be NAME=VALUE,VALUE"),
    (["sweep", "grid.yaml"], '".yaml" must be .toml or .json'),
    (["sweep", *SWEEP, "--to", "table.txt"], '".txt" must be one of .csv, .parquet, .xlsx'),
    (["sweep", *SWEEP, "--replay", "1"], "1: must be from 0 to 0"),
]


@pytest.mark.parametrize(("arguments", "message"), REFUSED, ids=[" ".join(arguments) for arguments, _ in REFUSED])
def test_an_error_is_one_line_and_exit_code_2(arguments: list[str], message: str) -> None:
    refused = run(*arguments)
    assert refused.returncode == 2 and message in " ".join(refused.stderr.split()), refused.stderr
    assert "Traceback" not in refused.stderr


UNOPENED = [
    (["-i", "bogus"], 'narx: there is no interface "bogus"; there are '),
    (["-i", "slcam"], 'narx: there is no interface "slcam"; did you mean "slcan"'),
    (["-i", "kvaser", "-c", "0"], 'narx: interface "kvaser", channel 0: '),
    (["-i", "slcan", "-c", "/nowhere"], 'narx: interface "slcan", channel /nowhere: '),
    (["-i", "narx", "-c", "unopened", "-o", "moter=1"], 'narx: interface "narx", channel unopened: there is no option "moter"'),
    (["-i", "narx", "-c", "unopened", "-o", "supply_voltage=12"], "narx: supply voltage 12 V is outside 18 to 60 V"),
]


@pytest.mark.parametrize(("arguments", "message"), UNOPENED, ids=[" ".join(arguments) for arguments, _ in UNOPENED])
def test_an_adapter_that_cannot_be_opened_is_told_in_one_line(arguments: list[str], message: str) -> None:
    told = run(*arguments, "info", virtual=False)
    # Drivers of python-can may print warnings of their own before.
    assert told.returncode == 2 and told.stderr.splitlines()[-1].startswith(message), told.stderr
    assert "Traceback" not in told.stderr


def test_a_serial_adapter_without_pyserial_names_its_extra() -> None:
    program = "import sys; sys.modules['serial'] = None; import narx.cli; narx.cli.main()"
    command = [sys.executable, "-c", program, "-i", "slcan", "-c", "/nowhere", "info"]
    told = subprocess.run(command, capture_output=True, text=True, check=False)
    assert told.returncode == 2 and "it needs pyserial: pip install 'narx[can]'" in told.stderr


@pytest.mark.parametrize("command", [["decode"], ["decode", "--json"], ["decode", "--csv"]])
def test_a_reader_that_has_enough_is_no_failure(command: list[str], tmp_path: Path) -> None:
    file = tmp_path / "long.log"
    file.write_text("(1.5) can0 1552A8CA#0708000100020003\n" * 20_000)
    program = [sys.executable, "-c", "import narx.cli; narx.cli.main()", *command, str(file)]
    with subprocess.Popen(program, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None and process.stderr is not None
        assert process.stdout.readline()
        process.stdout.close()
        assert process.wait(30) == 0 and process.stderr.read() == ""


def test_a_log_is_read_from_the_standard_input() -> None:
    command = [sys.executable, "-c", "import narx.cli; narx.cli.main()", "decode", "-"]
    text = "(3.5) can0 182#00000008\n(0.5) can0 182#00000008\nno frame\n"
    told = subprocess.run(command, input=text, capture_output=True, text=True, check=False)
    assert told.stdout == "3.500000 <- PDO1: Node 2, Position 1 1.0 mm\n0.500000 <- PDO1: Node 2, Position 1 1.0 mm\n"
    assert told.stderr.startswith('narx: the clock of "-" jumps back once: `laps` has each part\nnarx: -:3: ') and told.returncode == 1


def test_the_version_is_printed() -> None:
    assert run("--version", virtual=False).stdout == f"narx {narx.__version__}\n"


class Served:
    """`narx bench` as a process, and the addresses at which it can be reached."""

    def __init__(self, *arguments: str) -> None:
        command = [
            sys.executable,
            "-c",
            "import narx.cli; narx.cli.main()",
            "bench",
            "--mode",
            "hall",
            "--tcp",
            "0",
            "--json",
        ]
        self.process = subprocess.Popen(
            [*command, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        assert self.process.stdout is not None
        self.doors = json.loads(self.process.stdout.readline())

    def __enter__(self) -> "Served":
        return self

    def __exit__(self, *_: object) -> None:
        self.process.kill()
        self.process.communicate()


def test_bench_serves_unmodified_tools(tmp_path: Path) -> None:
    link = tmp_path / "narx"
    with Served("--tx-drivers", "2,5:dual", "--pty", "--link", str(link)) as served:
        assert served.doors["pty"] == str(link) and link.is_symlink()
        assert [note.split(", eddyCAN")[0] for note in served.doors["notes"][-2:]] == [
            "TX-Driver: node-id 2, 1 channel of 2 mm, encoder on the shaft",
            "TX-Driver: node-id 5, 2 channels of 2 mm, encoder on the shaft",
        ]
        options: dict[str, Any] = {"sleep_after_open": 0.0}
        with (
            can.Bus(interface="slcan", channel=str(link), bitrate=500_000, **options) as other,
            narx.connect("slcan", served.doors["tcp"], **options) as drive,
        ):
            drive.start(2000)
            assert drive.state is narx.State.HALL_CLOSED_LOOP
            # The client on the pseudo-terminal receives the same traffic.
            frames = (other.recv(1.0) for _ in range(5000))
            messages = (narx.decode(frame) for frame in frames if frame is not None)
            assert any(message is not None and message.name == "STATUS_WORD" for message in messages)
        served.process.send_signal(signal.SIGTERM)
        assert served.process.wait(10) == 0 and not link.is_symlink()


def test_bench_ends_by_time_and_by_ctrl_c() -> None:
    with Served("--seconds", "0.2", "--speed", "0") as served:
        assert served.process.wait(10) == 0
    with Served("--verbose") as served:
        served.process.send_signal(signal.SIGINT)
        assert served.process.wait(10) == 0


def test_sweep_is_a_table_and_a_variant_runs_again(tmp_path: Path) -> None:
    table, recording = tmp_path / "sweep.csv", tmp_path / "again.narxrec"
    arguments = ["sweep", *SWEEP, "--set", "rpm=1000:2000:3", "--set", "Phase current limit=3,6", "--samples", "2"]
    done = run(*arguments, "--to", str(table), virtual=False)
    assert done.returncode == 0 and done.stdout.startswith("12 variants: 12 running; in"), done.stderr
    rows = list(csv.DictReader(table.open()))
    assert [float(row["rpm"]) for row in rows[::4]] == [1000, 1500, 2000]
    lines = [json.loads(line) for line in run(*arguments, "--json", virtual=False).stdout.splitlines()]
    assert [line["digest"] for line in lines] == [row["digest"] for row in rows]
    again = run(*arguments, "--replay", "7", "--to", str(recording), virtual=False)
    assert again.returncode == 0 and rows[7]["digest"] in again.stdout
    assert f"{narx.replay(recording).digest:016x}" == rows[7]["digest"]


@pytest.mark.parametrize("form", ["toml", "json", "json list"])
def test_a_grid_is_a_file(form: str, tmp_path: Path) -> None:
    file = tmp_path / f"grid.{form.split()[0]}"
    file.write_text({
        "toml": 'motor = "bly172s-24v"\nsupply_voltage = [24.0, 61.0]\nseconds = 0.1\nmode = "hall"\n',
        "json": '{"motor": "bly172s-24v", "supply_voltage": [24.0, 61.0], "seconds": 0.1, "mode": "hall"}',
        "json list": '[{"motor": "bly172s-24v", "supply_voltage": 24}, {"motor": "bly172s-24v", "supply_voltage": 61}]',
    }[form])  # fmt: skip
    options = ["--mode", "hall", "--set", "seconds=0.1"] if "list" in form else []
    done = run("sweep", str(file), *options, virtual=False)
    assert done.returncode == 1 and done.stdout == "2 variants: 1 error, 1 running\n"
    assert "supply voltage 61 V" in " ".join(done.stderr.split())


def test_ctrl_c_ends_a_sweep_with_what_it_has(tmp_path: Path) -> None:
    table = tmp_path / "partial.csv"
    command = [
        sys.executable,
        "-c",
        "import narx.cli; narx.cli.main()",
        "sweep",
        *SWEEP,
        "--set",
        "rpm=1000",
        "--to",
        str(table),
    ]
    # The first variants are short; the others would take hours.
    command += ["--set", "seconds=0.01,0.01,36000,36000,36000"]
    # A shell starts a background process with SIGINT ignored, and its children inherit that.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    finally:
        signal.signal(signal.SIGINT, before)
    with process:
        try:
            wait_for_work(process)
            process.send_signal(signal.SIGINT)
            shown, _ = process.communicate(timeout=20)
        finally:
            process.kill()
    assert process.returncode == 130 and "variants: 2 running" in shown
    assert len(table.read_text().splitlines()) == 3


def wait_for_work(process: "subprocess.Popen[str]") -> None:
    """Waits until the threads of a process have worked for a while."""
    stat = Path(f"/proc/{process.pid}/stat")
    threads = Path(f"/proc/{process.pid}/task")
    while len(list(threads.iterdir())) < 3:
        assert process.poll() is None
        time.sleep(0.05)
    begun = int(stat.read_text().split()[13])
    while int(stat.read_text().split()[13]) < begun + 60:
        time.sleep(0.05)


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("narx sw", "sweep"),
        ("narx bench --motor ec90", "ec90-flat-90w-24v"),
        ("narx params get Motor\\ pair", "Motor pair poles"),
    ],
)
def test_the_shell_completes(typed: str, offered: str) -> None:
    environment = os.environ | {
        "_NARX_COMPLETE": "complete_bash", "COMP_WORDS": typed, "COMP_CWORD": str(len(shlex.split(typed)) - 1),
    }  # fmt: skip
    command = [sys.executable, "-c", "import narx.cli; narx.cli.main()"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.stdout.splitlines() == [offered], done.stderr


def test_the_shells_get_their_script() -> None:
    command = [sys.executable, "-c", "import narx.cli; narx.cli.main()", "--show-completion"]
    environment = os.environ | {"_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1"}
    for shell in ("bash", "zsh", "fish"):
        done = subprocess.run([*command, shell], env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0 and "_NARX_COMPLETE" in done.stdout, done.stderr


def test_replay_and_list_speak_json() -> None:
    vector = VECTORS / "hall-forward.narxrec"
    assert json.loads(run("replay", str(vector), "--json", virtual=False).stdout) == {
        "ticks": narx.replay(vector).ticks, "digest": f"{narx.replay(vector).digest:016x}", "identical": True,
    }  # fmt: skip
    rows = json.loads(run("params", "list", "pair poles", "--json", virtual=False).stdout)
    assert [(row["number"], row["name"], row["max"]) for row in rows] == [(78, "Motor pair poles", 50)]


def test_an_update_of_nobody_names_the_bus(tmp_path: Path) -> None:
    """Neither a drive nor a bootloader answers: the message is that of any command."""
    image = tmp_path / "drive.narximg"
    image.write_bytes(signed((0, 3, 1, 99), bytes(1024)))
    options = ["-i", "virtual", "-c", "nobody"]
    told = [run(*options, *words, virtual=False) for words in (["info"], ["update", str(image)])]
    assert told[0].returncode == told[1].returncode != 0
    assert "no frame of drive 170 was received on virtual nobody" in told[1].stderr.replace("\n", " ")
