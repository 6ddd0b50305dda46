"""What the library says, in words that fit Python."""

from __future__ import annotations

import logging
import re

_LOGGER = logging.getLogger("relievo")
# An option of the command line.
_OPTION = re.compile(r"(?<![\w-])--([a-z][a-z0-9]*(?:-[a-z0-9]+)*)")


def in_python(text: str) -> str:
    """Options without dashes: ``--no-repair=weld`` is ``no_repair=weld``."""
    return _OPTION.sub(lambda option: option[1].replace("-", "_"), text)


def told(level: int, message: str) -> None:
    """Passes on a message of the library."""
    _LOGGER.log(level, "%s", in_python(message))
