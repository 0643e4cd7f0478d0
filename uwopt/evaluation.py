"""One system in one mission: figures, margins, totals and bill of materials.

Everything a result says of a design is computed here, from the same tables and formulas that the
search uses; a search's claim is read back through this door.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.catalog.catalogue import plain_name
from uwopt.catalog.records import Part, Quantity
from uwopt.figures import (
    DesignRows,
    Figures,
    SettingRows,
    electrons_in_image,
    figures_of,
    full_light_lm,
    levers_m,
    open_s,
)
from uwopt.hardware import CONTINUOUS, FLASH, Cameras, Lenses, Lights
from uwopt.image_light import ImageLight, SunLight
from uwopt.model import lateral, sensor, sharpness
from uwopt.model import lens as lens_model
from uwopt.model.defocus import defocus_px
from uwopt.model.port import dome_virtual_image_distance_m, lens_dioptre_per_m
from uwopt.objectives.margins import MarginRows, scene_margins, system_margins
from uwopt.objectives.objective import Objective, Terms
from uwopt.optics import (
    blur_time_s,
    field_dioptres_per_m,
    focus_map,
    relative_spectrum,
    required_rate_hz,
    views,
)
from uwopt.problem import Mount, Problem
from uwopt.result import Design, Margin, SceneResult
from uwopt.sharp import SharpRows, arriving, mean_wavelength_nm

Array = NDArray[Any]


@dataclass(frozen=True)
class Hardware:
    """A design's hardware as indices into a problem's tables."""

    camera: int
    lens: int
    port: int
    landscape: bool
    light: int
    count: int
    mount: Mount


@dataclass(frozen=True)
class SceneSettings:
    """Settings of one design in one scene; SI. None takes the documented default."""

    f_number: float | None = None
    exposure_s: float | None = None
    pulse_s: float | None = None
    gain: float | None = None
    level: float | None = None
    rate_hz: float | None = None
    dioptre_per_m: float | None = None
    focus_distance_m: float | None = None


class DesignModel:
    """One hardware choice of a problem, ready to be asked for figures in every scene."""

    def __init__(self, problem: Problem, hardware: Hardware):
        self.problem, self.hardware = problem, hardware
        one = np.array([0])
        self.cameras: Cameras = problem.cameras.take(one + hardware.camera)
        self.lenses: Lenses = problem.lenses.take(one + hardware.lens)
        self.lights: Lights = problem.lights.take(one + hardware.light)
        self.shapes = [problem.shape(hardware.port, i) for i in range(len(problem.scenes))]
        self.maps = [focus_map(s, shape) for s, shape in zip(problem.scenes, self.shapes, strict=True)]
        self.views = [
            views(scene, self.cameras, self.lenses, shape, landscape=hardware.landscape)
            for scene, shape in zip(problem.scenes, self.shapes, strict=True)
        ]
        for index, view in enumerate(self.views):
            widest = 0.5 * float(np.hypot(view.footprint_along_m[0, 2], view.footprint_across_m[0, 2]))
            problem.set_reach(index, 1.5 * widest)
        self.rows = [self._rows(i) for i in range(len(problem.scenes))]

    def _rows(self, index: int) -> DesignRows:
        scene, view, hw = self.problem.scenes[index], self.views[index], self.hardware
        return DesignRows(
            cameras=self.cameras,
            lenses=self.lenses,
            lights=self.lights,
            count=np.array([hw.count]),
            view=view,
            focus_map=self.maps[index],
            lever_m=levers_m(scene, np.array([self.shapes[index].outer_radius_m])),
            light=self.image_light(index, pixels=not scene.paper),
            sun=self.sun_light(index, pixels=True),
            sharp=None,
        )

    def sharp_rows(self, index: int, dioptre_per_m: float) -> SharpRows:
        """What sharpness depends on at this focus."""
        hw = self.hardware
        return self.problem.sharp_rows(
            index, self.views[index], camera=np.array([hw.camera]), lens=np.array([hw.lens]), port=np.array([hw.port]),
            optics=int(self.lights.optics_index[0]), dioptre_per_m=np.array([dioptre_per_m]),
        )  # fmt: skip

    def sun_light(self, index: int, *, pixels: bool = False, channel: str | None = None) -> SunLight | None:
        """Electrons per second from the sun."""
        hw = self.hardware
        return self.problem.sun_light(
            index, self.views[index], np.array([hw.camera]), port_index=np.array([hw.port]), mount=hw.mount,
            count=hw.count, channel=channel, pixels=pixels,
        )  # fmt: skip

    def image_light(self, index: int, *, pixels: bool = False, channel: str | None = None) -> ImageLight:
        """Electrons per lm s of nameplate light."""
        hw = self.hardware
        light = self.problem.image_light(
            index, self.views[index], np.array([hw.camera]), port_index=hw.port,
            optics=int(self.lights.optics_index[0]), mount=hw.mount, count=hw.count, pixels=pixels, channel=channel,
        )  # fmt: skip
        return light.scaled(self.lights.output_factor)

    # ------------------------------------------------------------ settings

    def settings(self, index: int, given: SceneSettings) -> SettingRows:
        """Settings with their defaults: widest aperture, longest exposure that fits, gain for the wanted level."""
        scene, rows = self.problem.scenes[index], self.rows[index]
        needs, limits = scene.view.requirements, self.problem.mission.limits
        speed = scene.view.vehicle.speed_m_s
        rate = given.rate_hz
        if rate is None:
            rate = float(required_rate_hz(needs, speed, rows.view.footprint_along_m).max())
        dioptre = given.dioptre_per_m
        if dioptre is None:
            distance = given.focus_distance_m or float(scene.range_m[scene.nominal])
            dioptre = float(lens_dioptre_per_m(distance, focus_map=self.maps[index]))
        f_number = given.f_number or float(self.lenses.f_number_min[0])
        level = 1.0 if given.level is None else given.level
        cam, lights = self.cameras, self.lights
        offset, readout = float(cam.exposure_offset_s[0]), float(cam.readout_s[0])
        blur = float(blur_time_s(scene, self.shapes[index], rows.view)[0])
        cap = min(
            float(cam.max_exposure_s[0]), limits.max_exposure_ms * 1e-3, 1.0 / rate if rate > 0 else math.inf
        )
        pulse, exposure = given.pulse_s, given.exposure_s
        kind = int(lights.kind[0])
        if kind == FLASH:
            pulse = float(lights.flash_duration_s[0]) if pulse is None else pulse
        if exposure is None:
            exposure = min(cap, max(blur - offset, float(cam.min_exposure_s[0])))
            if kind != CONTINUOUS:
                exposure = min(cap, max(exposure, (pulse or 0.0) + readout))
        if kind != CONTINUOUS and pulse is None:
            pulse = min(exposure, float(lights.max_pulse_s[0]))
        gain = given.gain
        if gain is None:
            gain = self._default_gain(index, f_number, exposure, pulse, level, rate, dioptre)
        return _setting_rows(f_number, exposure, pulse, gain, level, rate, dioptre)

    def _default_gain(self, index: int, *values: Any) -> float:
        """The gain that gives the wanted mean level, within the camera's range; 1 when none is wanted."""
        f_number, exposure, pulse, level, rate, dioptre = values
        scene, cam = self.problem.scenes[index], self.cameras
        wanted = scene.view.requirements.mean_level
        if wanted is None:
            return 1.0
        at_unit = figures_of(
            scene, self.rows[index], _setting_rows(f_number, exposure, pulse, 1.0, level, rate, dioptre)
        )
        full, black = float(2.0 ** cam.bits[0] - 1.0), float(cam.black_level_dn[0])
        reached = float(at_unit.mean_level[0, scene.nominal]) * full - black
        if not reached > 0:
            return float(cam.max_gain[0])
        return float(np.clip((wanted * full - black) / reached, 1.0, cam.max_gain[0]))

    # ------------------------------------------------------------ results

    def figures(self, index: int, settings: SettingRows, *, information: bool = False) -> Figures:
        """Figures of one scene, for one or many settings with a common focus."""
        scene, rows = self.problem.scenes[index], self.rows[index]
        if not scene.paper and (information or scene.view.requirements.min_mtf_half_nyquist is not None):
            sharp = self.sharp_rows(index, float(settings.dioptre_per_m[0]))
            rows = replace(rows, sharp=sharp.take(np.zeros(len(settings.f_number), int)))
        return figures_of(scene, rows, settings, information=information)

    def margins(
        self, index: int, settings: SettingRows, figures: Figures, *, level_tolerance_rel: float = 1e-6
    ) -> list[MarginRows]:
        """Requirements of one scene and limits of the system in it."""
        scene, limits = self.problem.scenes[index], self.problem.mission.limits
        terms = self.totals(index, figures)
        return [
            *scene_margins(
                scene, self.rows[index], settings, figures, limits, level_tolerance_rel=level_tolerance_rel
            ),
            *self.port_margins(index),
            *self.evenness_margins(index),
            *system_margins(
                limits, cost_limit_value=terms["cost_limit_value"], power_w=terms["power_w"],
                peak_power_w=figures.light_peak_power_w + terms["camera_power_w"], mass_kg=terms["mass_kg"],
                data_rate_mb_s=figures.data_rate_mb_s * self.problem.mission.vehicle.camera_count,
                depth_m=self.problem.mission.required_depth_m, ratings_m=self.ratings_m(),
                accepted=self.accepted_unrated(),
            ),
        ]  # fmt: skip

    def port_margins(self, index: int) -> list[MarginRows]:
        """Whether the corner ray of the view passes the port's clear aperture, where that is known."""
        port = self.problem.ports.take(np.array([self.hardware.port]))
        if self.problem.paper or port.is_dome[0] or not np.isfinite(port.clear_radius_m[0]):
            return []
        view = self.views[index]
        corner_mm = np.hypot(view.tan_along, view.tan_across) * port.gap_m * 1e3
        return [MarginRows("port_clears_view_mm", corner_mm, port.clear_radius_m * 1e3, "<=", "mm")]

    def evenness_margins(self, index: int) -> list[MarginRows]:
        """Least over mean floor illuminance, where the mission asks for it."""
        scene, hw = self.problem.scenes[index], self.hardware
        wanted = scene.view.requirements.min_uniformity
        if wanted is None:
            return []
        reached = self.problem.uniformity(
            index, self.views[index], port_index=hw.port, optics=int(self.lights.optics_index[0]), mount=hw.mount,
            count=hw.count,
        )  # fmt: skip
        worst = int(reached.argmin())
        value, where = np.array([reached[worst]]), np.array([scene.range_m[worst]])
        return [MarginRows("min_uniformity", value, np.array([wanted]), ">=", "", where)]

    def accepted_unrated(self) -> frozenset[str]:
        """Parts of this design whose unknown depth rating the mission accepts, however it spells their ids."""
        named = {plain_name(name) for name in self.problem.mission.catalog.accept_unrated}
        return frozenset(part for part in self.ratings_m() if plain_name(part) in named)

    def ratings_m(self) -> dict[str, float | None]:
        """Depth ratings of the parts that meet the water; inline parts are not checked for what they leave out."""
        port = self.problem.parts.ports[self.hardware.port]
        light = self.problem.parts.lights[self.hardware.light]
        return {
            part.id: part.depth_rating_m
            for part in (port, light)
            if not (part.inline and part.depth_rating_m is None)
        }

    def totals(self, index: int, figures: Figures) -> dict[str, Array]:
        """Cost, mass and power of the system, with the lights' power in one scene."""
        problem, hw = self.problem, self.hardware
        n = problem.mission.vehicle.camera_count
        extra_cost, extra_mass, extra_power = problem.extras
        port = problem.ports.take(np.array([hw.port]))
        lamps_to_buy = problem.lamps_to_buy(np.array([hw.light]), np.array([hw.count]))

        def money(name: str) -> Array:
            body = getattr(self.cameras, name) + getattr(self.lenses, name) + getattr(port, name)
            return n * body + lamps_to_buy * getattr(self.lights, name) + extra_cost

        mass = (
            n * (self.cameras.mass_kg + self.lenses.mass_kg + port.mass_kg) + hw.count * self.lights.mass_kg
        )
        camera_power = n * self.cameras.power_w + extra_power
        return {
            "cost": money("price"),
            "cost_limit_value": money("limit_price"),
            "mass_kg": mass + extra_mass,
            "camera_power_w": camera_power,
            "power_w": camera_power + figures.light_power_w,
        }


def _setting_rows(
    f_number: Any, exposure: Any, pulse: Any, gain: Any, level: Any, rate: Any, dioptre: Any
) -> SettingRows:
    """One design's settings as columns of length one."""
    values = [f_number, exposure, np.inf if pulse is None else pulse, gain, level, rate, dioptre]
    return SettingRows(*(np.array([value], float) for value in values))


def evaluate_design(
    problem: Problem, hardware: Hardware, given: list[SceneSettings], objective: Objective,
    *, level_tolerance_rel: float = 1e-6,
) -> Design:  # fmt: skip
    """Everything a result says of one design with these settings."""
    model = DesignModel(problem, hardware)
    scenes, powers, snrs, peaks, light_powers = [], [], [], [], []
    contrasts, information = [], []
    for index, wanted in enumerate(given):
        scene = problem.scenes[index]
        settings = model.settings(index, wanted)
        figures = model.figures(index, settings, information=not scene.paper)
        margins = model.margins(index, settings, figures, level_tolerance_rel=level_tolerance_rel)
        contrasts.append(1.0 if figures.contrast is None else float(figures.contrast[0, scene.nominal]))
        bits = figures.information_bit_per_m2
        information.append(math.nan if bits is None else float(bits[0]))
        terms = model.totals(index, figures)
        powers.append(float(terms["power_w"][0]))
        light_powers.append(float(figures.light_power_w[0]))
        peaks.append(float(figures.light_peak_power_w[0]))
        snr = float(figures.snr[0, scene.nominal])
        snrs.append(20.0 * math.log10(snr) if snr > 0 else -math.inf)
        scenes.append(
            SceneResult(
                name=scene.name,
                settings=plain_settings(model, index, settings, figures),
                settings_to_set=None,
                figures=plain_figures(model, index, settings, figures),
                margins=[plain_margin(m) for m in margins],
            )
        )
    cost, mass = float(terms["cost"][0]), float(terms["mass_kg"][0])
    gsd_mm = max(float(view.gsd_m[0, 1]) * 1e3 for view in model.views)
    worst = (max(powers), cost, mass, min(snrs), gsd_mm, min(contrasts), min(information))
    one = Terms(*(np.array([v]) for v in worst))
    minimised = float(objective.cost_to_minimise(one)[0])
    feasible = all(m.satisfied for s in scenes for m in s.margins)
    return Design(
        hardware=hardware_dict(problem, hardware),
        objective_value=objective.reported(minimised) if math.isfinite(minimised) else None,
        feasible=feasible,
        totals={
            "cost": cost_range(problem, hardware),
            "power_w": max(powers),
            "light_power_w": max(light_powers),
            "light_peak_power_w": max(peaks),
            "mass_kg": mass,
        },
        scenes=scenes,
        bom=bill_of_materials(problem, hardware),
    )


def plain_margin(row: MarginRows) -> Margin:
    """One margin of one design."""
    value, limit, margin = float(row.value[0]), float(row.limit[0]), float(row.margin[0])
    finite = math.isfinite
    where = None if row.at_altitude_m is None else float(row.at_altitude_m[0])
    return Margin(
        requirement=row.requirement,
        value=value if finite(value) else None,
        limit=limit if finite(limit) else None,
        sense=row.sense,
        margin=margin if finite(margin) else None,
        unit=row.unit,
        at_altitude_m=where,
        satisfied=bool(row.satisfied[0]),
        binding=bool(row.binding[0])
        and finite(limit)
        and finite(value)
        and row.requirement not in ("light_level", "mean_level"),
    )


def plain_settings(
    model: DesignModel, index: int, settings: SettingRows, figures: Figures
) -> dict[str, float | None]:
    """Settings in the field's units."""
    kind = int(model.lights.kind[0])
    level, pulse = float(settings.level[0]), float(settings.pulse_s[0])
    flux = None if kind == FLASH else float(model.lights.full_light[0]) * model.hardware.count * level
    energy = float(model.lights.stored_energy_j[0]) * level if kind == FLASH else None
    focus = float(figures.focus_distance_m[0])
    return {
        "f_number": float(settings.f_number[0]),
        "exposure_ms": float(settings.exposure_s[0]) * 1e3,
        "pulse_ms": pulse * 1e3 if kind != CONTINUOUS and math.isfinite(pulse) else None,
        "gain": float(settings.gain[0]),
        "gain_db": 20.0 * math.log10(float(settings.gain[0])) if settings.gain[0] > 0 else None,
        "flux_lm": flux,
        "dim_frac": level,
        "flash_energy_j": energy,
        "frame_rate_hz": float(settings.rate_hz[0]),
        "focus_distance_m": focus if math.isfinite(focus) else None,
    }


def plain_figures(model: DesignModel, index: int, settings: SettingRows, figures: Figures) -> dict[str, Any]:
    """Figures at the nominal altitude, by the names that reports use."""
    scene, view = model.problem.scenes[index], model.views[index]
    landscape, at = model.hardware.landscape, scene.nominal
    along, across = float(view.footprint_along_m[0, 1]), float(view.footprint_across_m[0, 1])
    snr = float(figures.snr[0, at])
    needs = scene.view.requirements
    speed = scene.view.vehicle.speed_m_s
    nominal_rate = float(required_rate_hz(needs, speed, view.footprint_along_m[:, 1:2])[0, 0])
    far = float(figures.dof_far_m[0])
    near = float(figures.dof_near_m[0])
    cam = model.cameras
    mean_level = float(figures.mean_level[0, at])
    blur_limit = float(blur_time_s(_at_nominal(scene), model.shapes[index], _nominal_view(view))[0])
    out: dict[str, Any] = {
        "fov_x_m": across if landscape else along,
        "fov_y_m": along if landscape else across,
        "gsd_mm": float(view.gsd_m[0, 1]) * 1e3,
        "blur_px": float(figures.blur_px[0, 1]),
        "skew_px": float(figures.skew_px[0, 1]),
        "swath_m": across,
        "overlap": float(figures.overlap[0, 1]),
        "frame_rate_min_hz": nominal_rate,
        "exposure_max_ms": blur_limit * 1e3 if math.isfinite(blur_limit) else None,
        "exposure_ms": float(settings.exposure_s[0]) * 1e3,
        "pulse_ms": plain_settings(model, index, settings, figures)["pulse_ms"],
        "f_number": float(settings.f_number[0]),
        "working_f_number": float(figures.working_f_number[0]),
        "gain": float(settings.gain[0]),
        "flux_lm": plain_settings(model, index, settings, figures)["flux_lm"],
        "duty_frac": float(figures.duty_frac[0]),
        "dof_near_m": near,
        "dof_far_m": far if math.isfinite(far) else None,
        "dof_far_is_infinite": math.isinf(far),
        "dof_m": far - near if math.isfinite(far) else None,
        "focus_distance_m": plain_settings(model, index, settings, figures)["focus_distance_m"],
        "virtual_image_distance_m": virtual_image_m(model, index),
        "effective_focal_length_mm": effective_focal_mm(model, index),
        **illuminance(model, index, settings),
        "electrons_signal": float(figures.electrons_signal[0, at]),
        "electrons_forward": at_nominal(figures.electrons_forward, at),
        "electrons_backscatter": at_nominal(figures.electrons_backscatter, at),
        "electrons_sun": at_nominal(figures.electrons_sun, at),
        "electrons_dark": float(figures.electrons_dark[0]),
        "mean_level": mean_level,
        "mean_dn": mean_level * float(2.0 ** cam.bits[0] - 1.0),
        "saturation_fraction": float(figures.saturation_fraction[0]),
        "snr": snr,
        "snr_db": decibels(snr),
        "snr_db_min": None if figures.snr_darkest is None else decibels(float(figures.snr_darkest[0, at])),
        **colour_snr(model, index, settings, figures),
        "contrast": at_nominal(figures.contrast, at),
        "veil_ratio": veil_ratio(figures, at),
        **sharpness_figures(model, index, settings, figures),
        "airy_diameter_um": airy_um(model, index, float(figures.working_f_number[0])),
        "power_w": float(model.totals(index, figures)["power_w"][0]),
        "light_power_w": float(figures.light_power_w[0]),
        "light_peak_power_w": float(figures.light_peak_power_w[0]),
        "camera_power_w": float(model.totals(index, figures)["camera_power_w"][0]),
        "cost": float(model.totals(index, figures)["cost"][0]),
        "currency": model.problem.mission.limits.currency,
        "mass_kg": float(model.totals(index, figures)["mass_kg"][0]),
        "data_rate_mb_s": float(figures.data_rate_mb_s[0]) * model.problem.mission.vehicle.camera_count,
        "information_bit_per_m2": at_one(figures.information_bit_per_m2),
    }
    return {key: (None if isinstance(v, float) and not math.isfinite(v) else v) for key, v in out.items()}


def _at_nominal(scene: Any) -> Any:
    return replace(scene, range_m=scene.range_m[scene.nominal : scene.nominal + 1], nominal=0)


def _nominal_view(view: Any) -> Any:
    middle = {
        name: np.repeat(getattr(view, name)[:, 1:2], 3, axis=1)
        for name in ("footprint_along_m", "footprint_across_m", "gsd_m", "pixel_along_m", "pixel_across_m")
    }
    return replace(view, **middle)


def at_nominal(column: Array | None, altitude: int) -> float | None:
    """A figure of the only design at one altitude; None when it is left out."""
    return None if column is None else float(column[0, altitude])


def at_one(column: Array | None) -> float | None:
    """A figure of the only design; None when it is left out."""
    return None if column is None else float(column[0])


SHARPNESS = (
    "mtf50_cyc_per_px", "mtf_half_nyquist", "resolution_10_mm", "lateral_colour_px", "defocus_corner_px",
)  # fmt: skip


def sharpness_figures(
    model: DesignModel, index: int, settings: SettingRows, figures: Figures
) -> dict[str, float | None]:
    """MTF where the mission wants the image sharp, and what colours and defocus do at the corner."""
    scene, problem, view = model.problem.scenes[index], model.problem, model.views[index]
    if scene.paper:
        return dict.fromkeys(SHARPNESS)
    dioptre = float(settings.dioptre_per_m[0])
    rows = model.sharp_rows(index, dioptre)
    f_number, working = settings.f_number, figures.working_f_number
    sunlit = model.rows[index].sun is not None
    blur_s = open_s(model.rows[index], settings) if sunlit else figures.light_time_s
    (group, spread), *_ = rows.groups()
    at = rows.at(
        group, spread, working_f_number=working, blur_px=rows.blur_px_per_s[:, 1] * blur_s,
        disc_px=rows.place_disc_px[:, 1] / f_number, field="place",
    )  # fmt: skip
    resolution_m = sharpness.resolution_10_m(
        at, ground_sample_along_m=view.gsd_m[:, 1], ground_sample_across_m=view.gsd_m[:, 1]
    )
    spectrum = int(problem.contractions[index].spectrum_of[int(model.lights.optics_index[0])])
    electrons = arriving(scene, problem.contractions[index], spectrum, int(model.cameras.qe_index[0]))
    corner = np.hypot(view.tan_along, view.tan_across)
    colour = 0.0 if model.shapes[index].is_dome else float(
        lateral.lateral_colour_px(
            corner, n_water=scene.n_water_spectrum, n_design=scene.n_water, electrons=electrons,
            focal_length_m=view.focal_length_m, pixel_pitch_m=model.cameras.pixel_pitch_m,
        )[0]
    )  # fmt: skip
    bent = field_dioptres_per_m(view.corner_image, float(scene.range_m[scene.nominal]))
    disc = defocus_px(
        bent, f_number=f_number[:, None], focal_length_m=view.focal_length_m[:, None],
        pixel_pitch_m=model.cameras.pixel_pitch_m[:, None], focus_dioptre_per_m=dioptre,
    )  # fmt: skip
    return {
        "mtf50_cyc_per_px": float(sharpness.mtf50_cyc_per_px(at)[0]),
        "mtf_half_nyquist": float(sharpness.mtf_half_nyquist(at)[0]),
        "resolution_10_mm": float(resolution_m[0]) * 1e3,
        "lateral_colour_px": colour,
        "defocus_corner_px": float(disc.max()),
    }


def veil_ratio(figures: Figures, altitude: int) -> float | None:
    """Veil over image-forming electrons; None where veils are left out or nothing forms an image."""
    if figures.contrast is None or not figures.electrons_signal[0, altitude] > 0:
        return None
    veils = (figures.electrons_forward, figures.electrons_backscatter)
    veil = sum(float(column[0, altitude]) for column in veils if column is not None)
    return veil / float(figures.electrons_signal[0, altitude])


def decibels(ratio: float) -> float | None:
    """20 log10, None where there is no signal."""
    return 20.0 * math.log10(ratio) if ratio > 0 else None


def virtual_image_m(model: DesignModel, index: int) -> float | None:
    """Virtual image of the floor from the dome's outer vertex."""
    shape, scene = model.shapes[index], model.problem.scenes[index]
    if not shape.is_dome:
        return None
    return float(
        dome_virtual_image_distance_m(
            float(scene.range_m[scene.nominal]),
            outer_radius_m=shape.outer_radius_m,
            thickness_m=shape.thickness_m,
            n_glass=shape.n_glass,
            n_water=shape.n_water,
        )
    )


def effective_focal_mm(model: DesignModel, index: int) -> float:
    """Focal length that the floor sees: n_w f behind a flat port (paraxial), f behind a dome."""
    focal_mm = float(model.lenses.focal_length_m[0]) * 1e3
    shape = model.shapes[index]
    return focal_mm if shape.is_dome else focal_mm * shape.n_water


def illuminance(model: DesignModel, index: int, settings: SettingRows) -> dict[str, float]:
    """Floor illuminance over the footprint at the nominal altitude, while the lights are on."""
    problem, hw = model.problem, model.hardware
    scene, view = problem.scenes[index], model.views[index]
    lumens = float(full_light_lm(model.lights, np.array([hw.count]))[0]) * float(settings.level[0])
    lumens *= float(model.lights.output_factor[0])
    mean, least = problem.footprint_light(
        index, view, port_index=hw.port, optics=int(model.lights.optics_index[0]), mount=hw.mount,
        count=hw.count, altitude=scene.nominal,
    )  # fmt: skip
    return {
        "floor_illuminance_mean_lx": lumens * mean,
        "floor_illuminance_min_lx": lumens * least,
        "uniformity": least / mean if mean > 0 else 0.0,
    }


def colour_snr(
    model: DesignModel, index: int, settings: SettingRows, figures: Figures
) -> dict[str, float | None]:
    """SNR of each channel of a colour sensor at the nominal altitude; None for a mono sensor."""
    names = ("red", "green", "blue")
    curves = model.problem.efficiencies[int(model.cameras.qe_index[0])]
    if not all(name in curves for name in names):
        return {f"snr_{name}": None for name in names}
    scene, cam = model.problem.scenes[index], model.cameras
    out: dict[str, float | None] = {}
    for name in names:
        light, sun = model.image_light(index, channel=name), model.sun_light(index, channel=name)
        open_y = open_s(model.rows[index], settings) / np.square(figures.working_f_number)
        seen = electrons_in_image(replace(model.rows[index], light=light, sun=sun), figures.light_x, open_y)
        out[f"snr_{name}"] = float(
            sensor.snr(
                float(seen.signal_e[0, scene.nominal]),
                veil_e=0.0 if seen.veil_e is None else float(seen.veil_e[0, scene.nominal]),
                read_noise_e=float(cam.read_noise_e[0]),
                gain_dn_per_e=float(cam.gain_dn_per_e[0] * settings.gain[0]),
                dark_e=float(figures.electrons_dark[0]),
                prnu_frac=float(cam.prnu_frac[0]),
            )
        )
    return out


def airy_um(model: DesignModel, index: int, working_f_number: float) -> float:
    """Airy disc at the electron-weighted mean wavelength of the light that arrives."""
    problem = model.problem
    scene, contraction = problem.scenes[index], problem.contractions[index]
    spectrum = int(contraction.spectrum_of[int(model.lights.optics_index[0])])
    seen = arriving(scene, contraction, spectrum, int(model.cameras.qe_index[0]))
    if not seen.sum() > 0:  # nothing arrives: the lamp's own colour
        seen = relative_spectrum(contraction.spectrum_names[spectrum], scene.wavelength_nm)
    mean_nm = mean_wavelength_nm(scene, seen)
    return float(lens_model.airy_diameter_m(mean_nm, working_f_number=working_f_number)) * 1e6


# ---------------------------------------------------------------- parts and money


def hardware_dict(problem: Problem, hw: Hardware) -> dict[str, Any]:
    """The hardware by ids, and where its lights stand."""
    parts = problem.parts
    mounts = (
        [m.model_dump(mode="json") for m in hw.mount.explicit] if hw.mount.explicit else default_mounts(hw)
    )
    return {
        **{
            kind: {
                "id": part.id,
                "name": f"{part.manufacturer} {part.model}".strip() or part.id,
                "generic": part.generic,
            }
            for kind, part in (
                ("camera", parts.cameras[hw.camera]),
                ("lens", parts.lenses[hw.lens]),
                ("port", parts.ports[hw.port]),
                ("light", parts.lights[hw.light]),
            )
        },
        "camera_count": problem.mission.vehicle.camera_count,
        "light_count": hw.count,
        "orientation": "landscape" if hw.landscape else "portrait",
        "light_mounts": mounts,
    }


def default_mounts(hw: Hardware) -> list[dict[str, float]]:
    """Lamps alternately at plus and minus the baseline."""
    return [
        {
            "x_m": 0.0,
            "y_m": hw.mount.baseline_m * (1.0 if n % 2 == 0 else -1.0),
            "z_m": 0.0,
            "tilt_x_deg": 0.0,
            "tilt_y_deg": hw.mount.tilt_deg,
        }
        for n in range(hw.count)
    ]


def bought(problem: Problem, hw: Hardware) -> list[tuple[str, Part, int, int]]:
    """Each part of a design with how many there are and how many of them are owned."""
    parts, n = problem.parts, problem.mission.vehicle.camera_count
    light = parts.lights[hw.light]
    owned = min(hw.count, problem.owned_lights.get(light.id, 0))
    return [
        ("camera", parts.cameras[hw.camera], n, 0),
        ("lens", parts.lenses[hw.lens], n, 0),
        ("port", parts.ports[hw.port], n, 0),
        ("light", light, hw.count, owned),
    ]


def price_status(part: Part) -> str:
    """How the price is known, in one word."""
    if part.price is None:
        return "unknown"
    if part.generic:
        return "to be made"
    return {"published": "list", "user": "own", "quoted": "quoted"}.get(part.price.status, part.price.status)


def bill_of_materials(problem: Problem, hw: Hardware) -> list[dict[str, Any]]:
    """What to order: part, number, price with its range and status, source."""
    currency = problem.mission.limits.currency
    rows = []
    for kind, part, count, owned in bought(problem, hw):
        price = part.price or Quantity(0.0, 0.0, 0.0, "user")
        rate = problem.money(1.0, part.currency)
        rows.append(
            {
                "kind": kind, "id": part.id, "manufacturer": part.manufacturer, "model": part.model, "count": count,
                "owned": owned, "unit_price": price.value * rate if part.price else None,
                "unit_price_low": price.low * rate if part.price else None,
                "unit_price_high": price.high * rate if part.price else None, "currency": currency,
                "price_status": price_status(part), "price_date": part.price_date, "generic": part.generic,
                "source": part.source_url, "price_basis": price.source,
            }
        )  # fmt: skip
    extras = problem.mission.catalog.extras
    return rows + [
        {
            "kind": "extra", "id": extra.name, "manufacturer": "", "model": extra.name, "count": 1, "owned": 0,
            "unit_price": extra.cost, "unit_price_low": extra.cost, "unit_price_high": extra.cost,
            "currency": currency, "price_status": "own", "price_date": "", "generic": False, "source": "mission",
            "price_basis": "",
        }
        for extra in extras
    ]  # fmt: skip


def cost_range(problem: Problem, hw: Hardware) -> dict[str, Any]:
    """Cost with the range that estimated prices leave, and how much of it is estimated."""
    value = low = high = estimated = estimated_low = estimated_high = 0.0
    for row in bill_of_materials(problem, hw):
        number = row["count"] - row["owned"]
        if row["unit_price"] is None:
            continue
        value += number * row["unit_price"]
        low += number * row["unit_price_low"]
        high += number * row["unit_price_high"]
        if row["price_status"] in ("estimated", "to be made"):
            estimated += number * row["unit_price"]
            estimated_low += number * row["unit_price_low"]
            estimated_high += number * row["unit_price_high"]
    return {
        "value": value, "low": low, "high": high, "currency": problem.mission.limits.currency,
        "estimated": estimated, "estimated_low": estimated_low, "estimated_high": estimated_high,
    }  # fmt: skip
