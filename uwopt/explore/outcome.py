"""From a tab's state to figures: one way, `uwopt.evaluate`, with what it says of faults.

Results are kept by what they were made from, so that a plot or a report of the same state costs nothing;
nothing is kept by tab.
"""

from __future__ import annotations

import hashlib
import json
import math
import shutil
import tempfile
import threading
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from uwopt.api.evaluating import evaluate
from uwopt.errors import FaultsError, MissionError, UwoptError
from uwopt.explore.state import State, named_files
from uwopt.results.result import Result
from uwopt.units import format_quantity, split_unit

KEPT = 64  # results
DIGITS = 4
#: What the page tells of a scene, in the order of the founding paper's tool, then ours.
SHOWN: Mapping[str, str] = {
    "fov_x_m": "Field of view, image width", "fov_y_m": "Field of view, image height",
    "fov_x_deg": "Field of view, image width, seen from the port",
    "fov_y_deg": "Field of view, image height, seen from the port",
    "dof_near_m": "Nearest that is sharp", "dof_far_m": "Farthest that is sharp",
    "exposure_max_ms": "Longest exposure by blur", "effective_focal_length_mm": "Effective focal length",
    "snr": "Signal to noise, a ratio", "snr_db": "Signal to noise", "mean_dn": "Mean response",
    "mean_level": "Mean image level", "frame_rate_min_hz": "Least frame rate",
    "virtual_image_distance_m": "Virtual image behind the dome's vertex", "gsd_mm": "Pixel on the floor",
    "contrast": "Contrast", "mtf_half_nyquist": "MTF at half Nyquist",
    "electrons_signal": "Electrons that form the image",
    "floor_illuminance_mean_lx": "Light on the floor, mean", "power_w": "Mean power", "cost": "Cost, likeliest",
    "mass_kg": "Mass",
}  # fmt: skip
OF_THE_PAGE = ("fov_x_deg", "fov_y_deg")  # that it makes of the others


@dataclass
class KeptResults:
    """Results by what they were made from, and the folder in which own files lie while they are read."""

    folder: Path = field(default_factory=lambda: Path(tempfile.mkdtemp(prefix="uwopt-explore-")))
    _kept: OrderedDict[str, Result | UwoptError] = field(default_factory=OrderedDict)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def close(self) -> None:
        """Own files are taken away."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def result(self, state: State, index: int) -> Result:
        """What a system of the state would do; raises what `evaluate` raises, without paths of this machine."""
        inputs = [state["mission"], state["systems"][index], state["files"]]
        key = hashlib.sha256(json.dumps(inputs, sort_keys=True).encode()).hexdigest()
        with self._lock:
            known = self._kept.get(key)
        if known is None:
            known = self._made(state, index)
            with self._lock:
                self._kept[key] = known
                while len(self._kept) > KEPT:
                    self._kept.popitem(last=False)
        if isinstance(known, UwoptError):
            raise known
        return known

    def _made(self, state: State, index: int) -> Result | UwoptError:
        try:
            mission, system = (self.with_files(state, one) for one in (state["mission"], state["systems"][index]))
            return evaluate(mission, system)
        except UwoptError as fault:
            return self.without_paths(fault)

    def with_files(self, state: State, data: Mapping[str, Any]) -> dict[str, Any]:
        """A mission or system whose files are where they can be read; raises where one is not there."""
        names = named_files(data)
        missing = sorted(names - state["files"].keys())
        if missing:
            raise MissionError(
                [f"{name[:80]}: this file is not loaded; load it under Files, then name it alone." for name in missing]
            )
        if not names:
            return dict(data)
        place = self.placed(state["files"])
        made: dict[str, Any] = replaced(data, lambda text: str(place / text) if text in names else text)
        return made

    def placed(self, files: Mapping[str, str]) -> Path:
        """The folder with these files and no others."""
        digest = hashlib.sha256(json.dumps(files, sort_keys=True).encode()).hexdigest()[:20]
        place = self.folder / digest
        if not place.is_dir():
            made = Path(tempfile.mkdtemp(dir=self.folder))
            for name, text in files.items():
                (made / name).write_text(text, encoding="utf-8", newline="")
            try:
                made.rename(place)
            except OSError:  # another request was first
                shutil.rmtree(made, ignore_errors=True)
        return place

    def without_paths(self, fault: UwoptError) -> UwoptError:
        """The same fault as a page may show it."""
        texts = fault.faults if isinstance(fault, FaultsError) else [str(fault)]
        return MissionError([self.plain(text) for text in texts])

    def plain(self, text: str) -> str:
        """Text without the folder of own files."""
        for path in sorted(self.folder.glob("*"), key=lambda one: -len(str(one))):
            text = text.replace(str(path) + "/", "").replace(str(path), "")
        return text.replace(str(self.folder) + "/", "")


def replaced(value: Any, change: Callable[[str], str]) -> Any:
    """Nested plain values with every text changed."""
    if isinstance(value, Mapping):
        return {key: replaced(item, change) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [replaced(item, change) for item in value]
    return change(value) if isinstance(value, str) else value


def shown_figures(result: Result, scene: int = 0) -> dict[str, str]:
    """The figures of one scene as the page writes them, by name."""
    design = result.best
    assert design is not None  # an evaluation has one
    figures = dict(design.scenes[scene].figures)
    own = result.mission["scenes"][scene].get("vehicle") or {}
    altitude = own.get("altitude_m") or result.mission["vehicle"]["altitude_m"]
    for side in ("x", "y") if "range_centre_m" not in figures else ():  # not of a view that looks ahead
        figures[f"fov_{side}_deg"] = 2.0 * math.degrees(math.atan(0.5 * figures[f"fov_{side}_m"] / altitude))
    made = {}
    for name in SHOWN:
        value = figures.get(name)
        unit = figures["currency"] if name == "cost" else split_unit(name)[1]
        endless = figures.get(f"{split_unit(name)[0]}_is_infinite")
        made[name] = "infinite" if endless else format_quantity(value, unit, DIGITS)
    return made


def shown_rig(result: Result, scene: int = 0) -> dict[str, Any]:
    """What the drawing that lamps are moved on is made of: lamps, the half-angle of their beams, and the view."""
    design = result.best
    assert design is not None  # an evaluation has one
    figures, own = design.scenes[scene].figures, result.mission["scenes"][scene].get("vehicle") or {}
    along = "y" if design.hardware.orientation == "landscape" else "x"
    sides = {side: figures.get(f"fov_{side}_m") or 0.0 for side in ("x", "y")}
    return {
        "places": [asdict(place) for place in design.hardware.light_mounts],
        "altitude_m": own.get("altitude_m") or result.mission["vehicle"]["altitude_m"],
        "along_m": sides[along], "across_m": sides["xy".replace(along, "")],
        "looks_up": result.mission["scenes"][scene].get("target") == "ceiling",
    }  # fmt: skip


def shown_margins(result: Result, scene: int = 0) -> list[tuple[str, str, str, str, bool]]:
    """Requirement, value, limit, what is left, and whether it is met, of one scene."""
    from uwopt.report.text.tables import has_no_limit, kinds_by_id, margin_texts

    design = result.best
    assert design is not None  # an evaluation has one
    kinds, cost = kinds_by_id(design), design.totals.cost
    return [
        (*margin_texts(margin, kinds, cost)[:4], margin.satisfied)
        for margin in design.scenes[scene].margins
        if not has_no_limit(margin)
    ]
