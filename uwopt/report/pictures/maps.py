"""Light and signal-to-noise ratio over the image and the floor, as maps of one design.

The model's own field functions at the middles of a grid of cells, at the nominal altitude; physics
`paper` knows no field and has no maps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwopt.arrays import Array
from uwopt.evaluation.recompute import Replay
from uwopt.forward.figures import open_s
from uwopt.forward.lamps import luminous_weight
from uwopt.model import sensor
from uwopt.model.footprint import floor_area_ratio, floor_illuminance_per_lm
from uwopt.model.image_mean import cells
from uwopt.model.imaging import floor_point
from uwopt.report.pictures.curves import CHANNELS, is_colour, lamp_field, sun_field
from uwopt.tolerances import SATISFIED_REL
from uwopt.units import ratio_to_db

COLUMNS, ROWS = 48, 36
BEYOND = 1.3  # sides of the floor's map over those of the footprint
EDGE_POINTS = 25  # a side of the footprint's outline


@dataclass(frozen=True)
class ImageField:
    """Mean electrons of one pixel at field points: what forms the image, and what veils it."""

    signal_e: Array
    veil_e: Array  # 0 where the model leaves veils out


@dataclass(frozen=True)
class ImageMap:
    """SNR and electrons over the image, (rows, columns) of cells; columns run along the image's width."""

    x_px: Array
    y_px: Array
    signal_e: Array
    veil_e: Array
    snr: Array
    mean_level: Array
    saturated: NDArray[np.bool_]  # the plain floor is clipped there, so that nothing can be told from noise

    @property
    def snr_db(self) -> Array:
        """SNR in decibels; NaN where the pixel is saturated."""
        return np.where(self.saturated, np.nan, ratio_to_db(self.snr))


@dataclass(frozen=True)
class FloorMap:
    """Illuminance of the floor while the lamps shine, over the footprint and somewhat beyond.

    x across the track to starboard, y forward from where the camera's axis meets it; (n_y, n_x).
    """

    across_m: Array
    along_m: Array
    illuminance_lx: Array
    outline_across_m: Array  # of the footprint, closed
    outline_along_m: Array
    mean_lx: float  # over the footprint's cells
    least_lx: float


def field_at(
    design: Replay, along: Array, across: Array, scene_index: int = 0, channel: str | None = None
) -> ImageField:
    """Electrons at field points, given as shares -1..1 of the image's half sides along and across the motion.

    Lamps and sun, as set. In physics `paper` every point is the axis.
    """
    model, settings = design.model, design.settings[scene_index]
    view, rows = model.views[scene_index], model.rows[scene_index]
    figures = model.figures(scene_index, settings)
    light_x = float(figures.light_x[0]) * float(model.lights.output_factor[0])
    if model.problem.paper:
        light = model.image_light(scene_index, channel=channel).signal_e
        signal = np.full(np.shape(along), float(light[0, model.problem.scenes[scene_index].nominal]))
        signal = signal * float(figures.light_x[0])
        return ImageField(signal, np.zeros_like(signal))
    field = lamp_field(design, scene_index, channel)
    places = (view.tan_along[:, None] * np.ravel(along), view.tan_across[:, None] * np.ravel(across))
    lamps, over = field.at_pixels(view, *places, veils=True)
    signal = lamps[0, 0] * light_x
    veil = np.zeros_like(signal) if over is None else over[0, 0] * light_x
    if rows.sun is not None:
        sun = sun_field(design, scene_index, channel)
        open_y = float(open_s(rows, settings)[0] / np.square(figures.working_f_number[0]))
        daylight = sun.at_points(view, *places)[0][0] * open_y
        signal, veil = signal + daylight[..., 0], veil + daylight[..., 1] + daylight[..., 2]
    return ImageField(signal.reshape(np.shape(along)), veil.reshape(np.shape(along)))


def channel_fields(
    design: Replay, along: Array, across: Array, scene_index: int = 0
) -> dict[str, ImageField]:
    """The same for each colour channel; a mono sensor has one, `mono`."""
    if not is_colour(design):
        return {"mono": field_at(design, along, across, scene_index)}
    return {name: field_at(design, along, across, scene_index, channel=name) for name in CHANNELS}


def image_map(
    design: Replay, scene_index: int = 0, *, columns: int = COLUMNS, rows: int = ROWS
) -> ImageMap | None:
    """SNR over the image; None in physics `paper`."""
    model, settings = design.model, design.settings[scene_index]
    if model.problem.paper:
        return None
    along, across = image_points(design, columns, rows)
    there = field_at(design, along, across, scene_index)
    cam = model.cameras
    gain = float(cam.gain_dn_per_e[0] * settings.gain[0])
    dark = float(cam.dark_current_e_s[0] * settings.exposure_s[0])
    snr = sensor.snr(
        there.signal_e, veil_e=there.veil_e, read_noise_e=float(cam.read_noise_e[0]), gain_dn_per_e=gain,
        dark_e=dark, prnu_frac=float(cam.prnu_frac[0]),
    )  # fmt: skip
    every_e = there.signal_e + there.veil_e + dark
    level = sensor.mean_level(
        there.signal_e + there.veil_e, gain_dn_per_e=gain, bits=float(cam.bits[0]), dark_e=dark,
        offset_dn=float(cam.black_level_dn[0]),
    )  # fmt: skip
    u, v = cells(columns)[0], cells(rows)[0]
    return ImageMap(
        x_px=0.5 * (u + 1.0) * float(cam.resolution_x_px[0]),
        y_px=0.5 * (v + 1.0) * float(cam.resolution_y_px[0]),
        signal_e=there.signal_e,
        veil_e=there.veil_e,
        snr=np.asarray(snr),
        mean_level=np.asarray(level),
        saturated=np.maximum(level, every_e / float(cam.saturation_e[0])) > 1.0 + SATISFIED_REL,
    )


def image_points(design: Replay, columns: int, rows: int) -> tuple[Array, Array]:
    """Shares along and across the motion of the middles of an image's cells, (rows, columns) each.

    The image is held so that forward is up (landscape) or to the right (portrait), starboard right or down.
    """
    u, v = np.meshgrid(cells(columns)[0], cells(rows)[0])
    return (-v, u) if design.model.hardware.landscape else (u, v)


def floor_map(design: Replay, scene_index: int = 0) -> FloorMap | None:
    """Illuminance by the lamps over the footprint and around it; None without lamps, and in physics `paper`."""
    model, settings = design.model, design.settings[scene_index]
    problem, hw = model.problem, model.hardware
    if problem.paper or model.unlit:
        return None
    scene, view, shape = problem.scenes[scene_index], model.views[scene_index], model.shapes[scene_index]
    range_m = float(scene.range_m[scene.nominal])
    item = problem.optics[model.optics]
    lumens = model.lumens(float(settings.level[0]))
    tan_along, tan_across = float(view.tan_along[0]), float(view.tan_across[0])

    secant = float(np.hypot(1.0, shape.slope))  # along the floor, of a tilted one too

    def lux(along_m: Array, y_m: Array) -> Array:
        return lumens * floor_illuminance_per_lm(
            along_m / secant, y_m, slope=shape.slope, range_m=range_m, lamps=hw.mount.lamps(hw.count),
            beam=problem.floor_lobe(scene_index, model.optics, hw.mount, range_m),
            weight=luminous_weight(scene, item),
            attenuation_per_m=problem.lamp_leg_per_m(scene_index, model.optics),
        )  # fmt: skip

    def traced(along: Array, across: Array) -> tuple[Array, Array]:
        x_m, y_m, _ = floor_point(along, across, shape=shape, range_m=range_m)
        return np.asarray(x_m * secant), np.asarray(y_m)

    way = np.linspace(-1.0, 1.0, EDGE_POINTS)
    one = np.ones(EDGE_POINTS)
    ring_along = tan_along * np.concatenate([way, one, -way, -one])
    ring_across = tan_across * np.concatenate([-one, way, one, -way])
    edge_along, edge_across = traced(ring_along, ring_across)
    near_m, far_m = float(edge_along.min()), float(edge_along.max())
    along_m = 0.5 * (near_m + far_m) + np.linspace(-1.0, 1.0, ROWS) * BEYOND * 0.5 * (far_m - near_m)
    across_m = np.linspace(-1.0, 1.0, COLUMNS) * BEYOND * float(edge_across.max())
    around = lux(*np.meshgrid(along_m, across_m, indexing="ij"))
    cell_along, cell_across = np.meshgrid(
        tan_along * cells(ROWS)[0], tan_across * cells(COLUMNS)[0], indexing="ij"
    )
    inside = lux(*traced(cell_along, cell_across))
    area = floor_area_ratio(cell_along, cell_across, shape=shape, range_m=range_m)
    return FloorMap(
        across_m=across_m,
        along_m=along_m,
        illuminance_lx=around,
        outline_across_m=edge_across,
        outline_along_m=edge_along,
        mean_lx=float((inside * area).sum() / area.sum()),
        least_lx=float(inside.min()),
    )
