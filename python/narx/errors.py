"""Errors of narx. Every message names its subject, the value and the allowed range."""


class NarxError(Exception):
    """Any error of narx."""


class ParameterError(NarxError, ValueError):
    """An argument or a parameter of the drive has a value out of range, cannot be written, or does not
    exist."""


class SignalError(NarxError, KeyError):
    """A signal or measurement does not exist."""

    __str__ = Exception.__str__  # KeyError would put the message in quotes.


class RecordingError(NarxError, ValueError):
    """The bytes are not a recording, are damaged, or were recorded by another version."""


class StartError(NarxError, RuntimeError):
    """The drive did not start: it refused, found a fault, or took too long."""


class RefusedError(NarxError, RuntimeError):
    """The drive, or this master, refuses a request in its present state."""


class AbortError(RefusedError):
    """A TX-Driver refuses to read or write an entry (SDO abort, Table 10 of the eddyCAN specification)."""

    def __init__(self, message: str, code: int = 0) -> None:
        super().__init__(message)
        self.code = code
        """Abort code."""


class ImageError(NarxError, ValueError):
    """The file is no image, or not one for this drive: damaged, for other hardware, too long, or older than
    the running image."""


class NoAnswerError(NarxError, TimeoutError):
    """The drive does not answer: it is off, not on this bus, or has other addresses or another bit rate."""


class BusError(NarxError, OSError):
    """The adapter or its bus does not work any more."""


class MissingError(NarxError, ImportError):
    """A library of an extra is not installed; the message has the command that installs it."""


class NarxWarning(UserWarning):
    """A request is carried out in another way than requested, or its result cannot be known."""


class SpeedWarning(NarxWarning):
    """The drive uses another set-point than the requested one."""


class DescriptionWarning(NarxWarning):
    """The drive's own description cannot be read; the tables of this package are used instead."""
