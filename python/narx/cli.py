"""The command `narx`: what the package does, from a shell."""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.live import Live
from rich.progress import Progress
from rich.table import Table

import narx
from narx.drive import name_of

app = typer.Typer(no_args_is_help=True, rich_markup_mode="markdown", pretty_exceptions_enable=False, help=__doc__)
params = typer.Typer(no_args_is_help=True, help="Parameters of a drive: get, set, dump, load and compare.")
log = typer.Typer(no_args_is_help=True, help="The external log memory of a drive.")
app.add_typer(params, name="params")
app.add_typer(log, name="log")

out, err = Console(), Console(stderr=True)

JSON = typer.Option("--json", help="Print JSON for other programs.")


class Connection:
    """The drive that commands talk to: options that stand before the command."""

    interface = "socketcan"
    channel = "can0"
    bitrate = 500_000
    slave = 170
    monitor = 85
    silent = False
    options: dict[str, Any] = {}  # noqa: RUF012


@app.callback()
def connection(
    interface: Annotated[str, typer.Option("-i", "--interface", help="Interface of python-can.")] = "socketcan",
    channel: Annotated[str, typer.Option("-c", "--channel", help="Its channel.")] = "can0",
    bitrate: Annotated[int, typer.Option(help="Bit rate of the bus.")] = 500_000,
    slave: Annotated[int, typer.Option(help="Address of the drive.")] = 170,
    monitor: Annotated[int, typer.Option(help="Address of this master.")] = 85,
    silent: Annotated[bool, typer.Option("--silent", help="Transmit nothing.")] = False,
    option: Annotated[list[str] | None, typer.Option("-o", "--option", help="Further NAME=VALUE of the interface.")] = None,
) -> None:
    """Operates narx drives, on any adapter that python-can knows.

    The virtual drive needs no adapter: `narx -i narx -c demo -o motor=ec45-flat-50w-18v -o supply_voltage=18 -o mode=hall monitor`
    """
    Connection.interface, Connection.channel, Connection.bitrate = interface, channel, bitrate
    Connection.slave, Connection.monitor, Connection.silent = slave, monitor, silent
    Connection.options = dict(parsed(text) for text in option or [])


def parsed(text: str) -> tuple[str, Any]:
    """NAME=VALUE, the value a number where it looks like one."""
    name, found, value = text.partition("=")
    if not found:
        raise typer.BadParameter(f"{text}: must be NAME=VALUE", param_hint="--option")
    try:
        return name, json.loads(value)
    except ValueError:
        return name, value


@contextmanager
def connected() -> Iterator[narx.Drive]:
    """The drive. It is left as it is: a motor that somebody else turns goes on turning."""
    c = Connection
    drive = narx.connect(
        c.interface, c.channel, c.slave, c.monitor, c.bitrate, silent=c.silent, read_parameters=False, **c.options
    )
    try:
        yield drive
    finally:
        drive.close(stop=False)


@app.command()
def devices(as_json: Annotated[bool, JSON] = False) -> None:
    """Lists the adapters that python-can finds."""
    found = narx.devices()
    if as_json:
        print(json.dumps(found, default=str))
        return
    for device in found:
        out.print(" ".join(f"{name}={value}" for name, value in device.items()))


@app.command()
def monitor(
    seconds: Annotated[float | None, typer.Option(help="Ends after so long; else at Ctrl-C.")] = None,
    as_json: Annotated[bool, JSON] = False,
) -> None:
    """Shows state, faults and measurements, live."""
    with connected() as drive:
        if as_json:
            drive.wait(1.0 if seconds is None else seconds)
            print(json.dumps(snapshot(drive)))
            return
        end = float("inf") if seconds is None else drive._link.now + seconds
        with Live(console=out, refresh_per_second=10) as live:
            while drive._link.now < end:
                drive.wait(0.1)
                live.update(table_of(drive))


def snapshot(drive: narx.Drive) -> dict[str, Any]:
    """What is known of a drive."""
    return {
        "state": None if drive.state is None else drive.state.name.lower(),
        "faults": sorted(drive.faults),
        "status": drive.status,
        "speed": drive.measurements.speed,
        "measurements": dict(drive.measurements),
    }


def table_of(drive: narx.Drive) -> Table:
    """The same for people."""
    table = Table(title=name_of(drive.state) + (f": {', '.join(sorted(drive.faults))}" if drive.faults else ""))
    table.add_column("measurement")
    table.add_column("value", justify="right")
    table.add_column("unit")
    measurements = drive.measurements
    for name in measurements:
        known = measurements.full(name)
        table.add_row(name, f"{known.value:g}", known.unit)
    return table


@app.command()
def info(as_json: Annotated[bool, JSON] = False) -> None:
    """Says what the drive is: releases, serial number, address."""
    with connected() as drive:
        found = vars(drive.info)
    if as_json:
        print(json.dumps(found))
        return
    for name, value in found.items():
        out.print(f"{name.replace('_', ' ')}: {value}")


@params.command("get")
def params_get(names: list[str], as_json: Annotated[bool, JSON] = False) -> None:
    """Reads parameters by name or number."""
    with connected() as drive:
        rows = [drive.parameters.row(key(name)) for name in names]
        values = {row.name: drive.parameters[row.number] for row in rows}
    if as_json:
        print(json.dumps(values))
        return
    for row in rows:
        out.print(f"{row.number} {row.name}: {values[row.name]:g} {row.unit}".rstrip(), highlight=False)


@params.command("set")
def params_set(name: str, value: float, store: Annotated[bool, typer.Option("--store")] = False) -> None:
    """Writes a parameter; with --store the drive keeps it."""
    with connected() as drive:
        drive.parameters[key(name)] = value
        if store:
            drive.parameters.store()


@params.command("list")
def params_list(text: Annotated[str, typer.Argument(help="Part of a name, category or description.")] = "") -> None:
    """Lists what there is, without a drive."""
    table = Table("number", "name", "unit", "range", "factory", "access")
    folded = text.casefold()
    for row in narx.Parameters.rows.values():
        if folded in f"{row.name} {row.category} {row.description}".casefold():
            table.add_row(
                str(row.number), row.name, row.unit, f"{row.min:g} to {row.max:g}", f"{row.factory:g}", row.access
            )
    out.print(table)


@params.command("dump")
def params_dump(path: Annotated[Path | None, typer.Argument(help="JSON file; else it is printed.")] = None) -> None:
    """Reads everything that configures the drive."""
    with connected() as drive:
        if path is not None:
            drive.parameters.save(path)
            return
        print(json.dumps(drive.parameters.to_dict(), indent=2, ensure_ascii=False))


@params.command("load")
def params_load(path: Path, store: Annotated[bool, typer.Option("--store")] = False) -> None:
    """Writes what differs from a file of `dump`; everything is checked first."""
    with connected() as drive:
        for name in drive.parameters.load_file(path):
            out.print(name, highlight=False)
        if store:
            drive.parameters.store()


@params.command("diff")
def params_diff(path: Path, as_json: Annotated[bool, JSON] = False) -> None:
    """Compares the drive with a file of `dump`; exit code 1 when they differ."""
    with connected() as drive:
        found = drive.parameters.diff(json.loads(path.read_text(encoding="utf-8")))
    if as_json:
        print(json.dumps(found))
    else:
        for name, (there, here) in found.items():
            out.print(f"{name}: {there:g} in the file, {here:g} on the drive", highlight=False)
    raise typer.Exit(1 if found else 0)


@app.command()
def scope(
    signals: list[str],
    to: Annotated[Path, typer.Option(help=".csv, .parquet or .xlsx.")] = Path("scope.csv"),
    samples: int = 256,
    prescaler: int = 1,
    before: Annotated[int, typer.Option(help="Samples from before the trigger.")] = 0,
    trigger: Annotated[
        str, typer.Option(help='now, fault, state, or like "HV Voltage > 20" (<, rising, falling)')
    ] = "now",
    timeout: float = 10.0,
) -> None:
    """Captures signals of the control tick."""
    with connected() as drive:
        chosen = trigger_of(trigger)
        trace = drive.scope.capture(signals, samples, prescaler, chosen, before, timeout)
    trace.save(to)
    out.print(f"{len(trace)} samples in {to}", highlight=False)


def trigger_of(text: str) -> narx.Trigger | None:
    """The trigger that a text means; `None` is now."""
    simple = {"now": None, "fault": narx.Trigger.fault(), "state": narx.Trigger.state_change()}
    if text in simple:
        return simple[text]
    for word, make in (
        (" > ", narx.Trigger.above),
        (" < ", narx.Trigger.below),
        (" rising ", narx.Trigger.rising),
        (" falling ", narx.Trigger.falling),
    ):
        signal, found, value = text.partition(word)
        if found:
            try:
                return make(signal, float(value))
            except ValueError:
                break
    raise typer.BadParameter(f'"{text}": must be now, fault, state, or like "HV Voltage > 20"', param_hint="--trigger")


@log.command("show")
def log_show(as_json: Annotated[bool, JSON] = False) -> None:
    """Says what is logged, and how full the memory is."""
    with connected() as drive:
        found = {"records": len(drive.log), "capacity": drive.log.capacity, "values": drive.log.slots}
    if as_json:
        print(json.dumps(found))
        return
    out.print(f"{found['records']} of {found['capacity']} records", highlight=False)
    for name, kind in found["values"].items():  # type: ignore[attr-defined]
        out.print(f"  {name}: {kind}", highlight=False)


@log.command("download")
def log_download(to: Path, first: int = 0, count: int | None = None) -> None:
    """Saves records as .csv, .parquet or .xlsx."""
    with connected() as drive, Progress(console=err) as bar:
        task = bar.add_task("download", total=None)
        trace = drive.log.download(
            first, count, lambda received, total: bar.update(task, completed=received, total=total)
        )
    trace.save(to)
    out.print(f"{len(trace)} records in {to}", highlight=False)


@log.command("erase")
def log_erase(yes: Annotated[bool, typer.Option("--yes", help="Do not ask.")] = False) -> None:
    """Erases every record."""
    if not yes:
        typer.confirm("Erase every record of the log?", abort=True)
    with connected() as drive:
        drive.log.erase()


@app.command()
def decode(
    path: Path,
    as_json: Annotated[bool, JSON] = False,
    as_csv: Annotated[bool, typer.Option("--csv", help="Print a row for each value: time, message, signal, value, unit.")] = False,
    summary: Annotated[bool, typer.Option("--summary", help="Print a table of the messages alone.")] = False,
    encoder: Annotated[
        list[int] | None, typer.Option(help="Node-id of a TX-Driver of two channels whose PDOs have the encoder in them.")
    ] = None,
) -> None:
    """Decodes a log of CAN frames (candump, ASC, BLF, CSV, ...), a line for each message. What is no frame goes to the error output with its
    line; exit code 1 then."""
    found = narx.read_log(path, slave=None, monitor=None, encoders=encoder or ())
    if summary:
        print(json.dumps(summary_of(found))) if as_json else out.print(table_of_log(found))
    elif as_csv:
        rows = csv.writer(sys.stdout, lineterminator="\n")
        rows.writerow(["time", "message", "signal", "value", "unit"])
        for time, message in found.messages():
            rows.writerows([time, message.name, name, plain(value), message.units[name]] for name, value in message.values.items())
    else:
        for time, message in found.messages():
            print(json_line(time, message) if as_json else line(time, message))
    for error in found.errors:
        place = f"{path}:{error.line}" if error.line else str(path)
        err.print(f"narx: {place}: {error.reason}{f': {error.text}' if error.text else ''}", highlight=False, markup=False, soft_wrap=True)
    raise typer.Exit(1 if found.errors else 0)


def json_line(time: float, message: narx.Message | narx.NodeMessage) -> str:
    """A message for other programs."""
    fields = {name: sorted(value) if isinstance(value, frozenset) else value for name, value in message.values.items()}
    return json.dumps({"time": time, "message": message.name, **fields}, ensure_ascii=False)


def line(time: float, message: narx.Message | narx.NodeMessage) -> str:
    """A message for people; the arrow points to the master or from it."""
    from_device = message.from_drive if isinstance(message, narx.Message) else message.from_node
    fields = (f"{name} {plain(value)} {message.units[name]}".rstrip() for name, value in message.values.items())
    return f"{time:.6f} {'<-' if from_device else '->'} {message.name}: {', '.join(fields)}"


def plain(value: Any) -> Any:
    """A set of faults as words."""
    return " ".join(sorted(value)) or "none" if isinstance(value, frozenset) else value


def summary_of(found: narx.CanLog) -> dict[str, Any]:
    """How many frames of what a log has."""
    others = {"unknown": found.unknown, "malformed": found.malformed, "error frames": found.error_frames}
    return {
        "frames": len(found),
        "messages": found.counts,
        **{name: len(frames) for name, frames in others.items()},
        "errors": len(found.errors),
    }


def table_of_log(found: narx.CanLog) -> Table:
    """The same for people, with the rate of each message."""
    table = Table("message", "frames", "per second", title=f"{len(found)} frames, {len(found.errors)} errors")
    for name, count in found.counts.items():
        time = found.table(name).time
        span = time[-1] - time[0]
        table.add_row(name, str(count), f"{(count - 1) / span:.1f}" if span > 0 else "")
    for name in ("unknown", "malformed", "error frames"):
        if count := summary_of(found)[name]:
            table.add_row(name, str(count), "")
    return table


@app.command()
def replay(recording: Path, to: Annotated[Path | None, typer.Option(help="Save what it answered.")] = None) -> None:
    """Runs a drive through a recording; exit code 1 when it does not answer the same bits."""
    run = narx.replay(recording)
    out.print(f"{run.ticks} ticks, digest {run.digest:016x}: {'identical' if run.identical else 'not identical'}")
    if to is not None:
        run.save(to)
    raise typer.Exit(0 if run.identical else 1)


def key(name: str) -> str | int:
    """A parameter's name, or its number."""
    return int(name) if name.isdecimal() else name


def main() -> None:
    """Runs a command; an error of narx is one line and exit code 2."""
    try:
        app()
    except (narx.NarxError, OSError) as error:
        err.print(f"narx: {error}", highlight=False, markup=False)
        sys.exit(2)
    except ImportError as error:
        err.print(f"narx: {error}: pip install 'narx\\[can]'", highlight=False)
        sys.exit(2)
