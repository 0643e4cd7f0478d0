"""A mission and its parts, tabulated: what evaluation and search both start from.

Scenes, hardware columns, light optics, mounts and contracted spectra, built once for one end of
the estimates (central, good, bad). A design is a row of indices into these tables.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np

from uwopt.arrays import Array
from uwopt.catalog import money
from uwopt.catalog.interfaces import shares_computer
from uwopt.catalog.parts.kinds import FAVOURED
from uwopt.catalog.parts.light import NO_LAMP
from uwopt.catalog.records import Camera, Part
from uwopt.catalog.rest import (
    DISK_GB,
    Per,
    RestItem,
    RestNeeds,
    disk_price_per_gb,
    rest_items,
    whole_disks_gb,
)
from uwopt.catalog.spacers import spacer_mass_g, spacer_price
from uwopt.forward import switching
from uwopt.forward.fixed_settings import at_exposure, at_level
from uwopt.forward.lamps import (
    Mount,
    distinct_optics,
    light_counts,
    mission_mounts,
)
from uwopt.forward.once import Once
from uwopt.forward.part_columns import Cameras, End, Lenses, Lights, Ports
from uwopt.forward.part_rows import camera_rows, lens_rows, light_rows, limit_end, number, port_rows
from uwopt.forward.parts import Parts, estimated
from uwopt.forward.scene import SceneOptics, glass_index, scene_optics, seen_anew
from uwopt.forward.spectra import Contraction, LightPart
from uwopt.forward.views import port_shape, port_shapes
from uwopt.mission.duration import Duration
from uwopt.mission.mission import Mission
from uwopt.model import fineness as fine
from uwopt.model.beam import Beam
from uwopt.model.effects import FULL, PAPER, Effects
from uwopt.model.image_mean import PIXELS_A_SIDE
from uwopt.model.imaging import PortShape
from uwopt.units import db_to_ratio

#: Distances in water at which lenses are meant to be focused, from places of cameras and lenses, pair by pair.
MeantFocus = Callable[[Array, Array], Array]
#: Columns of ports that views and light depend on.
PORT_OPTICS = (
    "is_dome", "outer_radius_m", "thickness_m", "refractive_index", "gap_m", "clear_radius_m"
)  # fmt: skip


#: Columns of parts that were tabulated before: with housings there are many, and hundreds of states of each.
COLUMNS: Once[Any] = Once(64, most_records=50_000)


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
        have_estimates: bool = False,
    ):
        """Tabulate them; `have_estimates`: the parts are another such problem's, or states of those."""
        parts = parts if have_estimates else estimated(mission, parts)
        self.mission, self.parts, self.paper, self.end = mission, parts, paper, end
        self.known_models: dict[Any, Any] = {}  # by hardware; see `design_model.design_model`
        self.known_light: dict[Any, Any] = {}  # of hardware in these scenes, whatever is asked of it there
        fixed = mission.fixed
        self.f_number = fixed.f_number  # at which every iris stands; None: where it is best
        self.focus_shares: Array | None = None  # of the distance meant at which lenses stand; see `focused_at`
        self.meant_m: MeantFocus | float | None = None  # in water, of lenses, or by pair; None: where it is best
        self.effects = PAPER if paper else effects
        self.owned_lights = owned_lights or {}
        self.count_range = counts or light_counts(mission)
        self.mounts = tuple(mission_mounts(mission) if mounts is None else mounts)
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
        money = mission.limits.currency, tuple(sorted(mission.limits.rates.items()))

        def tabulated(kind: str, rows: Callable[..., Any], *more: Any, **own: Any) -> Any:
            """Of parts of a kind; `more`: what else of this mission, as it is hashed."""
            of_kind = getattr(parts, kind)
            return COLUMNS.of(
                of_kind, (kind, money, end, high, *more),
                lambda: rows(of_kind, money=self.money, end=end, high_basis=high, **own),
            )  # fmt: skip

        shares = np.array([self.host_share(part) for part in parts.cameras])
        computers = np.array([self.computers(part) for part in parts.cameras], float)
        self.cameras, self.efficiencies = tabulated(
            "cameras", camera_rows, paper, shares.tobytes(), computers.tobytes(),
            paper=paper, host_share=shares, computers=computers,
        )  # fmt: skip
        self.lenses: Lenses = tabulated("lenses", lens_rows)
        self.ports: Ports = tabulated("ports", port_rows, glass_index=glass_index)
        self.optics, optics_index = distinct_optics(
            parts.lights, [scene.n_water for scene in self.scenes], end, paper=paper
        )
        vehicle = mission.vehicle
        self_fed = "battery" in (vehicle.lamp_supply, vehicle.supply)  # else the lamps' power counts whatever feeds it
        self.lights: Lights = tabulated(
            "lights", light_rows, paper, tuple(optics_index), self_fed,
            paper=paper, optics_index=optics_index, self_fed=self_fed,
        )  # fmt: skip
        self.cameras = at_exposure(self.cameras, fixed.exposure_ms)
        self.lights = at_level(self.lights, fixed.dim_frac)
        if self.rest:
            self._add_rest(high)
        self.fineness = self.scenes[0].fineness
        self.contractions = self.contracted(self.scenes)

    def contracted(self, scenes: Sequence[SceneOptics]) -> list[Contraction]:
        """The spectra of this problem's lamps and sensors in these scenes."""
        multiple = self.effects.multiple_scattering
        return [
            Contraction(scene, self.optics, self.efficiencies, scene_index=index, multiple=multiple)
            for index, scene in enumerate(scenes)
        ]

    def having(self, **changes: Any) -> Problem:
        """The same but for these attributes; models of its hardware are made anew unless they are said to stay."""
        changed = copy(self)
        changed.__dict__.update({"known_models": {}, **changes})
        return changed

    def with_effects(self, effects: Effects) -> Problem:
        """The same tables in a model that keeps these effects."""
        own = PAPER if self.paper else effects
        counted = [one.counting(own.multiple_scattering) for one in self.contractions]
        return self.having(effects=own, known_light={}, contractions=counted)

    def with_mission(self, mission: Mission) -> Problem:
        """The same tables for a mission that differs in its limits of power and cost alone."""
        return self.having(mission=mission)

    def scenes_for(self, mission: Mission) -> list[SceneOptics] | None:
        """These scenes with what a mission asks for in them; None where it is about other scenes."""
        if len(self.scenes) != len(mission.scenes) or self.paper != (mission.physics == "paper"):
            return None
        made = [seen_anew(scene, mission.scene_view(index)) for index, scene in enumerate(self.scenes)]
        known = [scene for scene in made if scene is not None]
        return known if len(known) == len(made) else None

    def asking(self, mission: Mission) -> Problem:
        """The same tables for a mission that asks for other things in the same scenes, but of no column of parts."""
        scenes = self.scenes_for(mission)
        assert scenes is not None, "what is asked changes no scene"
        changed = self.having(mission=mission, scenes=scenes, contractions=self.contracted(scenes))
        changed.__dict__.pop("duration", None)  # depends on limits of energy
        return changed

    def at_limit_prices(self) -> Problem:
        """The same tables with every price as it counts against the limit of cost."""
        tables = {kind: getattr(self, kind) for kind in ("cameras", "lenses", "ports", "lights")}
        beside = {name: getattr(self, name) for name in ("disk_prices", "spacers", "control")}
        return self.having(
            **{kind: replace(rows, price=rows.limit_price) for kind, rows in tables.items()},
            **{name: prices | {"price": prices["limit_price"]} for name, prices in beside.items()},
        )

    def in_scenes(self, scenes: list[SceneOptics]) -> Problem:
        """The same parts in other water or over another floor; heights and indices of refraction must be the same."""
        return self.having(scenes=scenes, known_light={}, contractions=self.contracted(scenes))

    def over_bands(self, scenes: list[SceneOptics]) -> Problem:
        """The same parts and light, seen over other bands of altitudes, one for all or one of each camera."""
        return self.having(scenes=scenes, known_light={})

    def scenes_of(self, camera: Array) -> list[SceneOptics]:
        """The scenes as these cameras fly over them, by row, where each has a band of its own."""
        return [
            scene if scene.range_m.ndim == 1 else replace(scene, range_m=scene.range_m[:, camera])
            for scene in self.scenes
        ]

    def focused_at(self, shares: Array) -> Problem:
        """The same problem with lenses that stand at so much of the distance meant, by camera (n,), as far as doubted.

        Of shares (k, n) the first is where they stand; what must be sharp is so at each of the k.
        """
        return self.having(focus_shares=np.atleast_2d(shares))

    def focused_on(self, distance_m: MeantFocus | float | None) -> Problem:
        """The same problem with lenses meant to be focused at a distance in the first scene's water; None: at best.

        One for all, or from places of cameras and lenses, pair by pair.
        """
        return self.having(meant_m=distance_m)

    def at_f_number(self, f_number: float) -> Problem:
        """The same tables with the iris of every lens at one stop, which must lie on its ring."""
        return self.having(f_number=f_number)

    def over(
        self, parts: Parts, *, mission: Mission | None = None, scenes: list[SceneOptics] | None = None,
        counts: tuple[int, int] | None = None, mounts: Sequence[Mount] | None = None, have_estimates: bool = False,
    ) -> Problem:  # fmt: skip
        """Tables of other parts, as these are where nothing else is said; a mission brings its own scenes."""
        own = self.scenes if mission is None else None
        return Problem(
            mission or self.mission, parts, paper=self.paper, owned_lights=self.owned_lights,
            counts=counts or self.count_range, mounts=self.mounts if mounts is None else mounts, scenes=scenes or own,
            effects=self.effects, have_estimates=have_estimates,
        )  # fmt: skip

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
        """Cost, mass [kg] and power [W] of what every system carries beside the parts; of the rest its mass alone.

        The rest's cost counts with cameras and lamps, its mass here: a battery has a housing of its own.
        """
        items = self.mission.catalog.extras
        rest_g = sum(number(i.mass_g, 0.0, self.end, FAVOURED["mass_g"]) for i in self.rest if i.mass_g)
        return (
            float(sum(item.cost or 0.0 for item in items)),
            float(sum(item.mass_kg or 0.0 for item in items)) + 1e-3 * rest_g,
            float(sum(item.power_w or 0.0 for item in items)),
        )

    @cached_property
    def rest(self) -> tuple[RestItem, ...]:
        """Connectors, cables, electronics, spares and test, where the mission wants them counted."""
        if self.mission.catalog.rest == "none":
            return ()
        vehicle = self.mission.vehicle
        return rest_items(
            RestNeeds(
                self.mission.required_depth_m, vehicle.light_count[1] > 0, vehicle.camera_count, vehicle.cable_m,
                vehicle.battery_wh if vehicle.supply == "battery" else None,
            )
        )  # fmt: skip

    def rest_price(self, per: Per, end: End) -> float:
        """What the rest costs once for a system, or for each camera or lamp, in the mission's currency."""
        favoured = FAVOURED["price"]
        return sum(self.money(number(i.price, 0.0, end, favoured), "USD") for i in self.rest if i.per == per)

    def _add_rest(self, high_basis: bool) -> None:
        """Each camera costs its own rest and its share of the system's; each lamp that is bought its own."""
        ends: dict[str, End] = {"price": self.end, "limit_price": limit_end(self.end, high_basis)}
        share = 1.0 / self.mission.vehicle.camera_count
        for name, end in ends.items():
            tethered = np.array([part.tethered for part in self.parts.cameras], float)
            camera = tethered * self.rest_price("camera", end) + share * self.rest_price("system", end)
            lamp = self.wired * self.rest_price("lamp", end)
            self.cameras = replace(self.cameras, **{name: getattr(self.cameras, name) + camera})
            self.lights = replace(self.lights, **{name: getattr(self.lights, name) + lamp})

    def disks_gb(self, cameras: Cameras, rates_hz: Sequence[Array]) -> Array:
        """Whole disks that a system buys for what its images fill beyond those of its computers, (n,) [GB].

        rates_hz : of the images, by scene; a camera that keeps them on a card of its own buys none
        """
        count, duration = self.mission.vehicle.camera_count, self.duration
        filled = duration.storage_of(duration.mean([count * cameras.frame_mb * rate for rate in rates_hz]))
        if filled is None or self.mission.catalog.rest == "none":
            return np.zeros(len(cameras.price))
        beyond_gb = np.maximum(filled - cameras.disk_gb, 0.0)
        computers = np.where(np.isfinite(cameras.disk_gb), cameras.disk_gb, DISK_GB) / DISK_GB
        return np.asarray(computers * whole_disks_gb(beyond_gb / computers))

    @cached_property
    def disk_prices(self) -> dict[str, float]:
        """What a gigabyte of disk costs, and what of it counts against a budget."""
        per_gb, favoured = disk_price_per_gb().quantity(), FAVOURED["price"]
        ends = {"price": self.end, "limit_price": limit_end(self.end, self.mission.limits.cost_basis == "high")}
        return {name: self.money(number(per_gb, 0.0, end, favoured), "USD") for name, end in ends.items()}

    @cached_property
    def spacers(self) -> dict[str, float]:
        """What the rings behind one lens cost, what of it counts against a budget, and what they weigh."""
        price, favoured = spacer_price(), FAVOURED["price"]
        ends = self.end, limit_end(self.end, self.mission.limits.cost_basis == "high")
        value, limit = (self.money(number(price, 0.0, end, favoured), "USD") for end in ends)
        mass_g = number(spacer_mass_g(), 0.0, self.end, FAVOURED["mass_g"])
        return {"price": value, "limit_price": limit, "mass_kg": 1e-3 * mass_g}

    @cached_property
    def port_groups(self) -> list[Array]:
        """Indices of ports that differ by housing, price or mass alone, and so share views and light."""
        columns = [getattr(self.ports, name) for name in PORT_OPTICS]
        groups: dict[Any, list[int]] = {}
        for index, part in enumerate(self.parts.ports):
            groups.setdefault((part.id, *(float(column[index]) for column in columns)), []).append(index)
        return [np.array(group, int) for group in groups.values()]

    @cached_property
    def ties(self) -> tuple[Array, Array, Array]:
        """For each camera, lens and port which complete camera it is a piece of; 0 of none: equals go together."""
        kinds: tuple[Sequence[Part], ...] = (self.parts.cameras, self.parts.lenses, self.parts.ports)
        names = sorted({part.complete for parts in kinds for part in parts} - {""})
        number = {name: index for index, name in enumerate(["", *names])}
        camera, lens, port = (np.array([number[part.complete] for part in parts], int) for parts in kinds)
        return camera, lens, port

    @cached_property
    def like_port(self) -> Array:
        """For each port the first with the same optics."""
        first = np.zeros(len(self.parts.ports), int)
        for group in self.port_groups:
            first[group] = group[0]
        return first

    @property
    def counts_host(self) -> bool:
        """Whether the computer that takes the images counts, in power and cost."""
        return self.mission.catalog.host == "estimate"

    def beside_camera(self, camera: Camera) -> bool:
        """Whether each camera of this kind has a computer of its own, for its cable does not reach the common one."""
        vehicle = self.mission.vehicle
        return not shares_computer(camera.interface, vehicle.cable_m, vehicle.camera_count)

    def computers(self, camera: Camera) -> int:
        """How many computers take the images: one for all cameras, or one beside each of this kind."""
        return self.mission.vehicle.camera_count if self.beside_camera(camera) else 1

    def host_share(self, camera: Camera) -> float:
        """How much of a computer each camera of this kind pays and feeds."""
        return self.computers(camera) / self.mission.vehicle.camera_count if self.counts_host else 0.0

    def gains(self, scene_index: int, most: Array) -> tuple[float, Array]:
        """Lowest and highest gain, ratios: those of cameras, what a scene allows, or the one that is fixed."""
        allowed_db = self.scenes[scene_index].view.requirements.max_gain_db
        high = most if allowed_db is None else np.minimum(most, db_to_ratio(allowed_db))
        fixed = self.mission.fixed.gain
        return (1.0, high) if fixed is None else (fixed, np.minimum(high, fixed))

    @cached_property
    def duration(self) -> Duration:
        """How long the mission takes, and what it may use up."""
        return Duration.of(self.mission)

    @property
    def scene_power_limit_w(self) -> float:
        """Highest mean power in any one scene, by the limits of power and of energy; inf: none."""
        limit_w = self.mission.limits.power_w
        return min(np.inf if limit_w is None else limit_w, self.duration.scene_power_limit_w)

    def camera_power_w(self, cameras: Cameras) -> Array:
        """Power of all cameras and of what else every system carries, while they are on."""
        return np.asarray(self.mission.vehicle.camera_count * cameras.power_w + self.extras[2])

    def carried_power_w(self, one_camera_w: Array) -> Array:
        """Mean power of all cameras and of what else every system carries, from that of one camera."""
        return np.asarray(self.mission.vehicle.camera_count * one_camera_w + self.extras[2])

    def camera_powers_w(self, cameras: Cameras, rates_hz: Sequence[Array | float] | None = None) -> list[Array]:
        """The same by scene, at the frame rate of each; at none: no less at any rate."""
        rates = [0.0] * len(self.scenes) if rates_hz is None else rates_hz
        return [
            self.carried_power_w(switching.camera_power_w(scene.view.vehicle, cameras, rate))
            for scene, rate in zip(self.scenes, rates, strict=True)
        ]

    def least_camera_power_w(self, cameras: Cameras, rates_hz: Sequence[Array | float] | None = None) -> Array:
        """The least of them over the scenes."""
        return np.asarray(np.min(self.camera_powers_w(cameras, rates_hz), axis=0))

    def shape(self, port_index: int, scene_index: int) -> PortShape:
        """One port in one scene's water."""
        plain = port_shape(self.ports, port_index, self.scenes[scene_index])
        return plain._replace(window_angle=self.effects.window_angle)

    def shapes(self, ports: Array, scene_index: int) -> Iterator[tuple[Array, PortShape]]:
        """The same of ports row by row, (n,): one shape of columns for each geometry, with the places of its rows."""
        for mine, plain in port_shapes(self.ports, ports, self.scenes[scene_index]):
            yield mine, plain._replace(window_angle=self.effects.window_angle)

    def unlit(self, light: int) -> bool:
        """Whether this light stands for no lamp."""
        return self.parts.lights[light].id == NO_LAMP.id

    def lamps_carried(self, design: Any) -> int:
        """How many lamps a design has: none where its light stands for no lamp."""
        return 0 if self.unlit(design.light) else int(design.count)

    def are_unlit(self, light: Array) -> bool:
        """Whether all of these lights stand for no lamp."""
        return all(self.unlit(int(one)) for one in np.unique(light))

    def is_dark(self, optics: int) -> bool:
        """Whether no lamp has such optics, but what stands for none."""
        return not self.burns[self.lights.optics_index == optics].any()

    @cached_property
    def control(self) -> dict[str, float]:
        """What is bought once where lamps burn costs, and what of it counts against a budget."""
        ends = {"price": self.end, "limit_price": limit_end(self.end, self.mission.limits.cost_basis == "high")}
        return {name: self.rest_price("lighting", end) for name, end in ends.items()}

    @cached_property
    def burns(self) -> Array:
        """Whether each light is a lamp, and not none at all, (n_lights,) of 1 and 0."""
        return np.array([part.id != NO_LAMP.id for part in self.parts.lights], float)

    @cached_property
    def wired(self) -> Array:
        """Whether each light is a lamp with a cable, (n_lights,) of 1 and 0; neither none at all nor a torch is."""
        return self.burns * np.array([part.wired for part in self.parts.lights], float)

    @property
    def illuminators(self) -> int:
        """Lights, each in all its numbers and mounts."""
        return len(self.parts.lights) * self.lamp_variants

    @property
    def lamp_variants(self) -> int:
        """In how many numbers and mounts each lamp comes."""
        low, high = self.count_range
        return (high - low + 1) * len(self.mounts)

    def lamps_cost(self, light: Array, count: Array, name: Literal["price", "limit_price"] = "price") -> Array:
        """What so many lamps cost that are not owned yet, with what switches them, (n,)."""
        bought = self.lamps_to_buy(light, count) * getattr(self.lights, name)[light]
        return np.asarray(bought + self.wired[light] * self.control[name])

    def lamps_to_buy(self, light: Array, count: Array) -> Array:
        """How many of `count` lamps are not owned yet."""
        owned = np.array([self.owned_lights.get(part.id, 0) for part in self.parts.lights], float)
        return np.asarray(np.maximum(count - owned[light], 0.0))

    # ------------------------------------------------------------ light

    def beam(self, scene_index: int, optics: int) -> Beam:
        """The beam of one light optics in one scene's water."""
        return self.optics[optics].beams[scene_index]

    def floor_lobe(self, scene_index: int, optics: int, mount: Mount, range_m: float) -> Beam:
        """The beam as it falls on the floor so far along the axis, widened by what scatters on the way."""
        return self.contractions[scene_index].lobe(optics, mount.way_m(range_m))

    def lamp_leg_per_m(self, scene_index: int, optics: int) -> Array:
        """K on the way from lamps of one light optics to the floor of one scene, by wavelength."""
        contraction = self.contractions[scene_index]
        return contraction.lamp_leg_per_m(int(contraction.spectrum_of[optics]))

    def table(
        self, scene_index: int, spectrum: int, efficiency: int, channel: str | None = None, *,
        part: LightPart = "image", range_m: float = 0.0,
    ) -> Any:  # fmt: skip
        """Water's loss table of one scene, light spectrum and efficiency curve."""
        return self.contractions[scene_index].table(
            spectrum, efficiency, channel, lowest_m=self.lowest_m(scene_index),
            nearest_m=self.nearest_m(scene_index, 0), part=part, range_m=range_m,
        )  # fmt: skip

    def lowest_m(self, scene_index: int) -> float:
        """Least height of any lamp above the floor, from which tables of water's loss reach up."""
        scene = self.scenes[scene_index]
        near, cos, sin = float(scene.altitude_m[0]), np.cos(scene.pitch_rad), np.sin(scene.pitch_rad)
        heights = [near - cos * m.z_m + sin * m.x_m for mount in self.mounts for m in mount.explicit]
        return max(float(min([near, *heights])), 1e-4)

    def nearest_m(self, scene_index: int, altitude: int) -> float:
        """No ray in water is shorter at this altitude, behind whichever of the ports.

        A tilted dome's centre lies a radius behind its vertex, whose height is the altitude; a tilted window's near
        side is lower than its middle.
        """
        scene, ports = self.scenes[scene_index], self.ports
        if not scene.pitch_rad:
            return float(scene.range_m[altitude])
        lower = (ports.gap_m + ports.thickness_m) * self.widest_tangent * np.sin(scene.pitch_rad)
        lower = np.where(ports.is_dome, ports.outer_radius_m * (1.0 - np.cos(scene.pitch_rad)), lower)
        return max(float(scene.altitude_m[altitude]) - float(lower.max(initial=0.0)), 1e-4)

    @cached_property
    def widest_tangent(self) -> float:
        """No camera and lens see farther from the axis than at this tangent in air."""
        half_m = 0.5 * np.hypot(self.cameras.resolution_x_px, self.cameras.resolution_y_px) * self.cameras.pixel_pitch_m
        return float(half_m.max(initial=0.0)) / float(self.lenses.focal_length_m.min(initial=np.inf))

    def pixels_a_side(self, scene_index: int) -> int:
        """Points a side of the grid on which one scene's worst pixel is looked for; finer ones hold the coarser."""
        half = PIXELS_A_SIDE // 2
        return 2 * fine.scaled(half, self.scenes[scene_index].fineness.places) + 1

    def with_mount(self, mount: Mount) -> Problem:
        """The same tables with lamps that may stand there too."""
        mounts = self.mounts if mount in self.mounts else (*self.mounts, mount)
        return self.having(mounts=mounts, known_models=self.known_models)

    def standing_at(self, mount: Mount) -> Problem:
        """The same tables with lamps that stand there alone."""
        return self.having(mounts=(mount,))

    def standing_as_asked(self) -> Problem:
        """The same tables with as many lamps as the mission allows, wherever it lets them stand."""
        return self.having(mounts=tuple(mission_mounts(self.mission)), count_range=light_counts(self.mission))

    def with_count(self, count: int) -> Problem:
        """The same tables with so many lamps."""
        return self.having(count_range=(count, count))

    def reaching(self, widest_m: Sequence[float]) -> Problem:
        """The same tables for images that reach no farther from the axis than this, by scene."""
        contractions = [self._reaching(index, float(m)) for index, m in enumerate(widest_m)]
        return self.having(contractions=contractions, known_models=self.known_models)

    def _reaching(self, scene_index: int, widest_m: float) -> Contraction:
        scene = self.scenes[scene_index]
        spread = max([0.0] + [abs(m.baseline_m) for m in self.mounts])
        spread = max([spread] + [float(np.hypot(e.x_m, e.y_m)) for m in self.mounts for e in m.explicit])
        height = float(scene.range_m[-1]) + max([0.0] + [-e.z_m for m in self.mounts for e in m.explicit])
        deepest = float(scene.range_m[-1]) + float(self.ports.outer_radius_m.max(initial=0.0))
        return self.contractions[scene_index].reaching(
            float(np.hypot(height, widest_m + spread)), float(np.hypot(deepest, widest_m))
        )

    # ------------------------------------------------------------ rows for the settings
