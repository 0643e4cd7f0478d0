"""Which parts fit together: mounts, image circles, depth ratings, interfaces.

The array functions serve the search (plain NumPy, broadcasting); `explain_pair` says in words,
with numbers, why parts of one system do not fit. What an inline part leaves out is not checked.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwopt.catalog.records import Camera, Lens, Light, Port
from uwopt.units import format_quantity

#: Share by which a sensor's diagonal may exceed the lens's image circle: formats are rounded names.
IMAGE_CIRCLE_TOLERANCE_FRAC = 0.02

#: Names of mounts that mean the same thread.
MOUNT_SYNONYMS = {"M12": "S", "S-MOUNT": "S", "C-MOUNT": "C", "CS-MOUNT": "CS", "F-MOUNT": "F"}

#: A camera's mount -> lens mounts it takes besides its own. CS takes a C lens with a 5 mm ring; the
#: reverse would need the lens 5 mm inside the camera.
TAKES_ALSO = {"CS": ("C",)}

BYTES_PER_MB = 1e6


def canonical_mount(name: str) -> str:
    """One spelling per mount: `M12` and `S-mount` are `S`."""
    upper = name.strip().upper()
    return MOUNT_SYNONYMS.get(upper, upper)


def accepted_mounts(camera_mounts: Iterable[str]) -> frozenset[str]:
    """Lens mounts that a camera with these mounts takes."""
    own = {canonical_mount(mount) for mount in camera_mounts}
    return frozenset(own.union(*(TAKES_ALSO.get(mount, ()) for mount in own)))


def mount_compatible(
    camera_mounts: Sequence[Iterable[str]], lens_mounts: Sequence[Iterable[str]]
) -> NDArray[np.bool_]:
    """Whether each lens screws onto each camera; (n_camera, n_lens). Unknown mounts fit nothing."""
    accepted = [accepted_mounts(mounts) for mounts in camera_mounts]
    offered = [frozenset(canonical_mount(mount) for mount in mounts) for mounts in lens_mounts]
    bit = {name: np.int64(1) << i for i, name in enumerate(sorted(frozenset().union(*accepted, *offered)))}
    accepted_bits = np.array([sum(bit[m] for m in mounts) for mounts in accepted], dtype=np.int64)
    offered_bits = np.array([sum(bit[m] for m in mounts) for mounts in offered], dtype=np.int64)
    return np.asarray((accepted_bits[:, None] & offered_bits[None, :]) != 0)


def sensor_diagonal_mm(
    resolution_x_px: ArrayLike, resolution_y_px: ArrayLike, pixel_pitch_um: ArrayLike
) -> NDArray[np.float64]:
    """Diagonal of the sensor's active area."""
    pixels = np.hypot(np.asarray(resolution_x_px, float), np.asarray(resolution_y_px, float))
    return np.asarray(pixels * np.asarray(pixel_pitch_um, float) * 1e-3)


def image_circle_ok(diagonal_mm: ArrayLike, circle_mm: ArrayLike) -> NDArray[np.bool_]:
    """Whether the lens lights the whole sensor; a circle of NaN is unknown and never passes."""
    limit_mm = np.asarray(circle_mm, float) * (1.0 + IMAGE_CIRCLE_TOLERANCE_FRAC)
    return np.asarray(np.asarray(diagonal_mm, float) <= limit_mm)


def data_rate_mb_s(
    resolution_x_px: ArrayLike, resolution_y_px: ArrayLike, bit_depth: ArrayLike, frame_rate_hz: ArrayLike
) -> NDArray[np.float64]:
    """Image data per second, 10^6 byte/s; 10 and 12 bit are sent packed."""
    bits = (
        np.asarray(resolution_x_px, float) * np.asarray(resolution_y_px, float) * np.asarray(bit_depth, float)
    )
    return np.asarray(bits / 8.0 * np.asarray(frame_rate_hz, float) / BYTES_PER_MB)


@dataclass(frozen=True, slots=True)
class Finding:
    """One misfit: the rule's name, what is wrong in numbers, and whether it forbids the system."""

    rule: str
    message: str
    severity: Literal["fault", "warning"] = "fault"


def explain_pair(
    camera: Camera,
    lens: Lens,
    port: Port | None = None,
    light: Light | None = None,
    *,
    required_depth_m: float | None = None,
    frame_rate_hz: float | None = None,
) -> list[Finding]:
    """Every misfit of these parts, faults first; empty when they fit as far as is known."""
    findings = [
        *_tie_findings(camera, lens, port),
        *_mount_findings(camera, lens),
        *_image_circle_findings(camera, lens),
        *_sharpness_findings(camera, lens),
        *_interface_findings(camera, frame_rate_hz),
        *_shutter_findings(camera),
        *(_supply_findings(light) if light is not None else ()),
        *(f for part in (port, light) if part is not None for f in _depth_findings(part, required_depth_m)),
    ]
    return sorted(findings, key=lambda finding: finding.severity)


def _tie_findings(camera: Camera, lens: Lens, port: Port | None) -> list[Finding]:
    """Pieces of a complete camera go with each other alone."""
    pieces = [camera, lens, *([] if port is None else [port])]
    if len({part.complete for part in pieces}) == 1:
        return []
    torn = next(part for part in pieces if part.complete)
    text = f"{torn.id} is a piece of the complete camera {torn.complete}, and goes with no other part"
    return [Finding("complete", text)]


def _mount_findings(camera: Camera, lens: Lens) -> list[Finding]:
    if (camera.inline and not camera.mounts) or (lens.inline and not lens.mounts):
        return []
    if not camera.mounts or not lens.mounts:
        nameless = camera.id if not camera.mounts else lens.id
        return [Finding("mount", f"the mount of {nameless} is unknown, so nothing is known to fit it")]
    if mount_compatible([camera.mounts], [lens.mounts])[0, 0]:
        return []
    return [
        Finding(
            "mount",
            f"{lens.id} has {' or '.join(lens.mounts)} mount, {camera.id} takes "
            f"{' or '.join(sorted(accepted_mounts(camera.mounts)))}",
        )
    ]


def _image_circle_findings(camera: Camera, lens: Lens) -> list[Finding]:
    if lens.image_circle_mm is None:
        if lens.inline:
            return []
        return [Finding("image circle", f"the image circle of {lens.id} is unknown")]
    diagonal_mm = float(
        sensor_diagonal_mm(camera.resolution_x_px, camera.resolution_y_px, camera.pixel_pitch_um)
    )
    if image_circle_ok(diagonal_mm, lens.image_circle_mm):
        return []
    return [
        Finding(
            "image circle",
            f"{lens.id} lights {lens.image_circle_mm:.4g} mm, the sensor of {camera.id} measures "
            f"{diagonal_mm:.4g} mm across (allowed excess {IMAGE_CIRCLE_TOLERANCE_FRAC:.0%})",
        )
    ]


def rated_pitch_um(lens: Lens) -> float | None:
    """Pixel pitch a lens is made for: as stated, else half a line pair of its rated frequency."""
    if lens.rated_pixel_pitch_um is not None:
        return lens.rated_pixel_pitch_um
    if lens.rated_lp_per_mm is not None:
        return 1000.0 / (2.0 * lens.rated_lp_per_mm)
    return None


def _sharpness_findings(camera: Camera, lens: Lens) -> list[Finding]:
    pitch_um = rated_pitch_um(lens)
    if pitch_um is None or pitch_um <= camera.pixel_pitch_um * (1.0 + IMAGE_CIRCLE_TOLERANCE_FRAC):
        return []
    return [
        Finding(
            "lens rating",
            f"{lens.id} is rated for pixels of {pitch_um:.3g} um, those of {camera.id} are "
            f"{camera.pixel_pitch_um:.3g} um: the image is softer than the pixels could show",
            "warning",
        )
    ]


def _interface_findings(camera: Camera, frame_rate_hz: float | None) -> list[Finding]:
    if frame_rate_hz is None:
        return []
    findings = []
    if camera.max_frame_rate_hz is not None and frame_rate_hz > camera.max_frame_rate_hz.value:
        findings.append(
            Finding(
                "frame rate",
                f"{camera.id} reaches {format_quantity(camera.max_frame_rate_hz.value, 'hz', 4)}, "
                f"{format_quantity(frame_rate_hz, 'hz', 4)} is wanted",
            )
        )
    if camera.bandwidth_mb_s is not None:
        rate_mb_s = float(
            data_rate_mb_s(camera.resolution_x_px, camera.resolution_y_px, camera.bit_depth, frame_rate_hz)
        )
        if rate_mb_s > camera.bandwidth_mb_s.value:
            findings.append(
                Finding(
                    "interface",
                    f"{camera.interface or 'the interface'} of {camera.id} carries "
                    f"{camera.bandwidth_mb_s.value:.4g} MB/s, {format_quantity(frame_rate_hz, 'hz', 4)} at "
                    f"{camera.bit_depth} bit make {rate_mb_s:.4g} MB/s",
                )
            )
    return findings


def _shutter_findings(camera: Camera) -> list[Finding]:
    """A rolling shutter of which nothing tells how fast it reads."""
    if camera.shutter != "rolling" or camera.max_frame_rate_hz is not None or camera.bandwidth_mb_s is not None:
        return []
    text = (
        f"{camera.id} has a rolling shutter, and nothing tells how long it reads an image (max_frame_rate_hz): its "
        "skew is counted as 0, and lamps that pulse as if they lit all rows"
    )
    return [Finding("rolling shutter", text, "warning")]


def _supply_findings(light: Light) -> list[Finding]:
    """What feeds a lamp, and what fires a pulse or a flash."""
    found = []
    if light.supply == "battery":
        known = light.run_time_min is not None
        lasts = f"which lasts {light.run_time_min:g} min at full" if known else "of which nobody says how long it lasts"
        text = f"{light.id} has its own battery, {lasts}; it is set and switched by hand"
        found.append(Finding("lamp supply", text, "warning"))
    if light.kind != "continuous" and light.trigger == "none":
        found.append(Finding("trigger", f"nothing fires {light.id} with the camera"))
    elif light.kind != "continuous" and light.trigger == "optical":
        text = f"{light.id} is fired by the light of another flash, which must come from the camera's side"
        found.append(Finding("trigger", text, "warning"))
    return found


def _depth_findings(part: Port | Light, required_depth_m: float | None) -> list[Finding]:
    if required_depth_m is None:
        return []
    if part.depth_rating_m is None:
        if part.inline:
            return []
        return [
            Finding(
                "depth rating", f"the depth rating of {part.id} is unknown; {required_depth_m:g} m are needed"
            )
        ]
    if math.isfinite(part.depth_rating_m) and part.depth_rating_m < required_depth_m:
        return [
            Finding(
                "depth rating",
                f"{part.id} is rated to {part.depth_rating_m:g} m, {required_depth_m:g} m are needed",
            )
        ]
    return []
