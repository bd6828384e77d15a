"""A drive, seen from its master: on a bench, or on any bus of python-can."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self
from warnings import warn

from narx import _core, given, table
from narx._core import State
from narx.description import describe
from narx.errors import BusError, NarxError, NarxWarning, NoAnswerError, ParameterError, RefusedError, SignalError, SpeedWarning
from narx.extras import EXTRAS, need
from narx.identification import Identified, identify
from narx.link import BenchLink, BusLink, Link, SteppedLink, ask
from narx.log import Log
from narx.names import suggestion
from narx.parameters import Parameters
from narx.scope import Scope
from narx.update import update

if TYPE_CHECKING:
    import can

JOB_MAX = 90.0
"""Longest wait for a job, s: more than any job takes, which ends by itself."""

STANDBY, DRIVE, REVERSE = 0, 1, 2
SERIAL = ("robotell", "seeedstudio", "serial", "slcan")
"""Interfaces that need pyserial."""
RESTING = (None, State.INITIALIZATION, State.STANDBY)
"""States of a motor that was not started, as far as is known."""


@dataclass(frozen=True)
class Measurement:
    """A value that the drive has sent."""

    value: float
    """Value, in `unit`."""
    unit: str
    """SI unit, rpm, g or °C; "" for plain numbers."""
    time: float
    """Time of reception, s: on a bench its simulated time, else since the connection."""


class Measurements(Mapping[str, float]):
    """Measurements of the drive's broadcasts, by the names of the specification's Figure 14, in their units.
    It contains only those that were received."""

    def __init__(self, signals: list[tuple[str, str, tuple[float, float] | None]], speed: float | None) -> None:
        self._known = {
            name: Measurement(received[0], "" if unit == "-" else unit, received[1])
            for name, unit, received in signals
            if received is not None
        }
        self._names = [name for name, _, _ in signals]
        self.speed = speed
        """Mechanical speed, rpm, from the source that the control mode uses: the hall sensors, the back-EMF,
        or in open loop the field; `None` before it was received."""

    def __getitem__(self, name: str) -> float:
        return self.full(name).value

    def full(self, name: str) -> Measurement:
        """Returns the measurement with its unit and time. Raises SignalError for one that does not exist, or
        was not received yet."""
        folded = {known.casefold(): known for known in self._known}
        wanted = str(name).casefold()
        try:
            return self._known[folded[wanted]]
        except KeyError:
            if wanted in (known.casefold() for known in self._names):
                raise SignalError(f'measurement "{name}" was not received yet') from None
            raise SignalError(f'there is no measurement "{name}"{suggestion(name, self._names)}') from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._known)

    def __len__(self) -> int:
        return len(self._known)

    def _repr_html_(self) -> str:
        known = self._known.values()
        columns: dict[str, list[Any]] = {"value": [one.value for one in known], "unit": [one.unit for one in known], "time [s]": [one.time for one in known]}
        return table.html("narx.Measurements", {"measurement": list(self._known)} | columns, rows=len(known))

    def _ipython_key_completions_(self) -> list[str]:
        return list(self._known)

    def __repr__(self) -> str:
        rows = (f"  {name}: {known.value:g} {known.unit}".rstrip() for name, known in self._known.items())
        return "\n".join(["<narx.Measurements", *rows, ">"])


@dataclass(frozen=True)
class Info:
    """Identity of a drive: BUILD_INFO and DEVICE_INFO."""

    build_number: int
    source_modified: bool
    build_date: int
    """Date of the build, YYYYMMDD."""
    hardware: int
    """Release of the board."""
    software: str
    """Release of the firmware, major.minor."""
    device_number: int
    """Serial number."""
    address: int
    """CAN address."""


class Drive:
    """A drive. Set-points are repeated from the first command on. As a context manager it stops the motor at
    the end.

    `narx.Drive(bus)` takes any bus of python-can and leaves it open at the end; `narx.connect` opens a bus
    and closes it. A silent drive transmits nothing and only listens. slave, monitor: addresses of the drive
    and of this master. setpoint_period: s.
    """

    def __init__(
        self,
        bus: can.BusABC | Link,
        slave: int = 170,
        monitor: int = 85,
        setpoint_period: float = 0.05,
        silent: bool = False,
        read_parameters: bool = True,
    ) -> None:
        self._own_bus: can.BusABC | None = None
        self._closed = False
        if isinstance(bus, Link):
            self._link: Link = bus
        else:
            master = _core.Master(slave, monitor, setpoint_period, silent, read_parameters)
            stepped = not getattr(bus, "realtime", True)
            self._link = SteppedLink(bus, master) if stepped else BusLink(bus, master)

    @property
    def _master(self) -> _core.Master:
        return self._link.master

    def start(self, rpm: float, wait: bool = True) -> None:
        """Requests a start at a speed, mechanical rpm, negative in reverse.

        Raises ParameterError for a speed beyond the limits of the enabled mode (parameters 101 to 104),
        because the drive would clamp it; the error names the parameter. Open loop runs at parameter 88;
        another speed gives a SpeedWarning. A SpeedWarning also follows if the drive, once started, reports
        that it uses another set-point.

        With `wait`, time runs until the motor is in open or closed loop (state 3, 4 or 5, depending on the
        mode); if it does not get there, StartError has the reason. A drive in Fault does not start: `stop`
        acknowledges the fault.
        """
        self._check_speed(rpm)
        self._link.begin("start", rpm)
        if not wait:
            return
        self._finish()
        used = self._master.accepted_speed
        if used is not None and used != abs(rpm) and not self._is_open_loop():
            warn(f"speed {rpm:g} rpm: the drive uses {used} rpm", SpeedWarning, stacklevel=2)

    def set_speed(self, rpm: float) -> None:
        """Requests another speed in the same direction, mechanical rpm.

        Raises ParameterError for a speed beyond the limits, and warns, as `start` does. Raises RefusedError
        for a motor that was not started, or was stopped: use `start` with the speed. A NarxWarning follows if
        the drive is still in Standby although a start was requested.
        """
        self._check_speed(rpm, 0)
        state, requested = self.state, self._master.requested
        pending = self._master.start_pending
        started = pending or requested in (DRIVE, REVERSE)
        if state is State.FAULT or (not started and (state in RESTING or requested == STANDBY)):
            stopped = "was stopped and " if requested == STANDBY and state not in RESTING else ""
            raise RefusedError(f"speed {rpm:g} rpm: the drive {stopped}is in {name_of(state)}; call start({rpm:g}) first")
        if state is State.STANDBY and not pending:
            warn(
                f"speed {rpm:g} rpm: the drive is in {name_of(state)}: it has not accepted the start yet, or has refused it",
                NarxWarning,
                stacklevel=2,
            )
        self._master.set_speed(rpm)
        self._link.wake()

    def _check_speed(self, rpm: float, least: int | None = None) -> None:
        """Raises ParameterError for a speed that the drive would clamp."""
        self._refuse_silence()
        values: dict[int, int] = {}
        while (missing := self._master.check_speed(rpm, values, least)) is not None:
            values[missing] = round(self.parameters[missing])

    def _refuse_silence(self) -> None:
        if self._master.silent:
            raise RefusedError("the master is silent: it transmits nothing")

    def _is_open_loop(self) -> bool:
        return self.state is State.OPEN_LOOP

    def stop(self) -> None:
        """Requests Standby, which also acknowledges a fault. Raises RefusedError for a silent master, like
        every command."""
        self._refuse_silence()
        self._link.stop()

    def shut_down(self) -> None:
        """Requests a shutdown: the drive goes into Fault with bit 28."""
        self._refuse_silence()
        self._master.shut_down()
        self._link.wake()

    @property
    def state(self) -> State | None:
        """State of the drive; `None` while unknown."""
        return self._master.state

    @property
    def faults(self) -> set[str]:
        """Names of the set bits of the fault word."""
        return self._master.faults or set()

    @property
    def diagnostics(self) -> set[str]:
        """Conditions that are no faults, read from the drive (its parameter Diagnostics): `supply_low` (the
        bus is below 18 V), `position_unknown` (the rotor may have turned unobserved since power-up or since
        its position was set), `wrong_lock_unseen` (sensorless, and the back-EMF constant or the resistance
        that would reveal a stable wrong lock is 0)."""
        word = int(self.parameters["Diagnostics"])
        return {name for name, bit in _core.diagnostic_bits() if word & bit}

    @property
    def fault(self) -> str | None:
        """Meaning of the extended code of the last critical fault; `None` without a fault."""
        critical = self._master.critical
        if not self.faults or critical is None:
            return None
        _, code, meaning = critical
        return meaning or f"extended fault code {code:#06x}"

    @property
    def status(self) -> dict[str, Any]:
        """The fields of the last STATUS_WORD (section 8, Table 8)."""
        return self._master.status or {}

    @property
    def connected(self) -> bool:
        """True if a frame of the drive was received within the last 0.5 s, or within three of its broadcast periods if that
        is longer."""
        return self._master.connected

    @property
    def measurements(self) -> Measurements:
        """Last measurements of the drive."""
        return Measurements(self._master.measurements(), self._master.speed)

    @property
    def info(self) -> Info:
        """BUILD_INFO and DEVICE_INFO, read now. Raises NoAnswerError."""
        self._request("build info")
        self._request("device info")
        build, device = self._master.build, self._master.device
        if build is None or device is None:
            raise NoAnswerError("the drive did not answer with BUILD_INFO and DEVICE_INFO")
        software = f"{device[1] >> 8}.{device[1] & 0xFF}"
        return Info(*build, hardware=device[0], software=software, device_number=device[2], address=device[3])

    @property
    def parameters(self) -> Parameters:
        """The drive's parameters by name or number."""
        return Parameters(self._link)

    @property
    def scope(self) -> Scope:
        """The virtual scope."""
        return Scope(self._link)

    @property
    def log(self) -> Log:
        """The external log memory."""
        return Log(self._link)

    def description(self, progress: Callable[[int, int], None] | bool | None = None) -> str:
        """Downloads the drive's description of itself (XML). progress: called with the number of words
        received and the total; or whether to show a progress bar, as of `narx.read_log`."""
        from narx.download import download

        return download(self._link, "description", progress=progress).rstrip(b"\0").decode()

    def update(self, path: str | Path, progress: Callable[[str, int, int], None] | None = None) -> None:
        """Programs the drive with an image (`cargo xtask sign`), waits for its restart and confirms that it
        runs.

        The drive must be in Standby, or in Fault at standstill, and refuses a start until the update ends.
        progress(stage, done, total) is called with the present stage ("asking", "erasing", "sending",
        "verifying", "restarting") and the number of the image's bytes that are done.

        After an error a drive with two slots runs its previous image: unless the new image is confirmed at the
        end, the bootloader restores the previous one. With one slot the bootloader waits for an image:
        `narx.connect(..., timeout=0)` reaches it. Raises ImageError for a file that is no complete image, or not
        one for this drive: for other hardware, too long, or older than the running image. Raises RefusedError
        when the drive refuses it or its bootloader rejects the signature. Raises NoAnswerError when the drive
        has no bootloader, or does not answer any more. A drive that receives nothing from its master for 60 s
        after its restart restores the previous image.
        """
        try:
            update(self._link, given.path(path).read_bytes(), progress)
        finally:
            # The new image may have other tables.
            self._link.is_described = isinstance(self._link, BenchLink)

    def reboot(self, wait: bool = True) -> None:
        """Restarts a stopped drive, which first stores written parameters (parameter 307 "Automatic
        store"). With `wait`, returns once the drive is in Standby or Fault again, or raises NoAnswerError
        after 5 s."""
        self._link.is_described = isinstance(self._link, BenchLink)
        if wait:
            self._link.begin("reboot")
            self._finish()
        else:
            self._request("reboot")

    def set_outputs(self, dsio1: bool | None = None, dsio2: bool | None = None) -> None:
        """Sets the digital lines: `None` makes one an input, True or False an output of this level."""
        ask(self._link, lambda: self._master.set_outputs(dsio1, dsio2))

    def set_hall_supply(self, on: bool) -> None:
        """Switches the supply of the hall sensors off, or leaves it under control of parameter 97."""
        self._request("enable hall supply" if on else "disable hall supply")

    def set_position(self) -> None:
        """Sets the present mechanical position to the value of parameter 16."""
        self._request("set position")

    def calibrate_hall(self, run: bool = False) -> None:
        """Prepares a hall calibration: the next start turns the motor one electrical revolution each way to
        find order, polarity and offset of the sensors.

        With `run` that start is made now, and time runs until the motor is at rest again, some 5 s. The drive
        uses the result from then on (parameters 79, 80, 262 and 263), and stores it like every other parameter (`parameters.store`).
        Raises StartError if nothing was found.
        """
        if run:
            self._link.begin("calibrate hall")
            self._finish()
        else:
            self._request("calibrate hall")

    def identify(
        self,
        pole_pairs: int | None = None,
        current: float | None = None,
        bridge: float | None = None,
        turn: bool = True,
        halls: bool = False,
        progress: Callable[[str], None] | None = None,
        mark: Callable[[], bool] | None = None,
    ) -> Identified:
        """Measures the motor's resistance, inductance, torque constant, inertia and friction: within some 15 s
        the drive holds the rotor, spins it, lets it coast and accelerates it.

        pole_pairs cannot be seen in volts and amperes. Without them the drive turns the rotor slowly, in steps,
        and asks `mark` again and again: it returns True when a mark on the shaft passes the same place as the
        last time, because somebody sees it, or an encoder or a TX-Driver does. Three of these tell them. current: largest phase current, A; without it the one
        whose heat in the winding is 6 W, 6 A at most. bridge: resistance of two switches of the drive, ohm;
        without it that of narx's own board, 0.04. turn: False holds the rotor and measures resistance and
        inductance alone. halls: True calibrates the hall sensors, too, which takes some 5 s more; the drive keeps
        their order, polarity and offset. progress: called with the stage, "asking", "holding", "counting",
        "spinning", "accelerating", "calibrating", "restoring".

        The shaft must be free and at rest, and the drive in Standby. At the end the motor stands and every
        parameter but those of scope and hall sensors has its former value, also after an error or Ctrl-C. The duty is
        50 % at most until k is known, and 60 % afterwards, so that the rotor turns at half of its nominal speed or
        little more. Raises StartError for a motor that is missing, blocked or incomplete, or that the drive cannot
        turn, and for a drive that is not in Standby.
        """
        self._refuse_silence()
        return identify(self._link, pole_pairs, current, bridge, turn, halls, progress, mark)

    def auto_calibrate(self) -> None:
        """Calibrates current and voltage with the bridge off: the bus current then reads 0 and the bus
        voltage reads parameter 266."""
        self._request("auto-calibrate")

    def wait(self, seconds: float) -> None:
        """Lets time pass, s: simulated time on a bench, else real time. Raises ParameterError for a time that
        is negative or not finite."""
        self._link.wait(lambda: False, given.seconds(seconds))

    def wait_for(self, done: Callable[[], bool], timeout: float = 10.0) -> bool:
        """Lets time pass until `done`, at most `timeout` s, which may be infinite; returns whether it was
        done. Raises ParameterError for a time-out that is negative or NaN."""
        return self._link.wait(done, given.timeout(timeout))

    def close(self, stop: bool = True) -> None:
        """Stops the motor, unless `stop` is false, and releases the bus. A second call does nothing."""
        if self._closed:
            return
        self._closed = True
        try:
            if stop and not self._master.silent:
                self._link.stop()
                # Time for two set-points with Standby.
                self._link.wait(lambda: False, 2 * self._master.setpoint_period)
        finally:
            self._link.close()
            if self._own_bus is not None:
                let_go(self._own_bus)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<narx.Drive in {self._described()}>"

    def _described(self) -> str:
        """Returns state, speed and time in words."""
        speed = self._master.speed
        shown = [name_of(self.state), *([] if speed is None else [f"{speed} rpm"]), f"{self._link.now:.3f} s"]
        return ", ".join(shown)

    def _request(self, what: str) -> int:
        return ask(self._link, lambda: self._master.request(what))

    def _finish(self) -> None:
        """Waits until the job has ended; raises its error."""
        if not self._link.wait(self._master.poll_job, JOB_MAX):
            raise NoAnswerError(f"nothing ended within {JOB_MAX:g} s")


def connect(
    interface: str = "socketcan",
    channel: str | int | None = None,
    slave: int = 170,
    monitor: int = 85,
    bitrate: int = 500_000,
    setpoint_period: float = 0.05,
    silent: bool = False,
    read_parameters: bool = True,
    timeout: float = 2.0,
    **options: Any,
) -> Drive:
    """Opens a bus of python-can and waits until a frame of the drive is received and it has done its self-tests.

    interface, channel, bitrate and further options are those of `can.Bus`: "socketcan" with "can0", "slcan"
    with a serial port or "socket://host:port", "kvaser" with 0, "nican", ... `narx.devices()` lists the
    available ones. Raises ParameterError for an interface that does not exist, BusError for one that cannot
    be opened, NoAnswerError when nothing is received of the drive within `timeout` s. With 0 it
    does not wait: for a drive whose bootloader receives, which takes `update` and nothing else. A silent
    master receives frames of the drive only while another master commands it.
    """
    timeout = given.timeout(timeout)
    bus = opened(interface, channel, bitrate, options)
    try:
        drive = Drive(bus, slave, monitor, setpoint_period, silent, read_parameters)
    except BaseException:
        bus.shutdown()
        raise
    drive._own_bus = bus
    if timeout == 0:
        return drive
    # Some states have the same status word; the master reads the exact state.
    if not drive._link.wait(lambda: is_there(drive, silent), timeout):
        drive.close()
        raise NoAnswerError(
            f"no frame of drive {slave} was received on {interface} {channel} within {timeout:g} s: is it on, at this bit rate, and does it "
            f"answer to master {monitor}?"
        )
    try:
        describe(drive._link)
    except BaseException:
        drive.close(stop=False)
        raise
    return drive


def opened(interface: str, channel: str | int | None, bitrate: int, options: dict[str, Any]) -> can.BusABC:
    """Opens a bus. Raises ParameterError for an interface that python-can does not have, BusError for one
    that cannot be opened, whatever its driver raises."""
    can = need("can")
    if interface not in can.VALID_INTERFACES:
        names = ", ".join(sorted(can.VALID_INTERFACES))
        raise ParameterError(f'there is no interface "{interface}"{suggestion(interface, can.VALID_INTERFACES)}; there are {names}')
    try:
        return can.Bus(interface=interface, channel=channel, bitrate=bitrate, **options)  # type: ignore[no-any-return]
    except Exception as error:
        if isinstance(error.__cause__, NarxError):
            raise error.__cause__ from None
        reason = str(error) if isinstance(error, can.CanError | OSError | ImportError) else f"{type(error).__name__}: {error}"
        if interface in SERIAL and find_spec("serial") is None:
            reason = f"it needs pyserial: pip install 'narx[{EXTRAS['serial']}]'"
        raise BusError(f'interface "{interface}", channel {channel}: {reason}') from error


def is_there(drive: Drive, silent: bool) -> bool:
    """Returns whether the drive answers and takes commands; with a silent master, whether a frame of it was received."""
    if drive._master.last_received is None:
        return False
    return silent or drive.state not in (None, State.INITIALIZATION)


def let_go(bus: can.BusABC) -> None:
    """Shuts a bus down. Errors of a broken bus are ignored: a waiting call has raised them already."""
    import can

    with suppress(can.CanError):
        bus.shutdown()


def devices(*interfaces: str) -> list[dict[str, Any]]:
    """Returns the adapters that can be opened: keyword arguments of `connect`, as python-can finds them, for
    all interfaces or the named ones."""
    can = need("can")
    return [dict(found) for found in can.detect_available_configs(list(interfaces) or None)]


def name_of(state: State | None) -> str:
    """Returns a state in words."""
    return "an unknown state" if state is None else state.name.replace("_", " ").capitalize()
