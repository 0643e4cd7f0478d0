"""The door of the program `uwopt`: whoever ends it by Ctrl-C while it is loaded meets no traceback either."""

from __future__ import annotations

import sys

from uwopt.cli import INTERRUPTED, NO_RESULT


def start() -> None:
    """Load the program and run it."""
    try:
        from uwopt.cli.app import main

        main()
    except KeyboardInterrupt:
        print(NO_RESULT, file=sys.stderr)
        sys.exit(INTERRUPTED)
