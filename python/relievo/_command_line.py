"""The command ``relievo``."""

from __future__ import annotations

import signal
import sys

from . import _relievo


def main() -> int:
    """Runs the command line, which listens to interrupts itself."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _relievo.main(["relievo", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
