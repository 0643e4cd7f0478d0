"""Where something was measured: processor, load, versions."""

from __future__ import annotations

import os
import platform
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from typing import Any

from uwopt.results.version import __version__

LIBRARIES = ("numpy", "scipy", "casadi", "nlopt", "pymoo", "moocore", "mpmath", "jerlov")


def machine() -> dict[str, Any]:
    """Time, system, processor, cores, load and versions."""
    return {
        "measured": f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC",
        "system": f"{platform.system()} {platform.machine()}",
        "processor": processor(),
        "cores": os.cpu_count() or 0,
        "load_before": [round(value, 2) for value in os.getloadavg()] if hasattr(os, "getloadavg") else None,
        "versions": {"uwopt": __version__, "python": platform.python_version(), **versions()},
    }


def versions() -> dict[str, str]:
    """Versions of the libraries that are measured or measured with."""
    found = {}
    for name in LIBRARIES:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return found


def processor() -> str:
    """Name of the processor as far as the system tells."""
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or "unknown processor"
