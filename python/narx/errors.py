"""What can go wrong. Every message names what it is about, its value and what is allowed."""


class NarxError(Exception):
    """Any error of narx."""


class ParameterError(NarxError, ValueError):
    """An argument or a parameter of the drive that cannot have its value, cannot be written, or does not exist."""


class SignalError(NarxError, KeyError):
    """There is no such signal or measurement."""

    __str__ = Exception.__str__  # A KeyError would show the message in quotes.


class RecordingError(NarxError, ValueError):
    """Bytes that are not a recording, are damaged, or were recorded by another version."""


class StartError(NarxError, RuntimeError):
    """The drive did not start: it refused, found a fault, or took too long."""


class RefusedError(NarxError, RuntimeError):
    """The drive, or this master, does not do what it is asked for in its present state."""


class AbortError(RefusedError):
    """A TX-Driver does not read or write an entry (SDO abort, Table 10 of the eddyCAN specification)."""

    def __init__(self, message: str, code: int = 0) -> None:
        super().__init__(message)
        self.code = code
        """The abort code."""


class ImageError(NarxError, ValueError):
    """A file that is no image, or not one for this drive: damaged, for other hardware, too long, or older than what runs."""


class NoAnswerError(NarxError, TimeoutError):
    """The drive does not answer: it is off, elsewhere, or has other addresses or another bit rate."""


class BusError(NarxError, OSError):
    """The adapter or its bus does not work any more."""


class NarxWarning(UserWarning):
    """Something is done in another way than it was asked for, or cannot be known."""


class SpeedWarning(NarxWarning):
    """The drive uses another set-point than the one that was asked for."""


class DescriptionWarning(NarxWarning):
    """The drive's own description cannot be read, so that the tables of this package have to serve."""
