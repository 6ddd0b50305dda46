"""Completes range scans: where the scanner saw nothing, the shape, the relief and the colour are restored.

Every function takes a scan as a :class:`Scan`, as the path of a file, as a ``trimesh.Trimesh``, or as a tuple of arrays
``(vertices, faces)``. Their options are those of the command line, and mean the same: ``relievo complete --help`` and
``help(relievo.complete)`` say what they do. Lengths are in the scan's own unit, whatever that is.

While relievo works, other threads of Python run on, and Ctrl-C raises ``KeyboardInterrupt``. What it has to say goes to
the logger ``relievo`` of :mod:`logging`.

>>> import relievo
>>> scan = relievo.read("data/scans/golf-ball-half.ply")
>>> scan
<relievo.Scan: 1502 vertices, 2908 faces, channels x, y, z>
"""

from __future__ import annotations

import atexit

from . import _relievo
from ._call import run, schema
from ._commands import compare, complete, fit, holes, info, render, stats, texture, transfer
from ._errors import MissingFileError, ReadError, RelievoError, UsageError, WorkError, WriteError
from ._results import Completed, Run, Textured, Transferred
from ._scan import Scan, read, write
from ._types import ImageLike, ScanLike

__version__ = _relievo.version()
__all__ = [
    "Completed",
    "ImageLike",
    "MissingFileError",
    "ReadError",
    "RelievoError",
    "Run",
    "Scan",
    "ScanLike",
    "Textured",
    "Transferred",
    "UsageError",
    "WorkError",
    "WriteError",
    "__version__",
    "compare",
    "complete",
    "fit",
    "holes",
    "info",
    "read",
    "render",
    "run",
    "schema",
    "stats",
    "texture",
    "transfer",
    "write",
]

# A thread that works on something that nobody waits for any more (after an interrupt) leaves nothing half written.
atexit.register(_relievo.abandon)
