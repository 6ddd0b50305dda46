"""What can go wrong: few kinds, all of them :class:`RelievoError`."""

from __future__ import annotations

import errno
from typing import Any

from ._messages import in_python


class RelievoError(Exception):
    """Any failure of relievo: one sentence that names the file or array, what is wrong with it, and the remedy.

    ``details`` is what is known all the same: the JSON object that the command line writes on failure (``--json``);
    empty where there is none.
    """

    details: dict[str, Any]

    def __init__(self, message: str, details: dict[str, Any] | None = None) -> None:
        super().__init__(message)
        self.details = {} if details is None else details

    def __reduce__(self) -> tuple[type[RelievoError], tuple[str, dict[str, Any]]]:
        return (type(self), (str(self), self.details))


class UsageError(RelievoError, ValueError):
    """Something impossible was asked for: an option that does not fit, an array of the wrong shape."""


class ReadError(RelievoError, OSError):
    """A file could not be read, or is broken. The message names it; ``errno`` and ``filename`` are ``None``."""


class MissingFileError(ReadError, FileNotFoundError):
    """There is no such file; ``errno`` is ``ENOENT``."""

    def __init__(self, message: str, details: dict[str, Any] | None = None) -> None:
        super().__init__(message, details)
        self.errno = errno.ENOENT


class WriteError(RelievoError, OSError):
    """A file could not be written; whatever had its name before is as it was.

    The message names it; ``errno`` and ``filename`` are ``None``.
    """


class WorkError(RelievoError, RuntimeError):
    """The work itself failed: no hole could be filled, no base surface fits, there is nothing to compare."""


_KINDS: dict[str, type[RelievoError]] = {
    kind.__name__: kind for kind in (UsageError, ReadError, MissingFileError, WriteError, WorkError)
}


def made(kind: str, message: str, details: dict[str, Any]) -> RelievoError:
    """The error that the native module raises."""
    return _KINDS[kind](in_python(message), details)
