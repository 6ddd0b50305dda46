"""From a function's arguments to a command of the command line, and back."""

from __future__ import annotations

import json
import operator
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

from . import _arrays, _relievo
from ._errors import MissingFileError, ReadError, UsageError, WorkError
from ._results import Completed, Run, Textured, Transferred
from ._scan import Scan, check_output, scan_of

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from ._types import ImageLike, PathLike, ScanLike

    Given = Mapping[str, ScanLike | ImageLike | None]
    Options = Mapping[str, object]


def report(command: str, given: Given, options: Options, seed: int, threads: int | None) -> Any:
    """The report of a command that makes nothing else."""
    return _called(command, given, options, seed, threads).report


def completed(command: str, given: Given, options: Options, seed: int, threads: int | None) -> Completed:
    """See :func:`relievo.complete`."""
    called = _called(command, given, options, seed, threads)
    return Completed(called.scan, called.report, called.partly)


def textured(command: str, given: Given, options: Options, seed: int, threads: int | None) -> Textured:
    """See :func:`relievo.texture`."""
    called = _called(command, given, options, seed, threads)
    return Textured(called.scan, called.report)


def transferred(command: str, given: Given, options: Options, seed: int, threads: int | None) -> Transferred:
    """See :func:`relievo.transfer`."""
    called = _called(command, given, options, seed, threads)
    return Transferred(called.scan, called.report)


def picture(command: str, given: Given, options: Options, seed: int, threads: int | None) -> npt.NDArray[np.uint8]:
    """See :func:`relievo.render`."""
    drawn = _called(command, given, options, seed, threads).picture
    if drawn is None:
        raise WorkError("relievo has drawn no picture; please report it")
    return drawn


def run(
    pipeline: Mapping[str, Any] | list[Any] | PathLike,
    *,
    scans: Mapping[str, ScanLike] | None = None,
    threads: int | None = None,
) -> Run:
    """Does what a pipeline says: reads a scan, completes it, measures, draws, writes, as ``relievo run`` does.

    Parameters
    ----------
    pipeline : mapping, list of steps, or path of a JSON file
        As in ``{"seed": 0, "pipeline": ["in.ply", {"type": "complete", "holes": "largest"}, "out.ply"]}``;
        :func:`relievo.schema` tells all steps and their options.
    scans : mapping of str to scans, optional
        Scans that the pipeline names instead of files.
    threads : int, optional
        Number of threads, by default one a core; the result does not depend on it.

    Returns
    -------
    Run
        ``.scan`` is the scan that the pipeline ends with, ``.report`` what ``relievo run --json`` writes.

    Raises
    ------
    RelievoError
        UsageError if the pipeline cannot be meant so, with the step's name; WorkError if a step fails.

    Examples
    --------
    >>> done = relievo.run(["data/scans/golf-ball-half.ply", {"type": "complete", "extend": True}])
    >>> done.scan.n_vertices > 1502
    True
    """
    count = threads_of(threads)
    name = os.fspath(pipeline) if isinstance(pipeline, (str, os.PathLike)) else None
    if isinstance(pipeline, (str, os.PathLike)):
        text = _text_of(pipeline)
    else:
        text = json_of({"pipeline": pipeline} if isinstance(pipeline, list) else dict(pipeline))
    held = [(name, name, scan_of(scan)._held) for name, scan in (scans or {}).items()]
    scan, _, told, partly = _relievo.run(text, name, held, count)
    return Run(None if scan is None else Scan._of_held(scan), report_of("run", told, partly, None), partly)


def _text_of(path: PathLike) -> str:
    try:
        with open(path, encoding="utf-8") as file:
            return file.read()
    except FileNotFoundError:
        raise MissingFileError(f"{os.fspath(path)}: there is no such file; check the path") from None
    except (OSError, UnicodeDecodeError) as error:
        raise ReadError(f"cannot read {os.fspath(path)} ({error}); give the path of a JSON file") from None


def schema() -> dict[str, Any]:
    """The JSON schema (draft 2020-12) of pipelines: every step with its options, their types and defaults."""
    told: dict[str, Any] = json.loads(_relievo.schema())
    return told


@dataclass(frozen=True)
class _Called:
    """What a command has given."""

    made: Scan | None
    picture: npt.NDArray[np.uint8] | None
    report: Any
    partly: bool

    @property
    def scan(self) -> Scan:
        """Of commands that make one."""
        if self.made is None:
            raise WorkError("relievo has made no scan; please report it")
        return self.made


def _called(command: str, given: Given, options: Options, seed: int, threads: int | None) -> _Called:
    count = threads_of(threads)
    output = given.get("output")
    if isinstance(output, (str, os.PathLike)):
        check_output(output, overwrite=bool(options["overwrite"]))
    members, held = arguments_of(command, given, options, seed)
    made, drawn, told, partly = _relievo.call(command, members, held, count)
    scan = None if made is None else Scan._of_held(made)
    told_by = report_of(command, told, partly, next((what for what in given.values() if what is not None), None))
    return _Called(scan, None if drawn is None else _arrays.view(drawn), told_by, partly)


def report_of(command: str, told: str, partly: bool, scan: object) -> Any:
    """What the command line writes with ``--json``, but for the pipeline that repeats a command."""
    status = "partly" if partly else "done"
    report = {"command": command, "version": _relievo.version(), "status": status}
    if isinstance(scan, (str, os.PathLike)):
        report["input"] = os.fspath(scan)
    return {**report, **json.loads(told)}


def arguments_of(
    command: str, given: Given, options: Options, seed: int
) -> tuple[str, list[tuple[str, str, _relievo.HeldScan | _relievo.HeldImage]]]:
    """A command's options as JSON, and what is in memory under the names that they have for it."""
    members: dict[str, object] = {"seed": whole_number("seed", seed)}
    held: list[tuple[str, str, _relievo.HeldScan | _relievo.HeldImage]] = []
    for name, what in given.items():
        if what is None:
            continue
        if isinstance(what, (str, os.PathLike)) and (_is_unicode(what) or not _is_read_here(name, options)):
            members[name] = os.fspath(what)
            continue
        # No file is called so by accident, and only what is in memory is looked for under it.
        members[name] = f"<{name}>"
        shown = "mesh" if (command, name) == ("texture", "scan") else name
        held.append((f"<{name}>", _name_of(what, shown), _held(command, what, shown)))
    for name, value in options.items():
        members[name] = _size(value) if name == "size" else value
    return json_of(members), held


def _is_unicode(path: PathLike) -> bool:
    """Whether a path can be given as text: names of files may be any bytes."""
    return not any("\ud800" <= char <= "\udfff" for char in os.fspath(path))


def _is_read_here(name: str, options: Options) -> bool:
    """Whether a scan can as well be given from memory."""
    of_reading = ("columns", "intrinsics", "color_image")
    return name not in ("output", "exemplar") and all(options.get(option) is None for option in of_reading)


def _name_of(what: ScanLike | ImageLike, shown: str) -> str:
    """What messages call it."""
    if isinstance(what, (str, os.PathLike)):
        return os.fspath(what).encode("utf-8", "replace").decode()
    return f"the {shown}"


def _held(command: str, what: ScanLike | ImageLike, name: str) -> _relievo.HeldScan | _relievo.HeldImage:
    """A scan, or an image where an array is given and one may be."""
    if (command, name) == ("texture", "exemplar"):
        import numpy as np

        if isinstance(what, np.ndarray):
            return _arrays.image_of(what, name)
    return scan_of(cast("ScanLike", what))._held


def _size(size: object) -> object:
    """Width and height as the command line has them."""
    return "x".join(map(str, size)) if isinstance(size, (tuple, list)) else size


def threads_of(threads: int | None) -> int | None:
    """A number of threads as the library takes it."""
    return None if threads is None else whole_number("threads", threads, 1, 65535)


def whole_number(name: str, value: object, least: int = 0, most: int = 0xFFFFFFFF) -> int:
    """A whole number of Python or numpy within limits."""
    try:
        number = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        number = least - 1
    if not least <= number <= most:
        raise UsageError(f"{name} is {value!r}; give a whole number from {least} to {most}")
    return number


def json_of(value: object) -> str:
    """JSON of what users give, numpy's numbers among it."""
    try:
        text = json.dumps(value, default=plain, allow_nan=False, ensure_ascii=False)
        text.encode()
    except UnicodeEncodeError:
        raise UsageError("an option names a file whose name is not valid Unicode: rename the file") from None
    except (TypeError, ValueError) as error:
        raise UsageError(f"an option has a value that cannot be: {error}") from None
    return text


def plain(value: object) -> object:
    """numpy's numbers and arrays, sets and ranges, and paths, as JSON has them."""
    if isinstance(value, (set, frozenset, range)):
        return sorted(value)
    for method in ("tolist", "__index__", "__float__", "__fspath__"):
        convert = getattr(value, method, None)
        if convert is not None:
            return convert()
    raise TypeError(f"{value!r} is no number, text or list")
