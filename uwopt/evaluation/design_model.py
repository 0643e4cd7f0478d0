"""One hardware choice of a problem, ready to be asked for figures, margins and totals in every scene."""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from uwopt.arrays import Array
from uwopt.catalog.records import Housing, Light, Port
from uwopt.documents.faults import plain_name
from uwopt.evaluation.design_light import DesignLight
from uwopt.forward.breathing import at_focus
from uwopt.forward.designs import Hardware, SceneSettings
from uwopt.forward.enclosures import (
    bodies_in,
    housing_diameter_mm,
    housing_size_mm,
    mass_in_water_kg,
    room_needed_m,
)
from uwopt.forward.figures import (
    DesignRows,
    Figures,
    SettingRows,
    figures_of,
    levers_m,
)
from uwopt.forward.floor_light import uniformity
from uwopt.forward.focus import Focus, default_dioptres_per_m, place_focus
from uwopt.forward.lamp_views import (
    bodies_refused,
    from_port_axis_m,
    lamps_apart_m,
    least_clearance_m,
    port_radius_m,
    views_refused,
)
from uwopt.forward.motion import blur_time_s, required_rate_hz
from uwopt.forward.part_columns import CONTINUOUS, FLASH
from uwopt.forward.part_rows import number
from uwopt.forward.pixels import at_fewest_pixels
from uwopt.forward.problem import Problem
from uwopt.forward.scene import Pixels
from uwopt.forward.sharpness import SharpRows, airy_wavelength_nm, sharpness_of
from uwopt.forward.spacers import ring_behind_m
from uwopt.forward.switching import camera_power_w
from uwopt.forward.views import Views, focus_map, widest_corner
from uwopt.model.lens import airy_diameter_m
from uwopt.model.port import lens_dioptre_per_m
from uwopt.objectives.requirements import (
    MarginRows,
    duration_margins,
    fixed_margins,
    rated_time_margins,
    scene_margins,
    system_margins,
    trigger_margins,
)

#: Margins that say nothing where there is no lamp.
LAMP_MARGINS = (
    "light_level_max", "light_level", "fixed_dim_frac", "min_uniformity", "lamp_clear_m", "lamp_beside_port_m",
    "lamps_apart_m",
)  # fmt: skip


class DesignModel(DesignLight):
    """One hardware choice of a problem, ready to be asked for figures in every scene."""

    def __init__(self, problem: Problem, hardware: Hardware):
        super().__init__(problem, hardware)
        self.maps = [focus_map(s, shape) for s, shape in zip(problem.scenes, self.shapes, strict=True)]
        self.rates_hz: tuple[float, ...] = ()  # of images by scene, where they are set
        self.spacer_m = self._ring_m() if hardware.spacer_m is None else hardware.spacer_m  # behind each lens
        self.rows = [self._rows(i, pixels=scene.pixels) for i, scene in enumerate(problem.scenes)]

    def _rows(self, index: int, *, pixels: Pixels | None, altitude: int | None = None) -> DesignRows:
        scene, view, hw = self.problem.scenes[index], self.views[index], self.hardware
        light, sun = at_fewest_pixels(
            self.image_light(index, pixels=pixels, altitude=altitude), self.sun_light(index, pixels=pixels)
        )
        return DesignRows(
            cameras=self.cameras,
            lenses=self.lenses,
            lights=self.lights,
            count=np.array([hw.count]),
            view=view,
            focus_map=self.maps[index],
            lever_m=levers_m(scene, np.array([self.shapes[index].outer_radius_m])),
            light=light,
            sun=sun,
            spacer_m=np.array([self.spacer_m]),
        )

    def _ring_m(self) -> float:
        """The ring that the focus of a search needs."""
        dioptres = [np.array([self.searched_dioptre_per_m(i)]) for i in range(len(self.views))]
        return float(ring_behind_m(self.lenses, dioptres)[0])

    def snr_at(self, pixels: Pixels, index: int, settings: SettingRows) -> float | None:
        """Lowest SNR over the image, or that of all but a share of it, at the nominal altitude.

        None in physics `paper`, which knows no field.
        """
        scene = self.problem.scenes[index]
        if scene.paper:
            return None
        rows = self.rows[index]
        if scene.pixels != pixels:
            there = scene.nominal
            rows = self._once(("rows", index, pixels), lambda: self._rows(index, pixels=pixels, altitude=there))
        reached = figures_of(scene, rows, settings).snr_pixels
        return None if reached is None else float(reached[0, scene.nominal])

    def view_at(self, index: int, dioptre_per_m: float) -> Views:
        """What the image of one scene covers at this focus."""
        scene, shape = self.problem.scenes[index], self.shapes[index]
        view: Views = self._once(
            ("view", index, dioptre_per_m),
            lambda: at_focus(scene, shape, self.views[index], self.cameras.pixel_pitch_m, np.array(dioptre_per_m)),
        )
        return view

    def asked_rate_hz(self, index: int, dioptre_per_m: float) -> float:
        """The rate that overlap or interval ask for in one scene at this focus, at whichever altitude asks for most."""
        scene, view = self.problem.scenes[index].view, self.view_at(index, dioptre_per_m)
        return float(required_rate_hz(scene.requirements, scene.vehicle.speed_m_s, view.covered_along_m).max())

    def rows_at(self, index: int, dioptre_per_m: float) -> DesignRows:
        """The hardware in one scene, with what it covers at this focus."""
        return replace(self.rows[index], view=self.view_at(index, dioptre_per_m))

    def sharp_rows(self, index: int, dioptre_per_m: float) -> SharpRows:
        """What sharpness depends on at this focus."""
        hw = self.hardware
        sharp: SharpRows = self._once(
            ("sharp", index, dioptre_per_m),
            lambda: sharpness_of(
                self.problem,
                index,
                self.view_at(index, dioptre_per_m),
                camera=np.array([hw.camera]),
                lens=np.array([hw.lens]),
                port=np.array([hw.port]),
                optics=self.optics,
                dioptre_per_m=np.array([dioptre_per_m]),
            ),
        )
        return sharp

    # ------------------------------------------------------------ settings

    def settings(self, index: int, given: SceneSettings) -> SettingRows:
        """Settings with their defaults: widest aperture that is wanted, longest exposure, gain for the wanted level."""
        scene = self.problem.scenes[index]
        needs, limits = scene.view.requirements, self.problem.mission.limits
        dioptre = given.dioptre_per_m
        if dioptre is None:
            dioptre = self._default_dioptre_per_m(index)
            if given.focus_distance_m is not None:
                dioptre = float(lens_dioptre_per_m(given.focus_distance_m, focus_map=self.maps[index]))
        rate = self.asked_rate_hz(index, dioptre) if given.rate_hz is None else given.rate_hz
        f_number = (
            given.f_number
            or self.problem.f_number
            or float(self.lenses.f_number_from(needs.lens_stop_down)[0])
        )
        level = given.level
        if level is None:
            level = self.problem.mission.fixed.dim_frac or 1.0
        cam, lights = self.cameras, self.lights
        offset, readout = float(cam.exposure_offset_s[0]), float(cam.readout_s[0])
        blur = float(blur_time_s(scene, self.shapes[index], self.view_at(index, dioptre))[0])
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

    def _default_dioptre_per_m(self, index: int) -> float:
        """Focus at the nominal altitude; of several scenes the one focus that serves all."""
        return float(default_dioptres_per_m(self.problem.scenes, self.maps, self.views)[index][0])

    def searched_dioptre_per_m(self, index: int) -> float:
        """Where a search puts the focus."""
        focus: Focus = self._once("focus", lambda: place_focus(self.problem.scenes, self.maps, self.views))
        return float(focus.dioptre_per_m[index][0])

    def _default_gain(self, index: int, *values: Any) -> float:
        """The gain that gives the wanted mean level, within the camera's range; 1 when none is wanted."""
        f_number, exposure, pulse, level, rate, dioptre = values
        scene, cam = self.problem.scenes[index], self.cameras
        wanted, least = scene.view.requirements.mean_level, self.problem.mission.fixed.gain or 1.0
        if wanted is None:
            return least
        at_unit = figures_of(
            scene, self.rows[index], _setting_rows(f_number, exposure, pulse, 1.0, level, rate, dioptre)
        )
        full, black = float(2.0 ** cam.bits[0] - 1.0), float(cam.black_level_dn[0])
        reached = float(at_unit.mean_level[0, scene.nominal]) * full - black
        if not reached > 0:
            return float(cam.max_gain[0])
        return float(np.clip((wanted * full - black) / reached, least, max(cam.max_gain[0], least)))

    # ------------------------------------------------------------ results

    def figures(self, index: int, settings: SettingRows, *, information: bool = False) -> Figures:
        """Figures of one scene, for one or many settings with a common focus."""
        scene, rows = self.problem.scenes[index], self.rows_at(index, float(settings.dioptre_per_m[0]))
        if not scene.paper and (information or scene.view.requirements.asks_sharpness):
            sharp = self.sharp_rows(index, float(settings.dioptre_per_m[0]))
            rows = replace(rows, sharp=sharp.take(np.zeros(len(settings.f_number), int)))
        return figures_of(scene, rows, settings, information=information)

    def margins(
        self, index: int, settings: SettingRows, figures: Figures, *, level_tolerance_rel: float = 1e-6
    ) -> list[MarginRows]:
        """Requirements of one scene and limits of the system in it."""
        scene, mission = self.problem.scenes[index], self.problem.mission
        limits, terms = mission.limits, self.totals(figures)
        margins = [
            *scene_margins(
                scene, self.rows_at(index, float(settings.dioptre_per_m[0])), settings, figures, limits,
                level_tolerance_rel=level_tolerance_rel,
            ),
            *fixed_margins(mission.fixed, settings),
            *self.airy_margins(index, figures),
            *self.port_margins(index),
            *self.housing_margins(),
            *self.evenness_margins(index),
            *self.lamp_margins(index),
            *(() if self.unlit else trigger_margins(self.cameras, self.lights)),
            *system_margins(
                limits, cost_limit_value=terms["cost_limit_value"], power_w=terms["power_w"],
                peak_power_w=figures.light_peak_power_w + terms["camera_peak_power_w"], mass_kg=terms["mass_kg"],
                data_rate_mb_s=self.data_rate_mb_s(figures),
                depth_m=mission.required_depth_m, ratings_m=self.ratings_m(),
                accepted=self.accepted_unrated(), depth_reserve_m=mission.required_depth_m - mission.asked_depth_m,
            ),
            *rated_time_margins(mission.vehicle.duration_h, self.rated_times_h()),
            *(self.duration_margins([figures]) if len(self.problem.scenes) == 1 else ()),
        ]  # fmt: skip
        return [m for m in margins if not (self.unlit and m.requirement in LAMP_MARGINS)]

    @property
    def unlit(self) -> bool:
        """Whether the design does without lamps."""
        return self.problem.unlit(self.hardware.light)

    def duration_margins(self, by_scene: Sequence[Figures]) -> list[MarginRows]:
        """Limits of energy and storage, which hold over all scenes together; of one scene they are in `margins`."""
        duration = self.problem.duration
        return list(
            duration_margins(
                duration,
                mean_power_w=duration.mean([self.totals(f)["power_w"] for f in by_scene]),
                mean_data_rate_mb_s=duration.mean([self.data_rate_mb_s(f) for f in by_scene]),
                cards_gb=float(self.problem.mission.vehicle.camera_count * self.cameras.storage_gb[0]),
                run_time_h=math.inf if self.run_time_h is None else self.run_time_h,
            )
        )

    @property
    def run_time_h(self) -> float | None:
        """Hours that the cameras' own batteries last; None where the vehicle feeds them, or nobody says."""
        return self.problem.parts.cameras[self.hardware.camera].run_time_h

    def data_rate_mb_s(self, figures: Figures) -> Array:
        """Data rate of all cameras in one scene."""
        return np.asarray(figures.data_rate_mb_s * self.problem.mission.vehicle.camera_count)

    def airy_margins(self, index: int, figures: Figures) -> list[MarginRows]:
        """The Airy disc in pixels, where the mission limits it."""
        wanted = self.problem.scenes[index].view.requirements.max_airy_px
        if wanted is None:
            return []
        wave_nm = airy_wavelength_nm(self.problem, index, self.optics, self.efficiency)
        disc_m = airy_diameter_m(wave_nm, working_f_number=figures.working_f_number)
        disc_px = np.asarray(disc_m / self.cameras.pixel_pitch_m)
        return [MarginRows("max_airy_px", disc_px, np.full(len(disc_px), wanted), "<=", "px")]

    def port_margins(self, index: int) -> list[MarginRows]:
        """Whether the corner ray of the view passes the port's clear aperture, where that is known.

        A hemisphere's rim cuts no view; that of a spherical cap may.
        """
        port = self.port
        open_wide = port.is_dome[0] and port.rim_gap_m[0] == 0.0
        if self.problem.paper or open_wide or not np.isfinite(port.clear_radius_m[0]):
            return []
        view = self.views[index]
        corner_mm = np.hypot(view.tan_along, view.tan_across) * port.rim_gap_m * 1e3
        return [MarginRows("port_clears_view_mm", corner_mm, port.clear_radius_m * 1e3, "<=", "mm")]

    def evenness_margins(self, index: int) -> list[MarginRows]:
        """Least over mean floor illuminance, where the mission asks for it."""
        scene = self.problem.scenes[index]
        wanted = scene.view.requirements.min_uniformity
        if wanted is None:
            return []
        reached = self._lit(
            ("uniformity", index),
            lambda: uniformity(self.problem, index, self.views[index], port_index=self.hardware.port, lit=self.lit),
        )
        worst = int(reached.argmin())
        value, where = np.array([reached[worst]]), np.array([scene.altitude_m[worst]])
        return [MarginRows("min_uniformity", value, np.array([wanted]), ">=", "", where)]

    def lamp_margins(self, index: int) -> list[MarginRows]:
        """How far lamps stand from the view, from the port and from each other, where the mission refuses some."""
        problem, hw = self.problem, self.hardware
        margins = []
        if views_refused(problem, index):
            clear, front = np.array([self.lamp_clearance_m(index)]), np.array([least_clearance_m(problem)])
            where = np.array([float(problem.scenes[index].altitude_m[0])])
            margins.append(MarginRows("lamp_clear_m", clear, front, ">=", "m", where))
        if bodies_refused(problem):
            size_m = problem.mission.vehicle.lamp_size_m or 0.0
            aside = np.array([from_port_axis_m(hw.mount, hw.count)])
            beside = port_radius_m(problem, np.array([hw.port])) + 0.5 * size_m
            margins.append(MarginRows("lamp_beside_port_m", aside, beside, ">=", "m"))
            apart = np.array([lamps_apart_m(hw.mount, hw.count)])
            margins.append(MarginRows("lamps_apart_m", apart, np.array([size_m]), ">=", "m"))
        return margins

    def accepted_unrated(self) -> frozenset[str]:
        """Parts of this design whose unknown depth rating the mission accepts, however it spells their ids."""
        named = {plain_name(name) for name in self.problem.mission.catalog.accept_unrated}
        return frozenset(part for part in self.ratings_m() if plain_name(part) in named)

    def housing_margins(self) -> list[MarginRows]:
        """Whether camera and lens have room in the housing, and the housing where it is to go; none without one."""
        port = self.port
        if not port.housed[0]:
            return []
        limits = self.problem.mission.limits
        bodies = bodies_in(self.cameras, self.lenses, self.spacer_m, port)
        corner = 0.0 if self.problem.paper else widest_corner(self.views)
        rooms = room_needed_m(bodies, port, corner) if port.roomy[0] else {}
        margins = []
        for name, unit in (
            ("housing_diameter_mm", "mm"), ("housing_length_mm", "mm"), ("dome_radius_mm", "mm"),
            ("tube_mouth_mm", "mm"),
        ):  # fmt: skip
            if name in rooms:
                needed, room = rooms[name]
                margins.append(MarginRows(name, needed * 1e3, room * 1e3, "<=", unit))
        for name, most_mm, measured in (
            ("size_mm", limits.size_mm, housing_size_mm), ("diameter_mm", limits.diameter_mm, housing_diameter_mm),
        ):  # fmt: skip
            if most_mm is not None:
                margins.append(MarginRows(name, measured(port), np.array([most_mm]), "<=", "mm"))
        if limits.mass_water_kg is not None:
            margins.append(
                MarginRows("mass_water_kg", self.mass_in_water_kg(), np.array([limits.mass_water_kg]), "<=", "kg")
            )
        return margins

    def mass_in_water_kg(self) -> Array:
        """Mass in water of all cameras in their housings, lamps not counted."""
        port = self.port
        count = self.problem.mission.vehicle.camera_count
        return mass_in_water_kg(count, self.cameras, self.lenses, self.rings.get("mass_kg", 0.0), port)[:, 0]

    def at_rates(self, rates_hz: Sequence[float]) -> DesignModel:
        """The model with these rates of images by scene, as far as they are above those that the mission asks for."""
        made = copy(self)
        made.rates_hz = tuple(rates_hz)
        return made

    @property
    def disks_gb(self) -> float:
        """Disks that are bought beyond the computer's own, at the rates that are set or asked for."""

        def gigabytes() -> float:
            asked = [self.asked_rate_hz(i, self.searched_dioptre_per_m(i)) for i in range(len(self.views))]
            set_ = self.rates_hz or (0.0,) * len(asked)
            rates = [np.array([max(rate, own)]) for rate, own in zip(asked, set_, strict=True)]
            return float(self.problem.disks_gb(self.cameras, rates)[0])

        made: float = self._once(("disks", self.rates_hz), gigabytes)
        return made

    @property
    def rings(self) -> dict[str, float]:
        """What the rings behind each lens cost and weigh; nothing where none stand there."""
        return self.problem.spacers if self.spacer_m > 0.0 else {}

    def enclosure(self) -> list[Port | Housing]:
        """What keeps the water from the camera; of a complete camera it is the camera's own."""
        port = self.problem.parts.ports[self.hardware.port]
        return [replace(port, id=port.complete)] if port.complete else [port, *([port.housing] if port.housing else [])]

    def ratings_m(self) -> dict[str, float | None]:
        """Depth ratings of the parts that meet the water; inline parts are not checked for what they leave out."""
        light = self.problem.parts.lights[self.hardware.light]
        wet: list[Port | Housing | Light] = []
        wet += self.enclosure()
        wet += [] if self.unlit else [light]
        return {
            part.id: part.depth_rating_m
            for part in wet
            if not (part.inline and part.depth_rating_m is None)
        }

    def rated_times_h(self) -> dict[str, float]:
        """Of the parts around the camera whose depth rating holds for a limited time, how long."""
        return {part.id: part.rated_time_h for part in self.enclosure() if part.rated_time_h is not None}

    def totals(self, figures: Figures) -> dict[str, Array]:
        """Cost, mass and power of the system, with the lights' power in one scene."""
        problem, hw = self.problem, self.hardware
        n = problem.mission.vehicle.camera_count
        extra_cost, extra_mass, _ = problem.extras
        lamps = np.array([hw.light]), np.array([hw.count])

        def cameras(name: str) -> Array:
            pieces = getattr(self.cameras, name) + getattr(self.lenses, name) + getattr(self.port, name)
            return np.asarray(n * (pieces + self.rings.get(name, 0.0)))

        def money(name: Literal["price", "limit_price"]) -> Array:
            disks = self.disks_gb * problem.disk_prices[name]
            return cameras(name) + problem.lamps_cost(*lamps, name) + extra_cost + disks

        mass = cameras("mass_kg") + hw.count * self.lights.mass_kg
        camera_power = problem.carried_power_w(figures.camera_power_w)
        return {
            "cost": money("price"),
            "cost_limit_value": money("limit_price"),
            "mass_kg": mass + extra_mass,
            "camera_power_w": camera_power,
            "camera_peak_power_w": problem.camera_power_w(self.cameras),
            "power_w": camera_power + figures.light_power_w,
        }

    def drawn_w(self, index: int, settings: SettingRows, figures: Figures) -> dict[str, float]:
        """Mean power in one scene by what of the bill draws it; the extras apart, which say so themselves."""
        problem = self.problem
        n, camera = problem.mission.vehicle.camera_count, problem.parts.cameras[self.hardware.camera]
        fed_w = np.array([problem.host_share(camera) * number(camera.host_power_w, 0.0)])
        computer = replace(self.cameras, power_w=fed_w, standby_w=np.zeros(1))
        vehicle = problem.scenes[index].view.vehicle
        computer_w = n * float(camera_power_w(vehicle, computer, settings.rate_hz, settings.exposure_s)[0])
        cameras_w = n * float(figures.camera_power_w[0]) - computer_w
        light_w = float(figures.light_power_w[0])
        return {"camera": cameras_w, "complete": cameras_w, "computer": computer_w, "light": light_w}


def design_model(problem: Problem, hardware: Hardware) -> DesignModel:
    """The model of one hardware, made once a problem: the light's integrals are its cost."""
    if hardware not in problem.known_models:
        problem.known_models[hardware] = DesignModel(problem, hardware)
    model: DesignModel = problem.known_models[hardware]
    return model


def _setting_rows(
    f_number: Any, exposure: Any, pulse: Any, gain: Any, level: Any, rate: Any, dioptre: Any
) -> SettingRows:
    """One design's settings as columns of length one."""
    values = [f_number, exposure, np.inf if pulse is None else pulse, gain, level, rate, dioptre]
    return SettingRows(*(np.array([value], float) for value in values))
