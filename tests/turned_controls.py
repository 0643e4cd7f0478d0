"""A state of the page in which everything matters, and another value of each control."""

from __future__ import annotations

from uwopt.explore import state
from uwopt.explore.controls import OWN, Control


def turned(of: state.State, **texts: str) -> state.State:
    return state.with_texts(of, {name.replace("__", "-"): text for name, text in texts.items()})


#: A state in which everything matters: own parts, sun, veils.
FULL = turned(
    state.OPENING, **{"s-camera": OWN, "m-physics": "full", "m-scene-sun_lux": "20000", "m-scene-depth_m": "10"},
    **{"s-light_count": "2", "m-requirements-min_snr_db": "10", "s-settings-f_number": "2"},
)  # fmt: skip
OTHER = {
    "s-light": "sofirn-sd05", "s-camera": "flir-bfs-u3-51s5m", "s-lens": "computar-m1214-mp2",
    "s-port": "blue-robotics-4-in-dome-plastic-ring-2026",
    "s-light_count": "3", "m-limits-cost": "900", "s-light-spectrum": "CIE FL2", "m-scene-water": "III",
    "m-scene-seafloor": "sand", "s-orientation": "landscape",
    "m-scene-water_table": "measured", "s-light-beam": "cosine-power", "s-port-geometry": "flat", "m-physics": "paper",
    "m-practice": "recommended", "m-objective": "cost", "m-scene-sun_elevation_deg": "20", "s-port-thickness_mm": "20",
    "s-settings-focus_distance_m": "1.2", "s-settings-frame_rate_hz": "7",
}  # fmt: skip


def other(control: Control, text: str) -> str:
    """Another value of a control."""
    if control.id in OTHER:
        return OTHER[control.id]
    if not text:
        assert control.low is not None and control.high is not None
        return f"{0.6 * control.low + 0.4 * control.high:.3g}"
    return f"{0.8 * float(text):.6g}" if "." in text else str(int(0.8 * float(text)))
