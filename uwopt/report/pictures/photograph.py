"""A test chart on the floor as a design would photograph it: an illustration made of the model's figures.

What is applied: the transfer function of `model.sharpness` (pixel, diffraction, motion, defocus, the
lens's rating, lateral colour), the fall-off of light over the image, the veils, the channels' own
electrons (the colour cast of water and lamp, no white balance), shot noise, read noise, dark current, PRNU,
gain, black level, full well and the digital numbers of the sensor. What is not: shadows, relief,
demosaicing (each pixel has all its channels), distortion, and the phase of lateral colour. The chart is in
`chart`: 1 is the plain floor of the mission. Shown as sRGB; a dark picture is brightened until the plain
floor in the middle has a quarter of white, and `brightened` says how much.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from uwopt.arrays import Array
from uwopt.evaluation.figures_by_name import field_of_view_m
from uwopt.evaluation.recompute import Replay
from uwopt.forward.sharpness import sharpness_of
from uwopt.model import sensor, sharpness
from uwopt.model.lateral import SpreadTable
from uwopt.model.sharpness import Gain, Sharpness
from uwopt.report.pictures.chart import BOARD_WIDTH, nice_unit_mm, scene_reflectance
from uwopt.report.pictures.curves import is_colour
from uwopt.report.pictures.maps import ImageField, channel_fields

Place = Literal["centre", "corner"]

DETAIL_WIDTH_PX, DETAIL_HEIGHT_PX = 160, 120
SHOWN_WIDTH_PX, SHOWN_HEIGHT_PX = 480, 360
FINE = 5  # samples of a pixel's side, odd: one lies in the pixel's middle
MARGIN_PX = 12  # around a detail, so that its edges are blurred with what lies beyond
WHOLE_WIDTH_PX = 400
FIELD_POINTS = 25  # a side, between which light and veil are interpolated
WHOLE_BOARD_SHARE = 0.5  # of the image's width on the floor
CHART_WHITE = 0.3  # of white, at which the chart's plain floor is shown
LEAST_LEVEL = 0.25  # of white, of the plain floor in a picture
MONO_WEIGHTS = np.array([0.25, 0.5, 0.25])
SEED = 4


@dataclass(frozen=True)
class Sensing:
    """What turns electrons of one exposure into digital numbers."""

    read_noise_e: float
    dark_e: float
    prnu_frac: float
    gain_dn_per_e: float
    black_dn: float
    full_scale_dn: float
    well_e: float


@dataclass(frozen=True)
class View:
    """A chart and its picture, (height, width, 3) in sRGB, with what was applied."""

    chart: NDArray[np.uint8]
    picture: NDArray[np.uint8]
    unit_mm: float  # of the chart
    width_mm: float  # of floor that is shown
    pixels_across: float  # of the camera, over the width shown
    brightened: float  # 1: as the camera's numbers are
    snr_db: float | None  # of the plain floor in the middle of what is shown
    mtf_half_nyquist: float
    veil_share: float  # of all light there
    level: float  # of full scale, plain floor there
    motion_blur_px: float
    defocus_px: float
    lateral_colour_px: float  # rms, along the radius
    vertical_motion: bool

    @property
    def applied(self) -> str:
        """What was applied, in one line."""
        numbers = [
            f"motion blur {self.motion_blur_px:.2g} px ({'upward' if self.vertical_motion else 'to the right'})",
            f"defocus {self.defocus_px:.2g} px",
            *([f"lateral colour {self.lateral_colour_px:.2g} px rms"] if self.lateral_colour_px > 0 else []),
            f"contrast at half Nyquist {100 * self.mtf_half_nyquist:.0f} %",
            f"veil {100 * self.veil_share:.2g} % of the light",
            "no signal" if self.snr_db is None else f"SNR {self.snr_db:.1f} dB",
            f"plain floor at {100 * self.level:.2g} % of full scale",
        ]
        return "; ".join(numbers)


# ---------------------------------------------------------------- views


def whole_view(design: Replay, scene_index: int = 0) -> View:
    """The whole image, shrunk: each pixel shown is the mean of a block, and its noise that of the mean.

    It is as wide as the design's figures say: what a lens that moves as a whole still sees at this focus.
    """
    cam, settings = design.model.cameras, design.settings[scene_index]
    view = design.model.view_at(scene_index, float(settings.dioptre_per_m[0]))
    full_x, full_y = float(cam.resolution_x_px[0]), float(cam.resolution_y_px[0])
    width = int(min(WHOLE_WIDTH_PX, full_x))
    height = max(round(width * full_y / full_x), 1)
    block_px = full_x / width
    step_mm = field_of_view_m(view, design.model.hardware.landscape)[0] * 1e3 / width
    unit_mm = nice_unit_mm(WHOLE_BOARD_SHARE * width * step_mm / BOARD_WIDTH)
    fine = rendered(width, height, step_mm, unit_mm, 2)
    chart = fine.reshape(height, 2, width, 2, 3).mean(axis=(1, 3))
    at = sharpness_at(design, scene_index, "centre")
    nodes = np.linspace(-1.0, 1.0, FIELD_POINTS)
    lit = [
        ImageField(*(spread_over(part, width, height) for part in (field.signal_e, field.veil_e)))
        for field in channel_fields(design, *points(design, nodes, nodes), scene_index).values()
    ]
    blurred = blur(
        as_seen(design, chart), at, upward=design.model.hardware.landscape, pixels_a_sample=block_px,
        detail=detail_at(design, scene_index),
    )  # fmt: skip
    middle = channel_fields(design, np.zeros((1, 1)), np.zeros((1, 1)), scene_index)
    return exposed_view(
        design, scene_index, chart, blurred, lit, list(middle.values()), at, unit_mm=unit_mm,
        width_mm=width * step_mm, pixels_across=full_x, block_px=block_px,
    )  # fmt: skip


def detail_view(
    design: Replay, scene_index: int = 0, *, place: Place = "centre", width_mm: float | None = None
) -> View:
    """A crop pixel by pixel, enlarged; `width_mm` of floor, or 160 pixels of it.

    With the same `width_mm` the crops of several designs show the same piece of chart.
    """
    model = design.model
    view, cam = model.views[scene_index], model.cameras
    gsd_mm = float(view.gsd_m[0, 1]) * 1e3
    width = DETAIL_WIDTH_PX if width_mm is None else round(width_mm / gsd_mm)
    width = int(np.clip(width, 16, SHOWN_WIDTH_PX))
    height = max(round(width * DETAIL_HEIGHT_PX / DETAIL_WIDTH_PX), 1)
    covered_mm = width * gsd_mm if width_mm is None else width_mm
    step_mm = covered_mm / width
    unit_mm = nice_unit_mm(covered_mm / DETAIL_WIDTH_PX)
    fine = rendered(width + 2 * MARGIN_PX, height + 2 * MARGIN_PX, step_mm, unit_mm, FINE)
    at = sharpness_at(design, scene_index, place)
    image = blur(
        as_seen(design, fine), at, upward=model.hardware.landscape, pixels_a_sample=1.0 / FINE,
        detail=detail_at(design, scene_index),
    )  # fmt: skip
    inner = slice(MARGIN_PX, -MARGIN_PX)
    image = image[FINE // 2 :: FINE, FINE // 2 :: FINE][inner, inner]
    blocks = fine.reshape(height + 2 * MARGIN_PX, FINE, width + 2 * MARGIN_PX, FINE, 3)
    chart = blocks.mean(axis=(1, 3))[inner, inner]
    share = 0.0
    if place == "corner":
        share = max(0.0, 1.0 - width / float(cam.resolution_x_px[0]))
    here = channel_fields(design, np.full((1, 1), share), np.full((1, 1), share), scene_index)
    lit = list(here.values())
    made = exposed_view(
        design, scene_index, chart, image, lit, lit, at, unit_mm=unit_mm, width_mm=covered_mm,
        pixels_across=width, block_px=1.0,
    )  # fmt: skip
    return replace(made, chart=enlarged(made.chart), picture=enlarged(made.picture))


def as_seen(design: Replay, reflectance: Array) -> Array:
    """Reflectance in the camera's channels: three, or their mean (R + 2G + B)/4 for a mono sensor."""
    return reflectance if is_colour(design) else (reflectance @ MONO_WEIGHTS)[..., None]


def points(design: Replay, u: Array, v: Array) -> tuple[Array, Array]:
    """Shares along and across of points of the picture, u to the right and v downward; see `maps.image_points`."""
    right, down = np.meshgrid(u, v)
    return (-down, right) if design.model.hardware.landscape else (right, down)


@lru_cache(maxsize=2)  # the middle and the corner of an image are the same piece of chart
def rendered(width: int, height: int, step_mm: float, unit_mm: float, fine: int) -> Array:
    """Chart and floor, `fine` samples a pixel's side."""
    x = (np.arange(width * fine) - 0.5 * (width * fine - 1)) * (step_mm / fine)
    y = (np.arange(height * fine) - 0.5 * (height * fine - 1)) * (step_mm / fine)
    made = scene_reflectance(x, y, unit_mm=unit_mm)
    made.flags.writeable = False
    return made


def exposed_view(
    design: Replay, scene_index: int, chart: Array, image: Array, lit: list[ImageField], middle: list[ImageField],
    at: Sharpness, *, unit_mm: float, width_mm: float, pixels_across: float, block_px: float,
) -> View:  # fmt: skip
    """Expose a blurred chart and make it visible."""
    sensing = sensing_of(design, scene_index)
    rng = np.random.default_rng(SEED)
    numbers = np.stack(
        [
            exposed_dn(image[..., n] * field.signal_e + field.veil_e, sensing, rng=rng, block_px=block_px)
            for n, field in enumerate(lit)
        ],
        axis=2,
    )
    weights = MONO_WEIGHTS if len(lit) == 3 else np.ones(1)
    signal, veil = (
        float(weights @ [float(np.mean(getattr(f, name))) for f in middle]) for name in ("signal_e", "veil_e")
    )
    white = sensing.full_scale_dn - sensing.black_dn
    level = sensing.gain_dn_per_e * (signal + veil + sensing.dark_e) / white
    brightened = max(1.0, LEAST_LEVEL / level) if level > 0 else 1.0
    snr = float(
        sensor.snr(
            signal, veil_e=veil, read_noise_e=sensing.read_noise_e, gain_dn_per_e=sensing.gain_dn_per_e,
            dark_e=sensing.dark_e, prnu_frac=sensing.prnu_frac,
        )
    )  # fmt: skip
    return View(
        chart=srgb(CHART_WHITE * chart),
        picture=srgb(np.repeat((numbers - sensing.black_dn) / white * brightened, 3 // len(lit), axis=2)),
        unit_mm=unit_mm,
        width_mm=width_mm,
        pixels_across=pixels_across,
        brightened=brightened,
        snr_db=20.0 * float(np.log10(snr)) if snr > 0 else None,
        mtf_half_nyquist=float(np.min(sharpness.mtf_half_nyquist(at))),
        veil_share=veil / (signal + veil) if signal + veil > 0 else 0.0,
        level=level,
        motion_blur_px=float(np.max(at.motion_blur_px)),
        defocus_px=float(np.max(at.defocus_px)),
        lateral_colour_px=lateral_colour_px(at),
        vertical_motion=design.model.hardware.landscape,
    )


# ---------------------------------------------------------------- sharpness


def sharpness_at(design: Replay, scene_index: int, place: Place) -> Sharpness:
    """What blurs at the centre or in a corner of the image, at the nominal altitude, as set.

    A corner has its colours and its curved image even where physics `auto` left them out of the figures:
    they are nothing to a mission that asks nothing of its corners, but they show.
    """
    model, settings = design.model, design.settings[scene_index]
    hw, effects = model.hardware, replace(model.problem.effects, lateral_colour=True, image_curvature=True)
    rows = sharpness_of(
        model.problem.with_effects(effects), scene_index,
        model.view_at(scene_index, float(settings.dioptre_per_m[0])), camera=np.array([hw.camera]),
        lens=np.array([hw.lens]), port=np.array([hw.port]), optics=model.optics,
        dioptre_per_m=settings.dioptre_per_m, at_corner=place == "corner",
    )  # fmt: skip
    figures = model.figures(scene_index, settings)
    (group, table), *_ = rows.groups("place")
    return rows.at(
        group, table, f_number=settings.f_number, working_f_number=figures.working_f_number, blur_s=figures.smear_s,
        field="place",
    )  # fmt: skip


def detail_at(design: Replay, scene_index: int) -> Gain | None:
    """What detail of a frequency has in light scattered nearly forward, nominal altitude; None: nothing."""
    dioptre = float(design.settings[scene_index].dioptre_per_m[0])
    if design.model.problem.scenes[scene_index].paper:
        return None
    return design.model.sharp_rows(scene_index, dioptre).detail_gain(altitude=1)


def lateral_colour_px(at: Sharpness) -> float:
    """Electron-weighted rms of the spread of colours, to first order; see `lateral.radius_slope_px`."""
    if not isinstance(at.spread, SpreadTable):
        return 0.0
    slope = float(np.max(np.hypot(at.lateral_k_along, at.lateral_k_across))) / (2.0 * np.pi)
    return slope * at.spread.index_rms


def blur(
    samples: Array, at: Sharpness, *, upward: bool, pixels_a_sample: float, detail: Gain | None = None
) -> Array:
    """An image (m, n, channels) through the transfer function, by Fourier transform.

    `upward`: the motion runs along the picture's height, else along its width. Frequencies of the
    samples become cycles per camera pixel by `pixels_a_sample`. `detail`: on what varies, as a factor by frequency.
    """
    rows, columns = samples.shape[:2]
    turns = np.arange(rows)
    if at.spread is None:  # but for colours, detail blurs alike whichever way it leans: half of the rows tell all
        turns = np.minimum(turns, rows - turns)
    down = np.fft.fftfreq(rows)[: turns.max() + 1, None] / pixels_a_sample
    right = np.fft.rfftfreq(columns)[None, :] / pixels_a_sample
    along, across = (-down, right) if upward else (right, down)
    along, across = np.broadcast_arrays(along, across)
    transfer = sharpness.mtf(along, across_cyc_per_px=across, sharpness=at)
    if detail is not None:  # what is even is in the veil
        frequency = np.hypot(along, across)
        transfer = transfer * np.where(frequency > 0.0, detail(frequency), 1.0)
    transfer = transfer[turns]
    parts = [
        np.fft.irfft2(np.fft.rfft2(samples[..., n]) * transfer, s=(rows, columns))
        for n in range(samples.shape[2])
    ]
    return np.stack(parts, axis=2)


# ---------------------------------------------------------------- sensor


def sensing_of(design: Replay, scene_index: int) -> Sensing:
    """The camera as set in a scene."""
    cam, settings = design.model.cameras, design.settings[scene_index]
    return Sensing(
        read_noise_e=float(cam.read_noise_e[0]),
        dark_e=float(cam.dark_current_e_s[0] * settings.exposure_s[0]),
        prnu_frac=float(cam.prnu_frac[0]),
        gain_dn_per_e=float(cam.gain_dn_per_e[0] * settings.gain[0]),
        black_dn=float(cam.black_level_dn[0]),
        full_scale_dn=float(2.0 ** cam.bits[0] - 1.0),
        well_e=float(cam.saturation_e[0]),
    )


def exposed_dn(light_e: Array, sensing: Sensing, *, rng: np.random.Generator, block_px: float = 1.0) -> Array:
    """Digital numbers of pixels that mean `light_e` electrons of light.

    y = round(K (min(Poisson(mu + dark) + PRNU, well) + read noise) + black level), within full scale

    With `block_px` above 1 each number is the mean over a block of that side: noise of every kind falls with
    the side (a normal distribution), and the mean is not rounded.
    """
    mean_e = np.maximum(light_e, 0.0)
    uneven = sensing.prnu_frac * mean_e * rng.standard_normal(mean_e.shape)
    if block_px > 1.0:
        spread = np.sqrt(mean_e + sensing.dark_e + sensing.read_noise_e**2)
        noise = (spread * rng.standard_normal(mean_e.shape) + uneven) / block_px
        collected = np.minimum(mean_e + sensing.dark_e, sensing.well_e) + noise
        numbers = sensing.gain_dn_per_e * collected + sensing.black_dn
        return np.clip(numbers, 0.0, sensing.full_scale_dn)
    collected = rng.poisson(np.minimum(mean_e, 1e15) + sensing.dark_e) + uneven
    collected = np.minimum(collected, sensing.well_e)
    collected = collected + sensing.read_noise_e * rng.standard_normal(mean_e.shape)
    numbers = np.round(sensing.gain_dn_per_e * collected + sensing.black_dn)
    return np.clip(numbers, 0.0, sensing.full_scale_dn)


# ---------------------------------------------------------------- arrays


def spread_over(grid: Array, width: int, height: int) -> Array:
    """A field given on a grid with its edges, at the middles of an image's pixels; linear between."""
    out = grid
    for axis, count in ((0, height), (1, width)):
        place = (np.arange(count) + 0.5) / count * (out.shape[axis] - 1)
        low = np.minimum(place.astype(int), out.shape[axis] - 2)
        share = np.expand_dims(place - low, 1 - axis)
        out = np.take(out, low, axis) * (1.0 - share) + np.take(out, low + 1, axis) * share
    return out


def enlarged(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Every pixel as a square, the whole at the size that details are shown."""
    rows = np.arange(SHOWN_HEIGHT_PX) * image.shape[0] // SHOWN_HEIGHT_PX
    columns = np.arange(SHOWN_WIDTH_PX) * image.shape[1] // SHOWN_WIDTH_PX
    return image[rows][:, columns]


def srgb(linear: Array) -> NDArray[np.uint8]:
    """Linear shares of white as sRGB numbers (IEC 61966-2-1)."""
    share = np.clip(linear, 0.0, 1.0)
    curved = np.where(share <= 0.0031308, 12.92 * share, 1.055 * share ** (1.0 / 2.4) - 0.055)
    return np.asarray(np.round(255.0 * curved), np.uint8)
