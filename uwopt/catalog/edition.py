"""Which catalogue this is: it ages apart from the program, and has a name and a day of its own."""

from __future__ import annotations

#: Name of the built-in catalogue, and the day on which its rows were last held against their sources.
EDITION = "2026.11"
AS_OF = "2026-11-22"
