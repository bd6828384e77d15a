"""The command `narx` on a virtual drive."""

import json
import subprocess
import sys
from pathlib import Path

import can
import pytest

import narx

VIRTUAL = ["-i", "narx", "-c", "cli", "-o", "motor=ec45-flat-50w-18v", "-o", "supply_voltage=18", "-o", "mode=hall"]
VECTORS = Path(__file__).parents[1] / "vectors"


def run(*arguments: str, virtual: bool = True) -> subprocess.CompletedProcess[str]:
    """The command as a shell runs it."""
    command = [sys.executable, "-c", "import narx.cli; narx.cli.main()", *(VIRTUAL if virtual else []), *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


def test_help_names_every_command() -> None:
    shown = run("--help", virtual=False)
    assert shown.returncode == 0
    for command in ("devices", "monitor", "info", "params", "scope", "log", "decode", "replay"):
        assert command in shown.stdout


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
    (["scope", "Duti"], 'narx: there is no scope signal "Duti"; did you mean "Duty"'),
    (["scope", "Duty", "--trigger", "sometimes"], "must be now, fault, state"),
    (["decode", "/nowhere.log"], "narx: "),
]


@pytest.mark.parametrize(("arguments", "message"), REFUSED, ids=[" ".join(arguments) for arguments, _ in REFUSED])
def test_an_error_is_one_line_and_exit_code_2(arguments: list[str], message: str) -> None:
    refused = run(*arguments)
    assert refused.returncode == 2 and message in " ".join(refused.stderr.split()), refused.stderr
    assert "Traceback" not in refused.stderr
