"""What functions give back that make a scan."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ._reports import CompletionReport, TextureReport, TransferReport
    from ._scan import Scan


@dataclass(frozen=True)
class Completed:
    """A completed scan."""

    #: First all that was there, bit for bit and in its order, then what is new.
    scan: Scan
    #: What was done and why: the JSON of ``relievo complete --json``, but for ``pipeline``, and with ``input`` only
    #: if the scan was given as a path. So are the reports of all commands.
    report: CompletionReport
    #: Whether some of the chosen gaps stayed open: ``report["skipped"]`` says why.
    partly: bool


@dataclass(frozen=True)
class Textured:
    """A textured mesh."""

    scan: Scan
    #: The JSON of ``relievo texture --json``, with the same exceptions.
    report: TextureReport


@dataclass(frozen=True)
class Transferred:
    """A mesh with what was transferred to it."""

    scan: Scan
    #: The JSON of ``relievo transfer --json``, with the same exceptions.
    report: TransferReport


@dataclass(frozen=True)
class Run:
    """What a pipeline has done."""

    #: The scan that it ends with, if there is one.
    scan: Scan | None
    #: The JSON of ``relievo run --json``.
    report: dict[str, Any]
    #: Whether a step could be done partly only.
    partly: bool
