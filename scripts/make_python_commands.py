#!/usr/bin/env python3
"""Writes python/relievo/_commands.py: the functions that are commands, with the options that `relievo schema` tells.

    scripts/make_python_commands.py [--check] [--schema FILE]

--check changes nothing and ends with 1 if the file would change. The schema is that of the installed package, or of
the FILE that `relievo schema` has written. What the schema does not tell (types of Python, what is given back) is
below.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
import textwrap
from dataclasses import dataclass
from pathlib import Path
from typing import Any

TARGET = Path(__file__).resolve().parents[1] / "python" / "relievo" / "_commands.py"
WIDTH = 116

SCAN = "Scan, path, trimesh.Trimesh, or (vertices, faces)"


@dataclass(frozen=True)
class Given:
    """A parameter that is no option of the schema: a scan, an image, where the result goes."""

    name: str
    type: str
    meaning: str
    default: str | None = None
    keyword: bool = False
    #: What the command calls it, if otherwise.
    option: str | None = None


@dataclass(frozen=True)
class Function:
    """What the schema does not tell of a command."""

    given: tuple[Given, ...]
    result: str
    call: str
    returns: str
    raises: str
    example: str = ""


THE_SCAN = Given("scan", "ScanLike", SCAN)

OUTPUT = Given(
    "output",
    "PathLike | None",
    "the file to write the mesh to as well; with ``keep_mesh`` with a texture image, if the mesh has texture "
    "coordinates",
    "None",
    keyword=True,
)

FUNCTIONS: dict[str, Function] = {
    "complete": Function(
        (THE_SCAN,),
        "Completed",
        "completed",
        "``.scan`` is the completed scan: first all that was there, bit for bit and in its order, then what is new, "
        "marked by the channel ``completed`` (1). ``.partly`` is true if some of the chosen gaps stayed open; "
        '``.report["skipped"]`` says why.',
        "WorkError if no hole could be filled",
        """
>>> done = relievo.complete("data/scans/bricks-hole.ply", holes="largest")
>>> done.report["counts"]["completed_vertices"], done.partly
(142, False)
""",
    ),
    "fit": Function(
        (THE_SCAN,),
        "FitReport",
        "report",
        'The base surface (``["base"]``), how it fits, and how the other kinds compare (``["ranking"]``).',
        "WorkError if there is nothing to fit to",
        """
>>> relievo.fit("data/scans/golf-ball-half.ply")["base"]["kind"]
'sphere'
""",
    ),
    "holes": Function(
        (THE_SCAN,),
        "HolesReport",
        "report",
        'Every boundary loop (``["loops"]``); the ``id`` of each is what ``complete(holes=[...])`` takes.',
        "WorkError if the scan has no surface",
        """
>>> [(loop["id"], loop["kind"]) for loop in relievo.holes("data/scans/bricks-hole.ply")["loops"]]
[(0, 'rim'), (1, 'hole')]
""",
    ),
    "info": Function(
        (THE_SCAN,),
        "InfoReport",
        "report",
        "What is in the scan: counts, channels, extent, pieces, holes, what would be repaired.",
        "ReadError if it cannot be read",
    ),
    "stats": Function(
        (THE_SCAN,),
        "StatsReport",
        "report",
        "The figures of both parts, how far they differ in units of natural variation, and a verdict in words.",
        "WorkError if the scan has no completed part",
    ),
    "compare": Function(
        (
            THE_SCAN,
            Given("other", "ScanLike | None", f"{SCAN}; without it two parts of one scan are compared", "None"),
        ),
        "CompareReport",
        "report",
        'The figures of both, ``["a"]`` and ``["b"]``, how far they differ in units of natural variation, '
        "and a verdict in words.",
        "WorkError if one of them has too little surface",
    ),
    "texture": Function(
        (
            Given("mesh", "ScanLike", SCAN, option="scan"),
            Given(
                "exemplar",
                "ScanLike | ImageLike",
                "the sample of texture: an image (path, or (height, width, 3) array of uint8), or a scan whose "
                "relief and colours are taken",
            ),
            OUTPUT,
        ),
        "Textured",
        "textured",
        "``.scan`` is the textured mesh.",
        "WorkError if the texture cannot be put on this mesh",
    ),
    "transfer": Function(
        (
            Given("target", "ScanLike", f"where to: {SCAN}", keyword=True),
            Given("source", "ScanLike | None", f"where from: {SCAN}; or ``mask``", "None", keyword=True),
            OUTPUT,
        ),
        "Transferred",
        "transferred",
        "``.scan`` is the target with what was transferred.",
        "WorkError if nothing can be transferred",
    ),
    "render": Function(
        (
            THE_SCAN,
            Given(
                "path",
                "PathLike | None",
                "the PNG picture to write as well",
                "None",
                option="output",
            ),
        ),
        "npt.NDArray[np.uint8]",
        "picture",
        "The picture: (height, width, 3) red, green and blue, rows from the top, read-only; (height, width, 4) with "
        "opacity if the background is transparent.",
        "WriteError if the picture cannot be written",
    ),
}

# Options that belong to files and to the command line.
LEFT_OUT = {"type", "tag", "output", "ascii", "seed", "exemplar", "source", "target", "other"}
# Where results may go to files.
OVERWRITE_OF = {"render", "texture", "transfer"}

# Where Python asks for more than the command line, which only protects what it reads.
MEANINGS = {"overwrite": "Replace the file if there is one of this name"}

# Words of the command line that mean nothing in Python.
WORDS = {
    ", or to standard output (-)": "",
    " to FILE": " to this file",
    "(1 + KAPPA)": "(1 + this)",
    "OUT is ": "``output`` is ",
}

# Options whose values Python has better types for than text.
TYPES = {
    "background": "str",
    "base": 'Literal["auto", "plane", "sphere", "cylinder", "cone", "freeform"]',
    "channel": "str",
    "color_image": "PathLike",
    "columns": "Sequence[str]",
    "correspondences": "PathLike",
    "csv": "PathLike",
    "holes": 'Literal["interior", "all", "largest"] | Sequence[int]',
    "init": "PathLike",
    "intrinsics": "tuple[float, float, float, float]",
    "join": 'Literal["auto", "chart", "local"]',
    "mask": "str",
    "memory": "str | int",
    "no_repair": "bool | Sequence[str]",
    "orientation": 'Literal["relax", "random", "x", "y", "z"] | tuple[float, float, float] | PathLike',
    "other_part": "str",
    "part": "str",
    "range": "tuple[float, float]",
    "report": "PathLike",
    "size": "str | tuple[int, int]",
    "source_up": 'Literal["x", "y", "z", "none"] | tuple[float, float, float]',
    "spacing": 'Literal["nyquist", "scan"] | float',
    "up": 'Literal["x", "y", "z", "none"] | tuple[float, float, float]',
    "view": 'Literal["auto", "front", "back", "left", "right", "top", "bottom", "iso"] | tuple[float, float]',
}
# Those of one command that differ.
TYPES_OF = {
    ("fit", "base"): 'Literal["auto", "plane", "sphere", "cylinder", "cone"]',
    ("render", "up"): 'Literal["auto", "x", "y", "z"]',
}


def type_of(command: str, name: str, option: dict[str, Any]) -> str:
    """The type of an option's values."""
    if (command, name) in TYPES_OF:
        return TYPES_OF[command, name]
    if "enum" not in option and name in TYPES:
        return TYPES[name]
    if "enum" in option:
        return f"Literal[{', '.join(json.dumps(value) for value in option['enum'] if value is not None)}]"
    # What may be left out may be null, which is `None` in Python.
    kinds = option["type"]
    if isinstance(kinds, list):
        kinds = [kind for kind in kinds if kind != "null"]
        kinds = kinds[0] if len(kinds) == 1 else kinds
    if isinstance(kinds, list):
        return "str | float" if "number" in kinds else "str"
    return {"boolean": "bool", "integer": "int", "number": "float", "string": "str"}[kinds]


def default_of(option: dict[str, Any], type_: str) -> str:
    """The default as Python writes it."""
    default = option.get("default")
    if isinstance(default, str):
        return json.dumps(default)
    return repr(float(default)) if type_ == "float" and default is not None else repr(default)


def python_words(text: str) -> str:
    """Help of the command line in words that fit Python."""
    text = re.sub(r"`relievo ([a-z]+)`", r"``relievo.\1``", text)
    text = re.sub(r"--([a-z][a-z-]*)(=\S+)?", lambda m: f"``{m[1].replace('-', '_')}{m[2] or ''}``", text)
    for there, here in WORDS.items():
        text = text.replace(there, here)
    return text


def paragraph(text: str, indent: str) -> str:
    return textwrap.fill(text, WIDTH, initial_indent=indent, subsequent_indent=indent, break_on_hyphens=False)


def parameter(name: str, type_: str, default: str | None, meaning: str) -> list[str]:
    return [f"{name} : {type_}" + ("" if default is None else f", default {default}"), paragraph(meaning, "    ")]


def function(command: str, step: dict[str, Any], told: Function) -> str:
    """The source of one function."""
    options = {name: option for name, option in step["properties"].items() if name not in LEFT_OUT}
    if command not in OVERWRITE_OF:
        options.pop("overwrite", None)
    signature: list[str] = []
    docs: list[str] = []
    starred = False
    for given in told.given:
        if given.keyword and not starred:
            signature.append("*")
            starred = True
        signature.append(f"{given.name}: {given.type}" + ("" if given.default is None else f" = {given.default}"))
        docs += parameter(given.name, given.type, None, given.meaning)
    if not starred:
        signature.append("*")
    for name, option in options.items():
        type_ = type_of(command, name, option)
        default = default_of(option, type_)
        signature.append(f"{name}: {type_ if default != 'None' else f'{type_} | None'} = {default}")
        docs += parameter(
            name,
            type_,
            None if default == "None" else default,
            MEANINGS.get(name) or python_words(option["description"]),
        )
    signature += ["seed: int = 0", "threads: int | None = None"]
    docs += parameter("seed", "int", "0", "Seed of all random choices: the same seed gives the same bytes")
    docs += parameter(
        "threads", "int", None, "Number of threads, by default one a core; the result does not depend on it"
    )
    # The same name may be taken and handed on.
    scans = ", ".join(f'"{given.option or given.name}": {given.name}' for given in told.given)
    handed = "".join(f'            "{name}": {name},\n' for name in options)
    doc_lines = [
        paragraph(f"{python_words(step['description'])}.", "    ").strip(),
        "",
        "Parameters",
        "----------",
        *docs,
        "",
        "Returns",
        "-------",
        told.result,
        paragraph(told.returns, "    "),
        "",
        "Raises",
        "------",
        "RelievoError",
        paragraph(
            f"{told.raises}; UsageError if options cannot be meant so; ReadError if a file cannot be read.", "    "
        ),
    ]
    if told.example:
        doc_lines += ["", "Examples", "--------", *told.example.strip().splitlines()]
    doc = textwrap.indent("\n".join(doc_lines), "    ").strip()
    begins = f"told: {told.result} = " if told.call == "report" else "return "
    ends = "    return told\n" if told.call == "report" else ""
    return (
        f"def {command}(\n"
        + "".join(f"    {line},\n" for line in signature)
        + f') -> {told.result}:\n    """{doc}\n    """\n'
        + f'    {begins}_call.{told.call}(\n        "{command}",\n        {{{scans}}},\n'
        + f"        {{\n{handed}        }},\n"
        + "        seed,\n        threads,\n    )\n"
        + ends
    )


HEAD = '''"""The functions that are commands of the command line.

Made by scripts/make_python_commands.py from what `relievo schema` tells: change the script, not this file.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

from . import _call
from ._reports import CompareReport, FitReport, HolesReport, InfoReport, StatsReport
from ._results import Completed, Textured, Transferred

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from ._types import ImageLike, PathLike, ScanLike

__all__ = [
'''


def source(schema: dict[str, Any]) -> str:
    """The whole file."""
    names = "".join(f'    "{name}",\n' for name in sorted(FUNCTIONS))
    steps = schema["$defs"]
    functions = "\n\n".join(function(name, steps[name], told) for name, told in FUNCTIONS.items())
    return f"{HEAD}{names}]\n\n\n{functions}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="change nothing; 1 if the file would change")
    parser.add_argument(
        "--schema", type=Path, help="what `relievo schema` has written; by default the installed package's"
    )
    arguments = parser.parse_args()
    if arguments.schema:
        schema = json.loads(arguments.schema.read_text(encoding="utf-8"))
    else:
        from relievo import schema as installed

        schema = installed()
    text = source(schema)
    old = TARGET.read_text(encoding="utf-8") if TARGET.exists() else ""
    if arguments.check:
        if text != old:
            print(f"{TARGET.name} is not what the schema tells: run {sys.argv[0]}", file=sys.stderr)
        return int(text != old)
    TARGET.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
