"""A mission and its parts, tabulated: what evaluation and search both start from.

Scenes, hardware columns, light optics, mounts and contracted spectra, built once for one end of
the estimates (central, good, bad). A design is a row of indices into these tables.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.catalog import money
from uwopt.catalog.records import Camera, Lens, Light, Port
from uwopt.forward.lamp_light import ImageLight, LampField, SunLight, Veils
from uwopt.forward.lamps import (
    LightOptics,
    lamp_set,
    light_optics,
    luminous_weight,
    mounted_lamps,
    on_axis_gain,
)
from uwopt.forward.part_columns import (
    CONTINUOUS,
    FLASH,
    PULSED,
    Cameras,
    End,
    Lenses,
    Lights,
    Ports,
    camera_rows,
    lens_rows,
    light_rows,
    port_rows,
)
from uwopt.forward.scene import SceneOptics, glass_index, scene_optics
from uwopt.forward.setting_rows import SceneRows
from uwopt.forward.sharpness import SharpRows, sharp_rows
from uwopt.forward.spectra import Contraction
from uwopt.forward.views import Views, port_shape
from uwopt.mission.mission import Mission
from uwopt.model import fineness as fine
from uwopt.model import imaging
from uwopt.model.beam import Beam
from uwopt.model.effects import FULL, PAPER, Effects
from uwopt.model.imaging import Lamps, PortShape

Array = NDArray[Any]
SHORTEST_TIME_S = 1e-9


@dataclass(frozen=True)
class Parts:
    """The parts that take part, as records."""

    cameras: tuple[Camera, ...]
    lenses: tuple[Lens, ...]
    ports: tuple[Port, ...]
    lights: tuple[Light, ...]


@dataclass(frozen=True)
class Mount:
    """A place for the lights: explicit lamps, or a baseline and tilt for any number of them."""

    baseline_m: float = 0.0
    tilt_deg: float = 0.0
    explicit: tuple[Any, ...] = ()

    def lamps(self, count: int) -> Lamps:
        """Where `count` lamps stand."""
        if self.explicit:
            return mounted_lamps(self.explicit)
        return lamp_set(count, baseline_m=self.baseline_m, tilt_rad=float(np.deg2rad(self.tilt_deg)))


@dataclass(frozen=True)
class Focused:
    """What an imager brings to one scene beside its view: focus, f-numbers, rate and longest times."""

    dioptre_per_m: Array
    working_factor: Array
    n_low: Array
    n_high: Array
    rate_hz: Array
    blur_time_s: Array
    skew_px: Array  # of a rolling shutter under lamps that burn; 0 for a global one

    def take(self, index: Array) -> Focused:
        """These rows only."""
        return Focused(**{f.name: getattr(self, f.name)[index] for f in fields(self)})


class Problem:
    """Tables of one mission over chosen parts, at one end of the estimates."""

    def __init__(
        self,
        mission: Mission,
        parts: Parts,
        *,
        paper: bool,
        end: End = "central",
        owned_lights: dict[str, int] | None = None,
        counts: tuple[int, int] | None = None,
        mounts: Sequence[Mount] | None = None,
        water_table: str | None = None,
        scenes: list[SceneOptics] | None = None,
        effects: Effects = FULL,
        fineness: fine.Fineness = fine.DEFAULT,
    ):
        self.mission, self.parts, self.paper, self.end = mission, parts, paper, end
        self.known_models: dict[Any, Any] = {}  # by hardware; see `design_model.design_model`
        self.effects = PAPER if paper else effects
        self.owned_lights = owned_lights or {}
        self.count_range = counts or light_counts(mission)
        self.mounts = list(mounts) if mounts is not None else mission_mounts(mission)
        base_dir: Path | None = mission.base_dir
        self.scenes: list[SceneOptics] = scenes or [
            scene_optics(
                mission.scene_view(i),
                paper=paper,
                base_dir=base_dir,
                water_table=water_table,
                fineness=fineness,
            )
            for i in range(len(mission.scenes))
        ]
        high = mission.limits.cost_basis == "high"
        self.cameras, self.efficiencies = camera_rows(
            parts.cameras, money=self.money, end=end, paper=paper, high_basis=high
        )
        self.lenses: Lenses = lens_rows(parts.lenses, money=self.money, end=end, high_basis=high)
        self.ports: Ports = port_rows(
            parts.ports, money=self.money, glass_index=glass_index, end=end, high_basis=high
        )
        self.optics, optics_index = distinct_optics(
            parts.lights, [scene.n_water for scene in self.scenes], end, paper=paper
        )
        self.lights: Lights = light_rows(
            parts.lights, money=self.money, optics_index=optics_index, end=end, paper=paper, high_basis=high
        )
        self.fineness = self.scenes[0].fineness
        self.contractions = [Contraction(scene, self.optics, self.efficiencies) for scene in self.scenes]

    def with_effects(self, effects: Effects) -> Problem:
        """The same tables in a model that keeps these effects."""
        changed = copy(self)
        changed.effects, changed.known_models = PAPER if self.paper else effects, {}
        return changed

    def with_fineness(self, fineness: fine.Fineness) -> Problem:
        """The same problem with its integrals taken more or less finely; all tables anew."""
        return Problem(
            self.mission, self.parts, paper=self.paper, end=self.end, owned_lights=self.owned_lights,
            counts=self.count_range, mounts=self.mounts, effects=self.effects, fineness=fineness,
        )  # fmt: skip

    def money(self, amount: float, currency: str) -> float:
        """An amount in the mission's currency."""
        limits = self.mission.limits
        return money.to_currency(amount, currency, limits.currency, limits.rates)

    @cached_property
    def extras(self) -> tuple[float, float, float]:
        """Cost, mass [kg] and power [W] of what every system carries beside the parts."""
        items = self.mission.catalog.extras
        return (
            float(sum(item.cost or 0.0 for item in items)),
            float(sum(item.mass_kg or 0.0 for item in items)),
            float(sum(item.power_w or 0.0 for item in items)),
        )

    def camera_power_w(self, cameras: Cameras) -> Array:
        """Power of all cameras and of what else every system carries."""
        return np.asarray(self.mission.vehicle.camera_count * cameras.power_w + self.extras[2])

    def shape(self, port_index: int, scene_index: int) -> PortShape:
        """One port in one scene's water."""
        plain = port_shape(self.ports, port_index, self.scenes[scene_index])
        return plain._replace(window_angle=self.effects.window_angle)

    def lamps_to_buy(self, light: Array, count: Array) -> Array:
        """How many of `count` lamps are not owned yet."""
        owned = np.array([self.owned_lights.get(part.id, 0) for part in self.parts.lights], float)
        return np.asarray(np.maximum(count - owned[light], 0.0))

    # ------------------------------------------------------------ light

    def beam(self, scene_index: int, optics: int) -> Beam:
        """The beam of one light optics in one scene's water."""
        return self.optics[optics].beams[scene_index]

    def image_light(
        self, scene_index: int, view: Views, camera: Array, *, port_index: int, optics: int, mount: Mount,
        count: int = 2, channel: str | None = None, pixels: bool = False, veils: Veils = "all", means: bool = True,
        known: ImageLight | None = None,
    ) -> ImageLight:  # fmt: skip
        """Electrons per lm s of light behind the lamps' windows, by altitude: the constants of the imaging chain.

        All rows of `view` share the port; `camera` says whose sensor each is. `channel` picks one colour.
        `pixels`: also at the pixels that may be the worst; without `means` there alone. `veils` says which
        are worked out, beside what is `known`.
        """
        efficiency = self.cameras.qe_index[camera]
        parts = []
        for curve in np.unique(efficiency):
            mine = np.nonzero(efficiency == curve)[0]
            field = LampField(
                self, scene_index, port_index=port_index, optics=optics, mount=mount, count=count,
                efficiency=int(curve), channel=channel,
            )  # fmt: skip
            given = None if known is None else known.take(mine)
            light = field.light(view.take(mine), pixels=pixels, veils=veils, means=means, known=given)
            parts.append((mine, light))
        return ImageLight.joined(parts, len(camera))

    def sun_light(
        self, scene_index: int, view: Views, camera: Array, *, port_index: Array, mount: Mount | None = None,
        count: int = 2, channel: str | None = None, pixels: bool = False,
    ) -> SunLight | None:  # fmt: skip
        """Electrons per second of open shutter from the sun; None without sun.

        With `pixels` at the grid that the lamps at `mount` are seen on.
        """
        if not self.scenes[scene_index].sunlit or not self.effects.sunlight:
            return None
        from uwopt.forward.sun_light import SunField

        half = pixels and mount is not None and imaging.along_symmetric(mount.lamps(count))
        efficiency = self.cameras.qe_index[camera]
        columns: dict[str, Any] = {}
        for port in np.unique(port_index):
            for curve in np.unique(efficiency):
                mine = np.nonzero((port_index == port) & (efficiency == curve))[0]
                if len(mine) == 0:
                    continue
                field = SunField(
                    self, scene_index, port_index=int(port), efficiency=int(curve), channel=channel
                )
                light = field.light(view.take(mine), pixels=pixels, half_grid=half)
                for name in light.__dataclass_fields__:
                    part = getattr(light, name)
                    if part is None:
                        continue
                    column = columns.setdefault(name, np.empty((len(camera), *part.shape[1:])))
                    column[mine] = part
        return SunLight(**columns)

    def sharp_rows(
        self, scene_index: int, view: Views, *, camera: Array, lens: Array, port: Array, optics: int,
        dioptre_per_m: Array,
    ) -> SharpRows:  # fmt: skip
        """What the sharpness of designs under one light depends on beside their settings."""
        contraction = self.contractions[scene_index]
        return sharp_rows(
            self.scenes[scene_index], contraction, view, cameras=self.cameras.take(camera),
            lenses=self.lenses.take(lens), ports=self.ports.take(port), spectrum=int(contraction.spectrum_of[optics]),
            dioptre_per_m=dioptre_per_m, lateral_colour=self.effects.lateral_colour,
            image_curvature=self.effects.image_curvature,
        )  # fmt: skip

    def footprint_light(
        self, scene_index: int, view: Views, *, port_index: int, optics: int, mount: Mount, count: int,
        altitude: int,
    ) -> tuple[float, float]:  # fmt: skip
        """Mean and least floor illuminance per lumen over one imager's footprint [1/m^2]."""
        scene, beam = self.scenes[scene_index], self.beam(scene_index, optics)
        range_m = float(scene.range_m[altitude])
        weight = luminous_weight(scene, self.optics[optics])
        if self.paper:
            axis = float(on_axis_gain(beam, np.array([range_m]))[0])
            loss = float((weight * np.exp(-scene.lamp_attenuation_per_m * range_m)).sum() / weight.sum())
            return axis * loss, axis * loss
        return imaging.footprint_illuminance_per_lm(
            float(view.tan_along[0]), float(view.tan_across[0]), shape=self.shape(port_index, scene_index),
            range_m=range_m, lamps=mount.lamps(count), beam=beam, weight=weight,
            attenuation_per_m=scene.lamp_attenuation_per_m, fineness=scene.fineness,
        )  # fmt: skip

    def uniformity(self, scene_index: int, view: Views, **hardware: Any) -> Array:
        """Least over mean floor illuminance at every altitude; 0 where the footprint is dark."""
        pairs = [
            self.footprint_light(scene_index, view, altitude=n, **hardware)
            for n in range(len(self.scenes[scene_index].range_m))
        ]
        return np.array([least / mean if mean > 0 else 0.0 for mean, least in pairs])

    def table(
        self, scene_index: int, spectrum: int, efficiency: int, channel: str | None = None, *,
        forward: bool = False,
    ) -> Any:  # fmt: skip
        """Water's loss table of one scene, light spectrum and efficiency curve."""
        lowest = min(
            [float(self.scenes[scene_index].range_m[0])]
            + [
                float(self.scenes[scene_index].range_m[0]) - m.z_m
                for mount in self.mounts
                for m in mount.explicit
            ]
        )
        return self.contractions[scene_index].table(
            spectrum, efficiency, channel, lowest_m=max(lowest, 1e-4), forward=forward
        )

    def pixels_a_side(self, scene_index: int) -> int:
        """Points a side of the grid on which one scene's worst pixel is looked for; finer ones hold the coarser."""
        half = imaging.PIXELS_A_SIDE // 2
        return 2 * fine.scaled(half, self.scenes[scene_index].fineness.places) + 1

    def set_reach(self, scene_index: int, widest_m: float) -> None:
        """Tell the water tables how far from the axis any image reaches."""
        scene = self.scenes[scene_index]
        spread = max([0.0] + [abs(m.baseline_m) for m in self.mounts])
        spread = max([spread] + [float(np.hypot(e.x_m, e.y_m)) for m in self.mounts for e in m.explicit])
        height = float(scene.range_m[-1]) + max([0.0] + [-e.z_m for m in self.mounts for e in m.explicit])
        deepest = float(scene.range_m[-1]) + float(self.ports.outer_radius_m.max(initial=0.0))
        self.contractions[scene_index].set_reach(
            float(np.hypot(height, widest_m + spread)), float(np.hypot(deepest, widest_m))
        )

    # ------------------------------------------------------------ rows for the settings

    def scene_rows(
        self, scene_index: int, *, camera: Array, light: Array, count: Array, focused: Focused,
        image_light: ImageLight, sun: SunLight | None = None, sharp: SharpRows | None = None,
    ) -> SceneRows:  # fmt: skip
        """What the settings of n designs depend on in one scene."""
        scene = self.scenes[scene_index]
        needs, limits = scene.view.requirements, self.mission.limits
        cam, lamp = self.cameras.take(camera), self.lights.take(light)
        flash = lamp.kind == FLASH
        time_min, time_max, dark_time = light_times_s(cam, lamp, focused, limits.max_exposure_ms * 1e-3)
        light_lm = np.where(flash, lamp.full_light / lamp.flash_duration_s, lamp.full_light) * count
        full_power = lamp.full_power_w * count
        pulse_energy = lamp.pulse_energy_j * count
        sunlit_cap = None
        if sun is not None:  # the sun smears over the whole open shutter
            with np.errstate(divide="ignore"):
                longest = np.minimum(
                    np.minimum(cam.max_exposure_s, limits.max_exposure_ms * 1e-3), 1.0 / focused.rate_hz
                )
            sunlit_cap = np.minimum(longest + cam.exposure_offset_s, focused.blur_time_s)
        peak_at_full = np.where(flash, pulse_energy * focused.rate_hz, full_power)
        with np.errstate(divide="ignore", invalid="ignore"):
            peak_for_lights = (limits.peak_power_w or np.inf) - self.camera_power_w(cam)
            max_level = np.minimum(1.0, peak_for_lights / peak_at_full)
        max_level = np.where(np.isnan(max_level), 1.0, max_level)
        allowed = (focused.rate_hz <= lamp.max_rate_hz * (1 + 1e-12)) | (lamp.kind == CONTINUOUS)
        if needs.max_skew_px is not None:
            allowed &= (focused.skew_px <= needs.max_skew_px) | (lamp.kind != CONTINUOUS)
        shining = image_light.scaled(lamp.output_factor)
        return SceneRows(
            signal_e=shining.signal_e,
            worst_e=shining.worst_e,
            veil_e=shining.veil_e,
            worst_veil_e=shining.worst_veil_e,
            most_veil_e=shining.most_veil_e,
            open_max_s=sunlit_cap,
            sun_signal_e_s=None if sun is None else sun.signal_e_s,
            sun_veil_e_s=None if sun is None else sun.veil_e_s,
            worst_sun_signal_e_s=None if sun is None else sun.worst_e_s,
            worst_sun_veil_e_s=None if sun is None else sun.worst_veil_e_s,
            min_contrast=needs.min_contrast or 0.0,
            min_mtf=needs.min_mtf_half_nyquist or 0.0,
            sharp=sharp,
            nominal=scene.nominal,
            read_noise_e=cam.read_noise_e,
            gain_dn_per_e=cam.gain_dn_per_e,
            full_scale_dn=2.0**cam.bits - 1.0,
            black_level_dn=cam.black_level_dn,
            max_gain=cam.max_gain,
            well_e=cam.saturation_e,
            prnu_frac=cam.prnu_frac,
            dark_current_e_s=cam.dark_current_e_s,
            dark_time_s=dark_time,
            min_exposure_s=cam.min_exposure_s,
            exposure_offset_s=cam.exposure_offset_s,
            readout_s=cam.readout_s,
            flash_duration_s=lamp.flash_duration_s,
            time_min_s=time_min,
            time_max_s=np.where(allowed, time_max, -1.0),
            rate_hz=focused.rate_hz,
            kind=lamp.kind,
            light_lm=light_lm,
            full_power_w=full_power,
            pulse_energy_j=pulse_energy,
            levels=lamp.levels,
            dims_freely=lamp.dims_freely,
            min_level=lamp.min_level,
            max_level=max_level,
            working_factor=focused.working_factor,
            n_low=focused.n_low,
            n_high=focused.n_high,
            min_snr=needs.min_snr or 0.0,
            mean_level=needs.mean_level,
            highlight_ratio=needs.highlight_ratio,
        )


def light_times_s(
    camera: Cameras, light: Lights, focused: Focused, exposure_limit_s: float
) -> tuple[Array, Array, Array]:
    """Shortest and longest light-collecting time, and the longest exposure that dark current sees.

    Continuous: exposure + t_0. Pulsed LED: the pulse, all rows open. Flash: its whole duration, or less
    when a global shutter cuts it (exposure + t_0).
    """
    with np.errstate(divide="ignore"):
        exposure = np.minimum(np.minimum(camera.max_exposure_s, exposure_limit_s), 1.0 / focused.rate_hz)
        duty_time = light.max_duty / focused.rate_hz
    offset = camera.exposure_offset_s
    shortest = np.maximum(camera.min_exposure_s + offset, SHORTEST_TIME_S)
    longest = np.minimum(exposure + offset, focused.blur_time_s)
    open_time = exposure - camera.readout_s
    pulse_max = np.minimum(
        np.minimum(light.max_pulse_s, duty_time), np.minimum(open_time, focused.blur_time_s)
    )
    pulse_min = np.maximum(light.min_pulse_s, SHORTEST_TIME_S)
    cuts = camera.readout_s == 0.0
    flash_min = np.where(cuts, np.minimum(shortest, light.flash_duration_s), light.flash_duration_s)
    whole = np.where(open_time >= light.flash_duration_s, light.flash_duration_s, -1.0)
    flash_max = np.where(cuts, np.minimum(longest, light.flash_duration_s), np.where(
        whole <= focused.blur_time_s, whole, -1.0))  # fmt: skip
    pulsed, flash = light.kind == PULSED, light.kind == FLASH
    time_min = np.where(pulsed, pulse_min, np.where(flash, flash_min, shortest))
    time_max = np.where(pulsed, pulse_max, np.where(flash, flash_max, longest))
    time_max = np.where(camera.min_exposure_s > exposure * (1 + 1e-12), -1.0, time_max)
    dark_time = np.where(pulsed | flash, time_max + camera.readout_s, time_max - offset)
    return time_min, time_max, np.maximum(dark_time, 0.0)


def light_counts(mission: Mission) -> tuple[int, int]:
    """Fewest and most lamps; explicit mounts say how many there are."""
    if mission.vehicle.light_mounts:
        count = mission.vehicle.light_counts[-1]
        return count, count
    low, high = mission.vehicle.light_counts.start, mission.vehicle.light_counts.stop - 1
    return low, high


def mission_mounts(mission: Mission) -> list[Mount]:
    """The declared grid of mounts: explicit lamps, or baseline x tilt."""
    vehicle = mission.vehicle
    if vehicle.light_mounts:
        return [Mount(explicit=tuple(vehicle.light_mounts[: vehicle.light_counts[-1]]))]
    return [Mount(b, t) for b in vehicle.light_baseline_grid_m for t in vehicle.light_tilt_grid_deg]


def distinct_optics(
    lights: Sequence[Light], n_water: Sequence[float], end: End, *, paper: bool
) -> tuple[list[LightOptics], list[int]]:
    """Distinct beams with spectra, and each light's index into them."""
    found: dict[tuple[Any, ...], int] = {}
    optics: list[LightOptics] = []
    index = []
    for part in lights:
        item = light_optics(part, n_water=n_water, end=end, paper=paper)
        key = (item.beams, item.spectrum_id, item.spectrum)
        if key not in found:
            found[key] = len(optics)
            optics.append(item)
        index.append(found[key])
    return optics, index
