"""What can go wrong. Every message names what it is about, its value and what is allowed."""


class NarxError(Exception):
    """Any error of narx."""


class ParameterError(NarxError, ValueError):
    """An argument or a parameter of the drive that cannot have its value, or does not exist."""


class SignalError(NarxError, KeyError):
    """A trace has no such signal."""

    __str__ = Exception.__str__  # A KeyError would show the message in quotes.


class RecordingError(NarxError, ValueError):
    """Bytes that are not a recording, are damaged, or were recorded by another version."""


class StartError(NarxError, RuntimeError):
    """The drive did not start: it refused, found a fault, or took too long."""
