"""Sharpness of designs in a scene: what MTF and information need beside the settings, and their figures.

MTF holds where the mission wants the image sharp: on the axis, or at the corner too (`dof_at`). Information is that
of the field point which stands for the whole image. `place`, `corner` and `rms` name these fields; at the corner
the disc is the larger of centre and corner, and colours and lens blur as they do at 80 % of the half diagonal.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property, partial
from typing import Any, Self

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.bars import Bars, Field
from uwopt.forward.columns import Columns, distinct, placed, rows_alike
from uwopt.forward.detail import DetailRows, detail_rows, shows_detail
from uwopt.forward.lamps import relative_spectrum
from uwopt.forward.motion import motion_along
from uwopt.forward.part_columns import Ports
from uwopt.forward.problem import Problem
from uwopt.forward.scene import SceneOptics
from uwopt.forward.spectra import TINY, Contraction
from uwopt.forward.views import CORNER_FIELD, RMS_FIELD, Views, altitudes_m, field_dioptres_per_m
from uwopt.model import aberration, information, lateral, operation, sharpness
from uwopt.model.defocus import defocus_px
from uwopt.model.lateral import SpreadRows, SpreadTable, spread_mtf
from uwopt.model.lens import airy_diameter_m
from uwopt.model.sharpness import (
    HALF_NYQUIST_CYC_PER_PX,
    RESOLVED_CONTRAST,
    Gain,
    GainOfSome,
    Sharpness,
)
from uwopt.model.spectrum import trapezoid_weights_nm


@dataclass(frozen=True)
class SharpRows(Columns):
    """What the sharpness of n designs depends on in one scene; (n, 3) at near, nominal and far altitude.

    Discs are those of f-number 1: a disc in pixels is this over the f-number as engraved.
    """

    wavelength_nm: Array  # electron-weighted mean
    pixel_pitch_m: Array
    rated_pitch_px: Array  # that the lens is rated for, over the camera's; 0: unknown
    aberration_px: Array  # the same of its aberrations, at f-number 1 (`model.aberration`)
    aberration_exponent: Array  # with which their square falls as the iris closes
    blur_px_per_s: Array  # (n, 3) along the motion
    place_disc_px: Array  # (n, 3) where MTF must hold
    corner_disc_px: Array  # (n, 3) centre and corner
    rms_disc_px: Array  # (n, 3) at the field point that stands for the image
    place_k_along: Array  # lateral colour, 0 behind a dome
    place_k_across: Array
    corner_k_along: Array
    corner_k_across: Array
    rms_k_along: Array
    rms_k_across: Array
    spread_index: Array
    pixel_area_m2: Array  # of the floor, nominal altitude
    gsd_m: Array  # (n, 3) largest pixel on the floor
    spreads: tuple[SpreadTable, ...]
    fineness: float = 1.0  # of integrals over spatial frequency
    place_lens_blur: float = 1.0  # of the lens where MTF must hold, over that on the axis
    detail: DetailRows | None = None  # of light scattered nearly forward; None: it shows none

    @classmethod
    def in_places(cls, parts: Sequence[tuple[Array | slice, Self]], count: int) -> Self:
        """Groups of rows put back in their places; tables that groups share are kept once."""
        columns: dict[str, Any] = {"place_lens_blur": parts[0][1].place_lens_blur if parts else 1.0}
        columns["detail"] = placed([(rows, part.detail) for rows, part in parts], count)
        spreads: dict[int, SpreadTable] = {}
        fineness = max((part.fineness for _, part in parts), default=1.0)
        for rows, part in parts:
            for table in part.spreads:
                spreads.setdefault(id(table), table)
            place = [list(spreads).index(id(table)) for table in part.spreads]
            for f in fields(part):
                value = getattr(part, f.name)
                if isinstance(value, np.ndarray):
                    column = columns.setdefault(f.name, np.empty((count, *value.shape[1:]), value.dtype))
                    if f.name == "spread_index":  # of a part without tables nobody asks
                        value = np.array(place)[value] if place else np.zeros_like(value)
                    column[rows] = value
        return cls(**columns, spreads=tuple(spreads.values()), fineness=fineness)

    def groups(self, field: Field) -> list[tuple[Array, SpreadTable | None]]:
        """Rows that share the colours they detect; None where no colour is spread at this field point."""
        along, across = self.colour(field)
        still = (along == 0) & (across == 0)
        found: list[tuple[Array, SpreadTable | None]] = [(np.nonzero(still)[0], None)]
        found += [
            (np.nonzero(~still & (self.spread_index == index))[0], self.spreads[int(index)])
            for index in np.unique(self.spread_index[~still])
        ]
        return [(rows, table) for rows, table in found if len(rows)]

    def colour(self, field: Field) -> tuple[Array, Array]:
        """Lateral colour along and across at a field point, k per cycle per px, (n,) each."""
        return getattr(self, f"{field}_k_along"), getattr(self, f"{field}_k_across")

    def asked(self, *, min_mtf: float, resolve_m: float) -> list[Bars]:
        """The bars whose contrast is asked for: at half the Nyquist frequency, and of a width on the floor; 0: none."""
        found: list[Bars] = []
        if min_mtf > 0.0:
            found.append(Bars(np.full_like(self.gsd_m, HALF_NYQUIST_CYC_PER_PX), "place", min_mtf))
        if resolve_m > 0.0:
            found.append(self.bars(self.gsd_m / (2.0 * resolve_m), least=RESOLVED_CONTRAST))
        return found

    def bars(self, frequency_cyc_per_px: Array, *, least: float) -> Bars:
        """Bars of which a share must be left in all light that arrives in the corner; frequencies (n, 3)."""
        detail = 1.0 if self.detail is None else self.detail.gain(frequency_cyc_per_px)
        return Bars(frequency_cyc_per_px, "corner", least, veiled=True, detail=detail)

    def detail_gain(self, rows: Array | slice = slice(None), altitude: int | slice = slice(None)) -> Gain | None:
        """What detail of a frequency has in light scattered nearly forward, of some rows; None: nothing."""
        return None if self.detail is None else partial(self.detail.gain, rows=rows, altitude=altitude)

    def detail_gain_of(self, rows: Array, altitude: Array) -> GainOfSome | None:
        """The same of rows at altitudes (m,), some of which are then asked for."""
        detail = self.detail
        if detail is None:
            return None
        return lambda frequency, some: detail.gain(frequency, rows=rows[some], altitude=altitude[some])

    @property
    def texture_gain(self) -> Array:
        """What light scattered nearly forward adds to the SNR that information is reckoned from, as a factor (n,)."""
        return np.ones(len(self.wavelength_nm)) if self.detail is None else self.detail.texture_gain

    def disc_px(self, field: Field) -> Array:
        """Disc of defocus at a field point and f-number 1, (n, 3)."""
        return np.asarray(getattr(self, f"{field}_disc_px"))

    def lens_blur(self, field: Field) -> float:
        """The lens's blur at a field point over that on the axis."""
        over_corner = {"place": 0.0, "corner": 1.0, "rms": float(RMS_FIELD) / CORNER_FIELD}[field]
        return self.place_lens_blur if field == "place" else float(aberration.field_blur(over_corner))

    def lens_pitch_px(self, field: Field, *, f_number: Array, rows: Array | slice = slice(None)) -> Array:
        """Pitch that the lens is good for at these f-numbers and a field point, over the camera's."""
        pitch = aberration.lens_pitch(
            self.rated_pitch_px[rows], aberration_f1_px=self.aberration_px[rows], f_number=f_number,
            exponent=self.aberration_exponent[rows], field_blur=self.lens_blur(field),
        )  # fmt: skip
        return np.asarray(pitch)

    def at(
        self, rows: Array | slice, spread: SpreadTable | SpreadRows | None, *, f_number: Array,
        working_f_number: Array, blur_s: Array, field: Field, altitude: int | slice | Array = 1,
    ) -> Sharpness:  # fmt: skip
        """The model's record of some rows, (n, n_altitudes) for a slice of them; the settings are those of all rows."""
        along, across = self.colour(field)
        blur, disc = self.blur_px_per_s[rows, altitude], self.disc_px(field)[rows, altitude]

        def each(column: Array) -> Array:
            return column.reshape(-1, *([1] * (disc.ndim - 1)))

        return Sharpness(
            working_f_number=each(working_f_number[rows]), wavelength_nm=each(self.wavelength_nm[rows]),
            pixel_pitch_m=each(self.pixel_pitch_m[rows]), motion_blur_px=blur * each(blur_s[rows]),
            defocus_px=disc / each(f_number[rows]),
            lens_pitch_px=each(self.lens_pitch_px(field, f_number=f_number[rows], rows=rows)),
            lateral_k_along=each(along[rows]), lateral_k_across=each(across[rows]), spread=spread,
        )  # fmt: skip

    def each(
        self, figure: Callable[[Sharpness, Array], Any], *, field: Field, altitude: int = 1, **settings: Array
    ) -> Array:
        """A figure of all rows, group by group."""
        out = np.empty(len(self.wavelength_nm))
        for rows, spread in self.groups(field):
            out[rows] = figure(self.at(rows, spread, field=field, altitude=altitude, **settings), rows)
        return out

    # ------------------------------------------------------------ figures

    def mtf_half_nyquist(self, *, f_number: Array, working_f_number: Array, blur_s: Array) -> Array:
        """Transfer at a quarter cycle per pixel where it must hold, (n, 3) by altitude."""
        at = self.at(
            slice(None), None, f_number=f_number, working_f_number=working_f_number, blur_s=blur_s, field="place",
            altitude=slice(None),
        )  # fmt: skip
        along, across = sharpness.mtf_axes(HALF_NYQUIST_CYC_PER_PX, sharpness=at)
        left = self.colour_left
        return np.minimum(along * left[:, :1], across * left[:, 1:])

    @cached_property
    def colour_left(self) -> Array:
        """What lateral colour leaves of the transfer at half the Nyquist frequency, along and across, (n, 2)."""
        left = np.ones((len(self.wavelength_nm), 2), order="F")
        for rows, table in self.groups("place"):
            for axis, k in enumerate(self.colour("place")):
                if table:
                    left[rows, axis] = spread_mtf(k[rows] * HALF_NYQUIST_CYC_PER_PX, table=table)
        return left

    def transfer(self, bars: Bars, *, f_number: Array, working_f_number: Array, blur_s: Array) -> Array:
        """What is left of the contrast of bars, even veil apart: the worse of along and across, (n, 3) by altitude."""
        settings = dict(f_number=f_number, working_f_number=working_f_number, blur_s=blur_s)

        def left(k: int, at: Sharpness, rows: Array) -> Array:
            frequency = bars.frequency_cyc_per_px[rows, k]
            both = sharpness.mtf_axes(frequency, sharpness=at, falling=bars.veiled)
            return bars.still(np.minimum(*both), frequency) * bars.detail_at(rows, k)

        return np.stack(
            [
                self.each(partial(left, k), field=bars.field, altitude=k, **settings)
                for k in range(bars.frequency_cyc_per_px.shape[1])
            ],
            axis=1,
        )

    def smallest_bars_m(
        self, contrast: Array, *, f_number: Array, working_f_number: Array, blur_s: Array
    ) -> Array:
        """Narrowest bars on the floor that arrive in the corner, veil counted; (n, 3), as is the contrast."""
        rows, altitude = (places.ravel() for places in np.indices(self.gsd_m.shape))
        along, across = self.colour("corner")
        spread = SpreadRows.of(self.spreads, self.spread_index[rows]) if (along.any() or across.any()) else None
        at = self.at(
            rows, spread, f_number=f_number, working_f_number=working_f_number, blur_s=blur_s, field="corner",
            altitude=altitude,
        )  # fmt: skip
        found = sharpness.smallest_bars_m(
            at, contrast=contrast[rows, altitude], ground_sample_m=self.gsd_m[rows, altitude],
            detail=self.detail_gain_of(rows, altitude),
        )  # fmt: skip
        return np.asarray(found.reshape(self.gsd_m.shape))

    def information_bit_per_m2(
        self, snr: Array, *, f_number: Array, working_f_number: Array, blur_s: Array,
        orders: tuple[int, int] | None = None,
    ) -> Array:  # fmt: skip
        """Information at the nominal altitude, (n,); `orders` as in the model, the usual ones unless given.

        Of the SNR of the image-forming light, to which detail of a middling frequency in the veil adds.
        """
        seen = snr * self.texture_gain
        per_px = self.each(
            lambda at, rows: information.information_bit_per_px(
                seen[rows], sharpness=at, fineness=self.fineness, orders=orders
            ), field="rms", f_number=f_number, working_f_number=working_f_number, blur_s=blur_s,
        )  # fmt: skip
        return np.asarray(information.information_bit_per_m2(per_px, pixel_area_m2=self.pixel_area_m2))

    def most_bit_per_px(
        self, gain: Array, *, f_number: Array, working_f_number: Array, blur_s: Array, widest_px: float,
        wanted: Array | None = None, fineness: float = 1.0,
    ) -> Array:  # fmt: skip
        """Information at some contrasts over the noise (k,), (n, k), at least: wide lateral colour may count as less.

        wanted : (n, k) which are worked out, the others nan; None: all
        fineness : factor on the nodes of the integrals, beside that of the rows

        What more than `widest_px` [px rms] of it leaves is taken to be as little as that width would, for a
        narrow ridge is dear to sum; a transfer that comes back after a null is taken never to have fallen.
        """
        out = np.empty((len(self.wavelength_nm), len(gain)))
        for rows, spread in self.groups("rms"):
            at = self.at(
                rows, spread, f_number=f_number, working_f_number=working_f_number, blur_s=blur_s, field="rms"
            )
            if spread is not None:
                along, across = at.lateral_k_along, at.lateral_k_across
                share = np.minimum(widest_px / np.maximum(lateral.rms_px(along, across, spread.index_rms), TINY), 1.0)
                spread = spread if (share == 1.0).all() else lateral.never_rising(spread)
                at = replace(at, lateral_k_along=share * along, lateral_k_across=share * across, spread=spread)
            out[rows] = information.information_of_gains(
                gain, sharpness=at, fineness=self.fineness * fineness,
                wanted=None if wanted is None else wanted[rows],
            )  # fmt: skip
        return out


def sharpness_of(
    problem: Problem, scene_index: int, view: Views, *, camera: Array, lens: Array, port: Array, optics: int,
    dioptre_per_m: Array, at_corner: bool | None = None,
) -> SharpRows:  # fmt: skip
    """What the sharpness of designs under one light depends on beside their settings, at a focus.

    at_corner : whether MTF must hold there, or on the axis alone; None: as the scene asks
    """
    scene, contraction = problem.scenes[scene_index], problem.contractions[scene_index]
    cameras, lenses, ports = problem.cameras.take(camera), problem.lenses.take(lens), problem.ports.take(port)
    pitch, spectrum = cameras.pixel_pitch_m, int(contraction.spectrum_of[optics])
    at_corner = scene.view.requirements.dof_at == "corner" if at_corner is None else at_corner
    on_axis, at_rms, in_corner = discs_px(problem, scene, view, pitch, dioptre_per_m)
    both = np.maximum(on_axis, in_corner)
    coloured = ~ports.is_dome & problem.effects.lateral_colour
    corner_k, rms_k = (
        lateral_k(scene, view, pitch, ports, share, coloured) for share in (CORNER_FIELD, float(RMS_FIELD))
    )
    still = np.zeros(len(pitch))
    place_k = corner_k if at_corner else (still, still)
    curves, index = distinct(cameras.qe_index)
    colours = [arriving(scene, contraction, spectrum, int(curve)) for curve in curves]
    wavelength = np.array([mean_wavelength_nm(scene, density) for density in colours])
    pixels = cameras.resolution_x_px * cameras.resolution_y_px
    detail = None
    if shows_detail(contraction, forward_veil=problem.effects.forward_veil):
        scattered = np.array([mean_of(scene, density, scene.particles_per_m()) for density in colours])
        detail = detail_rows(scene, view, pixels=pixels, scattering_per_m=scattered[index])
    return SharpRows(
        wavelength_nm=wavelength[index], pixel_pitch_m=pitch, rated_pitch_px=lenses.rated_pitch_m / pitch,
        aberration_px=lenses.aberration_f1_m / pitch, aberration_exponent=lenses.aberration_exponent,
        blur_px_per_s=motion_px_per_s(scene, view, ports.outer_radius_m),
        place_disc_px=both if at_corner else on_axis, corner_disc_px=both, rms_disc_px=at_rms,
        place_k_along=place_k[0], place_k_across=place_k[1], corner_k_along=corner_k[0], corner_k_across=corner_k[1],
        rms_k_along=rms_k[0], rms_k_across=rms_k[1], spread_index=np.asarray(index),
        pixel_area_m2=view.area_m2[:, 1] / pixels, gsd_m=view.gsd_m,
        spreads=tuple(spread_of(scene, contraction, spectrum, int(one)) for one in curves) if coloured.any() else (),
        fineness=scene.fineness.sharpness, place_lens_blur=float(aberration.field_blur(1.0 if at_corner else 0.0)),
        detail=detail,
    )  # fmt: skip


def discs_px(
    problem: Problem, scene: SceneOptics, view: Views, pitch: Array, dioptre_per_m: Array
) -> tuple[Array, Array, Array]:
    """Discs at a focus on the axis, at the field point that stands for the image, and in the corner, (n, 3) each.

    The larger of both images of the floor, of f-number 1. Of an even image all are that of the axis.
    """
    focal, altitudes = view.focal_length_m, altitudes_m(scene)
    imaged_at = np.where(focal * dioptre_per_m < 1.0, dioptre_per_m, 0.0)  # else N_w is infinite, MTF 0
    optical = dict(
        f_number=1.0, focal_length_m=focal[:, None, None], pixel_pitch_m=pitch[:, None, None],
        focus_dioptre_per_m=imaged_at[:, None, None],
    )  # fmt: skip

    def discs(places: Array) -> Array:
        dioptres = np.asfortranarray(field_dioptres_per_m(places, altitudes))
        return np.asarray(defocus_px(dioptres, **optical).max(axis=1))

    on_axis = discs(view.axis_image)
    if not problem.effects.image_curvature:
        return on_axis, on_axis, on_axis
    return on_axis, discs(view.rms_image), discs(view.corner_image)


def lateral_k(
    scene: SceneOptics, view: Views, pitch: Array, ports: Ports, share: float, coloured: Array
) -> tuple[Array, Array]:
    """Lateral colour along and across at a share of the half diagonal, k per cycle per px, (n,); 0 where there is none.

    coloured : behind which ports there is, (n,)
    """
    if not coloured.any():
        return np.zeros(len(pitch)), np.zeros(len(pitch))
    radius = np.hypot(view.tan_along, view.tan_across)
    tangent = radius * share
    slope = lateral.radius_slope_px(
        tangent, n_design=scene.n_water, focal_length_m=view.focal_length_m, pixel_pitch_m=pitch
    ) * lateral.finite_range_share(
        tangent, gap_m=ports.gap_m, thickness_m=ports.thickness_m, n_glass=ports.refractive_index,
        n_water=scene.n_water, range_m=float(scene.range_m[scene.nominal]),
    )  # fmt: skip
    k = np.where(coloured, 2.0 * np.pi * slope, 0.0)
    return k * view.tan_along / radius, k * view.tan_across / radius


def motion_px_per_s(scene: SceneOptics, view: Views, outer_radius_m: Array) -> Array:
    """How fast the image moves along the motion, (n, 3) at near, nominal and far altitude."""
    lever_m = altitudes_m(scene)[None, :] + outer_radius_m[:, None]
    return np.asfortranarray(operation.blur_px(1.0, ground_sample_m=view.pixel_along_m, **motion_along(scene, lever_m)))


def arriving(scene: SceneOptics, contraction: Contraction, spectrum: int, efficiency: int) -> Array:
    """Electrons by wavelength of the light that comes straight down and up at the nominal altitude, any scale."""
    key = ("arriving", *contraction.key(spectrum, efficiency, None))

    def made() -> Array:
        weight = contraction.weight(spectrum, efficiency)
        both = scene.attenuation_per_m + contraction.lamp_leg_per_m(spectrum)
        loss = both * float(scene.range_m[scene.nominal])
        seen = weight > 0
        least = float(loss[seen].min()) if seen.any() else 0.0
        return np.asarray(weight * np.exp(-np.maximum(loss - least, 0.0)))

    return scene.once(key, made)


def mean_wavelength_nm(scene: SceneOptics, arriving_e: Array) -> float:
    """Electron-weighted mean wavelength; the middle of the grid where nothing arrives."""
    return mean_of(scene, arriving_e, scene.wavelength_nm)


def mean_of(scene: SceneOptics, arriving_e: Array, spectrum: Array) -> float:
    """Electron-weighted mean of a spectrum; at the middle of the grid where nothing arrives."""
    if not arriving_e.sum() > TINY:
        return float(np.interp(scene.wavelength_nm.mean(), scene.wavelength_nm, spectrum))
    return float((arriving_e * spectrum).sum() / arriving_e.sum())


def airy_wavelength_nm(problem: Problem, scene_index: int, optics: int, efficiency: int) -> float:
    """Wavelength of the Airy disc: the mean of the electrons that arrive, else of the lamp's own colour."""
    scene, contraction = problem.scenes[scene_index], problem.contractions[scene_index]
    spectrum = int(contraction.spectrum_of[optics])
    seen = arriving(scene, contraction, spectrum, efficiency)
    if not seen.sum() > 0:
        seen = relative_spectrum(contraction.spectrum_names[spectrum], scene.wavelength_nm)
    return mean_wavelength_nm(scene, seen)


def airy_f_number(problem: Problem, scene_index: int, limit_px: float, camera: Array, light: Array) -> Array:
    """The working f-number at which the Airy disc of these cameras under these lamps has so many pixels."""
    optics, efficiency = problem.lights.optics_index[light], problem.cameras.qe_index[camera]
    first, back = rows_alike(optics, efficiency)
    wave_nm = np.array([airy_wavelength_nm(problem, scene_index, int(optics[n]), int(efficiency[n])) for n in first])
    disc_m = airy_diameter_m(wave_nm, working_f_number=1.0)
    return np.asarray(limit_px * problem.cameras.pixel_pitch_m[camera] / disc_m[back])


def spread_of(scene: SceneOptics, contraction: Contraction, spectrum: int, efficiency: int) -> SpreadTable:
    """Table of the spread of colours, for lateral colour."""
    key = ("spread", *contraction.key(spectrum, efficiency, None))

    def made() -> SpreadTable:
        per_nm = arriving(scene, contraction, spectrum, efficiency) / trapezoid_weights_nm(scene.wavelength_nm)
        return lateral.spread_table(scene.wavelength_nm, electrons_per_nm=per_nm, n_water=scene.n_water_spectrum)

    return scene.once(key, made)
