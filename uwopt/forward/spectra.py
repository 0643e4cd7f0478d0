"""Spectra contracted once: light x water x sensor as look-up tables of path length."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from functools import lru_cache, partial
from typing import Any, Literal

import numpy as np

from uwopt.arrays import Array
from uwopt.catalog.records import Curve
from uwopt.deadline import spend
from uwopt.forward.lamps import LAMP_FRONT_M, LightOptics, relative_spectrum
from uwopt.forward.once import HashedOnce
from uwopt.forward.scene import COLOURS, SceneOptics
from uwopt.model import sensor
from uwopt.model.beam import Beam, half_power_angle_rad
from uwopt.model.fineness import scaled
from uwopt.model.imaging import scatter_weight, signal_weight
from uwopt.model.path_table import PathTable, build_path_table
from uwopt.model.phase_formulas import molecular_per_sr
from uwopt.model.scattering import PhaseTable, look_up
from uwopt.model.spectrum import resample, resample_power
from uwopt.model.veil.geometry import OPTICAL_REACH, Scatterer
from uwopt.model.veil.wide import REACH as WIDE_REACH
from uwopt.model.veil.wide import kernel_shares
from uwopt.tolerances import SLACK

SpectrumKind = tuple[tuple[str, Curve | None], float | None]  # light's spectrum; its lobe, where K depends on it
LightPart = Literal["image", "near", "wide"]  # of floor light: what forms the image, and the forward veil's two parts

REACH_STEP = 1.3
ENDLESS = 16.0  # c + K times the path that stands for all of the water
MOST_ORDER, TABLE_ERROR_LOG = 16, 1e-6  # of tables of water's loss
MOST_TABLES = 512  # of them that a process keeps, some 20 kB each
TINY = 1e-300  # in place of a sum of weights that is zero: a black floor, a blind sensor
LARGEST_EXPONENT = 600.0  # of a veil over what it veils: exp(709) is the last that a float holds
PATH_CELLS = 8  # a side of all pairs of ways, in the least veil over them: of those to the camera, short near ones
NEAR_MARGIN = 0.999  # of the bound of the forward veil, for tables of the loss that it is worked out with
WIDE_MARGIN = 0.96  # of what comes from elsewhere: its spots and nodes tell up to 3 % too little of what is bounded


def efficiency_curve(curves: dict[str, Curve], wavelength_nm: Array, *, channel: str | None = None) -> Array:
    """Quantum efficiency on the grid; a colour sensor counts as (R + 2G + B)/4 unless a channel is named."""
    on_grid = {name: efficiency_on_grid(curve, wavelength_nm) for name, curve in curves.items()}
    if channel is not None:
        return np.asarray(on_grid.get(channel, on_grid.get("mono")))
    if "mono" in on_grid:
        return np.asarray(on_grid["mono"])
    return np.asarray(
        sensor.colour_mean_efficiency(on_grid["red"], green=on_grid["green"], blue=on_grid["blue"])
    )


def loss_table(
    weight: Array, *, k_lamp_per_m: Array, c_camera_per_m: Array, k_camera_per_m: Array | None = None, **asked: Any
) -> PathTable:
    """A table of water's loss, worked out once a process: missions one after another ask for the same ones.

    weight : (..., n), which holds the trapezoid's steps; all else as `build_path_table` takes it
    """
    legs = (k_lamp_per_m, c_camera_per_m, *(() if k_camera_per_m is None else (k_camera_per_m,)))
    return _loss_table(weight.shape, weight.tobytes(), *(leg.tobytes() for leg in legs), **asked)


@lru_cache(maxsize=MOST_TABLES)
def _loss_table(shape: tuple[int, ...], weight: bytes, *curves: bytes, **asked: Any) -> PathTable:
    """The same of curves as bytes."""
    names = ("k_lamp_per_m", "c_camera_per_m", "k_camera_per_m")
    legs: dict[str, Any] = dict(zip(names, map(np.frombuffer, curves), strict=False))
    return build_path_table(np.frombuffer(weight).reshape(shape), wavelength_nm=None, **legs, **asked)


def sees_colours(curves: dict[str, Curve]) -> bool:
    """Whether a sensor with these curves tells red, green and blue apart."""
    return all(name in curves for name in COLOURS)


def efficiency_on_grid(curve: Curve, wavelength_nm: Array) -> Array:
    """One channel on the grid, held beyond its ends; steps between two points count by where they lie.

    A filter's edge is often steeper than the grid: read at the points alone it would be half a step off.
    Not to be written to.
    """
    return _efficiency_on_grid(curve, np.asarray(wavelength_nm, float).tobytes())


@lru_cache(maxsize=1024)  # waters of one grid, some hundred in the doubt, share it: 1 kB each
def _efficiency_on_grid(curve: Curve, grid_nm: bytes) -> Array:
    made = _read_on_grid(curve, np.frombuffer(grid_nm))
    made.setflags(write=False)
    return made


def _read_on_grid(curve: Curve, wavelength_nm: Array) -> Array:
    at_nm, values = np.array(curve.x), np.array(curve.y)
    if np.diff(at_nm).min(initial=np.inf) >= np.diff(wavelength_nm).max():
        return resample(wavelength_nm, table_nm=at_nm, table_values=values, outside="hold")
    ends_nm = wavelength_nm[[0, -1]]
    inside = (at_nm > ends_nm[0]) & (at_nm < ends_nm[1])
    at_ends = resample(ends_nm, table_nm=at_nm, table_values=values, outside="hold")
    return resample_power(
        wavelength_nm,
        table_nm=np.r_[ends_nm[0], at_nm[inside], ends_nm[1]],
        table_values=np.r_[at_ends[0], values[inside], at_ends[1]],
    )


class Contraction:
    """The spectrum of one scene, contracted once for every pair of light spectrum and efficiency curve.

    `response(s, q)`: electrons per m^2 of pixel and lm s per m^2 on the floor, water apart.
    `table(s, q)`: water's loss relative to it over both legs. Tables are built when first needed.
    """

    def __init__(
        self, scene: SceneOptics, optics: Sequence[LightOptics], efficiencies: Sequence[dict[str, Curve]], *,
        scene_index: int = 0, multiple: bool = False,
    ):  # fmt: skip
        """Of the lamps' beams in the scene of that index; `multiple`: light scattered more than once counts."""
        self.scene, self.optics, self.scene_index = scene, optics, scene_index
        self.multiple = multiple and scene.counts_orders
        kinds: dict[SpectrumKind, int] = {}
        self.spectrum_of = np.empty(len(optics), int)
        for index, item in enumerate(optics):
            kind = ((item.spectrum_id, item.spectrum), self._lobe_rad(item))
            self.spectrum_of[index] = kinds.setdefault(kind, len(kinds))
        self.spectrum_names = [HashedOnce(name) for name, _ in kinds]
        self._lobes_rad = [lobe for _, lobe in kinds]
        self.efficiencies = list(efficiencies)
        self._curve_keys = [HashedOnce(sorted(curves.items())) for curves in efficiencies]
        self._reach_m: tuple[float, float] | None = None  # until `reaching` says how far tables must go

    def counting(self, multiple: bool) -> Contraction:
        """The same with light scattered more than once, or without."""
        if self.multiple == (multiple and self.scene.counts_orders):
            return self
        changed = Contraction(
            self.scene, self.optics, self.efficiencies, scene_index=self.scene_index, multiple=multiple
        )
        changed._reach_m = self._reach_m
        return changed

    def _lobe_rad(self, item: LightOptics) -> float | None:
        """Half angle of a lamp's lobe, where K depends on it."""
        return half_power_angle_rad(item.beams[self.scene_index]) if self.multiple else None

    def back_lobe(self, optics: int) -> Beam:
        """The beam of these lamps as the water sends it back, from no way at all to where little is left."""
        both = self.scene.attenuation_per_m + self.lamp_leg_per_m(int(self.spectrum_of[optics]))
        return self.lobe(optics, ENDLESS / max(float(both.min()), TINY), back=True)

    def lobe(self, optics: int, way_m: float, *, back: bool = False) -> Beam:
        """The beam of these lamps after a way through the water, over what K leaves of it.

        back : of backscatter, along all of that way
        """
        own, scene = self.optics[optics].beams[self.scene_index], self.scene
        if not self.multiple:
            return own
        name = self.spectrum_names[self.spectrum_of[optics]]
        key = ("lobe", own, name, way_m, back)
        return scene.once(key, lambda: scene.widened_lobe(
            own, relative_spectrum(name, scene.wavelength_nm), way_m=way_m, back=back
        ))  # fmt: skip

    def lamp_leg_per_m(self, spectrum: int) -> Array:
        """K on the way from these lamps to the floor, by wavelength."""
        lobe = self._lobes_rad[spectrum]
        if lobe is None:
            return self.scene.lamp_attenuation_per_m
        return self.scene.once(("lamp leg", lobe), lambda: self.scene.lamp_leg_per_m(lobe))

    def near_leg_per_m(self) -> Array:
        """Attenuation of light that comes from the floor to the camera near its straight way, image or veil."""
        if not self.multiple:
            return self.scene.lamp_attenuation_per_m
        return self.scene.once("near leg", self.scene.near_leg_per_m)

    def veil_leg_per_m(self, way_m: float) -> Array:
        """Attenuation of all light that comes from a floor so far off to the camera, by whatever way."""
        if not self.multiple:
            return self.scene.lamp_attenuation_per_m
        return self.scene.once(("veil leg", way_m), lambda: self.scene.veil_leg_per_m(way_m))

    def back_legs_per_m(self, spectrum: int) -> tuple[Array, Array]:
        """Attenuation of light that the water sends back: from these lamps, and to the camera."""
        lobe = self._lobes_rad[spectrum]
        if lobe is None:
            return self.scene.lamp_attenuation_per_m, self.scene.attenuation_per_m
        both = self.scene.once(("back leg", lobe), lambda: self.scene.back_leg_per_m(lobe))
        return both, both

    def key(self, spectrum: int, efficiency: int, channel: str | None) -> tuple[Any, ...]:
        """What light depends on, in the scene's cache."""
        return (*self._weight_key(spectrum, efficiency, channel), self._lobes_rad[spectrum])

    def _weight_key(self, spectrum: int, efficiency: int, channel: str | None) -> tuple[Any, ...]:
        return (self.spectrum_names[spectrum], self._curve_keys[efficiency], channel)

    def weight(self, spectrum: int, efficiency: int, channel: str | None = None) -> Array:
        """Signal weight by wavelength; see `signal_weight`."""
        key = ("weight", *self._weight_key(spectrum, efficiency, channel))
        scene = self.scene
        return scene.once(key, lambda: signal_weight(
            relative_spectrum(self.spectrum_names[spectrum], scene.wavelength_nm), wavelength_nm=scene.wavelength_nm,
            photopic=scene.photopic, reflectance=scene.reflectance, n_water=scene.radiance_index,
            quantum_efficiency=efficiency_curve(self.efficiencies[efficiency], scene.wavelength_nm, channel=channel),
        ))  # fmt: skip

    def response(self, spectrum: int, efficiency: int, channel: str | None = None) -> float:
        """Sum of the weight over wavelengths."""
        return float(self.weight(spectrum, efficiency, channel).sum())

    def straight_loss(self, spectrum: int, efficiency: int, channel: str | None = None) -> Array:
        """Water's loss straight down and up, by altitude: the paper's equation (1) on the axis."""
        scene = self.scene
        weight = self.weight(spectrum, efficiency, channel)
        optical = (scene.attenuation_per_m + self.lamp_leg_per_m(spectrum)) * scene.range_m[:, None]
        least = optical.min(axis=1, keepdims=True)
        loss = (weight * np.exp(-(optical - least))).sum(axis=1) / max(float(weight.sum()), TINY)
        return np.asarray(loss * np.exp(-least[:, 0]))

    def mean_loss(
        self, spectrum: int, efficiency: int, channel: str | None = None, *, lamp_m: float, camera_m: float
    ) -> float:
        """Water's loss over one pair of paths, integrated directly."""
        scene = self.scene
        weight = self.weight(spectrum, efficiency, channel)
        optical = self.lamp_leg_per_m(spectrum) * lamp_m + scene.attenuation_per_m * camera_m
        least = float(optical.min())
        return float((weight * np.exp(-(optical - least))).sum() / max(weight.sum(), TINY) * np.exp(-least))

    def least_veil(
        self, spectrum: int, efficiency: int, altitude: int, nearest_m: float, lowest_m: float = 0.0
    ) -> tuple[float, Array]:
        """Lower bounds of the forward veil over the light that forms the image at one altitude.

        nearest_m, lowest_m : no way from the floor to the camera, and none from a lamp to the floor, is shorter

        Returns
        -------
        What comes near its straight way, at any pixel, on the shortest rays, `nearest_m`; and what comes from elsewhere
        of the image's own floor, by kernel, for each unit of `veil.wide.least_within` (4,)
        """
        scene = self.scene
        key = ("least veil", *self.key(spectrum, efficiency, None), altitude, self.reach_m, nearest_m, lowest_m)

        def made() -> tuple[float, Array]:
            range_m = float(scene.range_m[altitude])
            near, wide = self._least_excess(spectrum, efficiency, (lowest_m, nearest_m), range_m)
            shares = self.wide_shares(spectrum, efficiency, range_m=range_m)
            return NEAR_MARGIN * near, WIDE_MARGIN * wide * shares

        return scene.once(key, made)

    def _least_excess(
        self, spectrum: int, efficiency: int, from_m: tuple[float, float], range_m: float
    ) -> tuple[float, float]:
        """Least exp((c - K_near) r) - 1 and exp((c - K_all) r) - exp((c - K_near) r) over the detected spectrum, for
        all pairs of a lamp's way and a way r to the camera from these on.

        Both grow with r at every wavelength. Their mean over what is seen, sum of X w over sum of w, may fall where the
        ways shift the spectrum; so pairs are cut into cells. Within one, X is no less than at its nearest r, and each w
        no farther from that at its middle than by factors of exp(-E) to exp(E), beside one common to all: E is what the
        ways within change an attenuation less a fixed one by. Of all such w those have the least mean that are exp(E)
        times as much where X is below it, and exp(-E) times above, which is found by turns, from above.
        """
        scene, weight = self.scene, self.weight(spectrum, efficiency)
        lit = weight > 0
        if not lit.any():  # a black floor or a blind sensor
            return 0.0, 0.0
        c, lamp_leg = scene.attenuation_per_m[lit], self.lamp_leg_per_m(spectrum)[lit]
        excess = np.stack([c - leg[lit] for leg in (self.near_leg_per_m(), self.veil_leg_per_m(range_m))])
        steps = np.linspace(0.0, 1.0, PATH_CELLS + 1)
        passed, change = [], np.zeros((PATH_CELLS, 1))
        for leg, low, high, shares in zip((lamp_leg, c), from_m, self.reach_m, (steps, steps**2), strict=True):
            edge_m = low + (max(high, low) - low) * shares
            passed.append(np.exp(-np.multiply.outer(0.5 * (edge_m[1:] + edge_m[:-1]), leg - leg.min())))
            first = passed[-1][0] * weight[lit]
            off = np.abs(leg - float(first @ leg / first.sum()))
            change = change + np.multiply.outer(0.5 * np.diff(edge_m), off)
        grown = np.expm1(np.minimum(np.multiply.outer(edge_m[:-1], excess), LARGEST_EXPONENT))
        veil = np.stack([grown[:, 0], grown[:, 1] - grown[:, 0]])
        seen, most = passed[1] * weight[lit], np.exp(np.minimum(change, 0.1 * LARGEST_EXPONENT))
        mean = np.full(2, np.inf)
        while True:
            some = seen * np.where(veil > mean[:, None, None], 1.0 / most, most)
            lower = ((some * veil) @ passed[0].T / (some @ passed[0].T)).min(axis=(1, 2))
            if not (lower < mean * (1.0 - SLACK)).any():
                return float(mean[0]), float(mean[1])
            mean = np.minimum(lower, mean)

    def reaching(self, lamp_reach_m: float, camera_reach_m: float) -> Contraction:
        """The same with tables that cover paths so long, rounded up so that like problems share their tables."""
        near, changed = float(self.scene.range_m[0]), copy(self)
        changed._reach_m = (rounded_up(max(lamp_reach_m, near)), rounded_up(max(camera_reach_m, near)))
        return changed

    @property
    def reach_m(self) -> tuple[float, float]:
        """Longest lamp leg and camera leg that tables cover."""
        assert self._reach_m is not None, (
            "tables are asked for before anyone has said how far they must reach"
        )
        return self._reach_m

    def table(
        self, spectrum: int, efficiency: int, channel: str | None = None, *, nearest_m: float, lowest_m: float = 0.0,
        part: LightPart = "image", range_m: float = 0.0,
    ) -> PathTable:  # fmt: skip
        """Loss over lamp leg and camera leg, as a table over both lengths; the least are `lowest_m` and `nearest_m`.

        `part`: of what forms the image, or of the forward veil: `near` its straight way, exp(-K_near r) - exp(-c r) on
        the camera leg, or from elsewhere (`wide`), exp(-K_all r) - exp(-K_near r), of a floor that is `range_m` off.
        """
        scene = self.scene
        lowest = min(lowest_m, nearest_m) * 0.999
        reach_m = self.reach_m
        if part == "wide":
            reach_m = max(WIDE_REACH * float(scene.range_m[-1]), reach_m[0]), WIDE_REACH * float(scene.range_m[-1])
        key = ("table", *self.key(spectrum, efficiency, channel), reach_m, lowest, nearest_m, part, range_m)

        def made() -> PathTable:
            spend("loss tables")
            return loss_table(
                self.weight(spectrum, efficiency, channel),
                k_lamp_per_m=self.lamp_leg_per_m(spectrum),
                c_camera_per_m=self.near_leg_per_m() if part == "wide" else scene.attenuation_per_m,
                k_camera_per_m=None if part == "image" else self._lesser_leg_per_m(part, range_m),
                lamp_range_m=(lowest, reach_m[0]),
                camera_range_m=(nearest_m * 0.999, reach_m[1]),
                **self.table_settings(),
            )

        return scene.once(key, made)

    def wide_shares(
        self, spectrum: int, efficiency: int, channel: str | None = None, *, range_m: float
    ) -> Array:
        """How much of the veil from elsewhere each of its kernels sends, of a floor so far off (4,); see `veil.wide`.

        One set for all colours: by what each of them sends straight down and up.
        """
        key = ("wide shares", *self.key(spectrum, efficiency, channel), range_m)

        def made() -> Array:
            near, every = self.near_leg_per_m(), self.veil_leg_per_m(range_m)
            turns, optical = (near - every) * range_m, (self.lamp_leg_per_m(spectrum) + every) * range_m
            sent = self.weight(spectrum, efficiency, channel) * -np.expm1(-turns)
            seen = sent > 0.0
            least = float(optical[seen].min()) if seen.any() else 0.0
            sent = np.where(seen, sent, 0.0) * np.exp(-np.maximum(optical - least, 0.0))
            return np.asarray(sent @ kernel_shares(turns) / max(float(sent.sum()), TINY))

        return self.scene.once(key, made)

    def _lesser_leg_per_m(self, part: LightPart, range_m: float) -> Array:
        """The lesser attenuation of a part of the forward veil."""
        return self.veil_leg_per_m(range_m) if part == "wide" else self.near_leg_per_m()

    def table_settings(self) -> dict[str, Any]:
        """Order and tolerance of the loss tables."""
        fineness = self.scene.fineness.spectrum
        return dict(
            max_order=scaled(MOST_ORDER, max(fineness, 1.0) ** 0.5),
            tolerance_log=TABLE_ERROR_LOG / fineness**2,
        )

    def scatterers(
        self, spectrum: int, efficiency: int, channel: str | None = None, *, range_m: float
    ) -> tuple[Scatterer, ...]:
        """What scatters on the way to the camera, particles and molecules, each with its loss table.

        range_m : of the floor behind it
        """
        tables = self.scatter_tables(spectrum, efficiency, channel)
        phases = self.phases(spectrum, range_m)
        return tuple(Scatterer(phase, table) for phase, table in zip(phases, tables, strict=True))

    def phases(self, spectrum: int, range_m: float) -> tuple[Callable[[Array], Array], ...]:
        """Phase functions of particles and molecules, as light meets them before a floor so far off."""
        if not self.multiple:
            return tuple(phase_function(one.table) for one in self.scene.scattering)
        scene, name = self.scene, self.spectrum_names[spectrum]
        key = ("sent back", name, range_m)
        return scene.once(key, lambda: tuple(
            map(phase_function, scene.sent_back(relative_spectrum(name, scene.wavelength_nm), range_m))
        ))  # fmt: skip

    def scatter_tables(self, spectrum: int, efficiency: int, channel: str | None = None) -> tuple[PathTable, ...]:
        """Loss of what particles and molecules send back, each over both legs."""
        scene = self.scene
        key = ("scatter", *self.key(spectrum, efficiency, channel), self.reach_m)

        def made() -> tuple[PathTable, ...]:
            spend("loss tables", len(scene.scattering))
            legs = self.back_legs_per_m(spectrum)
            lamp_end, camera_end = (
                min(reach, LAMP_FRONT_M + OPTICAL_REACH / max(float(least.min()), TINY))
                for reach, least in zip(self.reach_m, legs, strict=True)
            )
            return tuple(
                loss_table(
                    self.scatter_weight(part.scattering_per_m, spectrum, efficiency, channel),
                    k_lamp_per_m=legs[0],
                    c_camera_per_m=legs[1],
                    lamp_range_m=(LAMP_FRONT_M, max(lamp_end, 2 * LAMP_FRONT_M)),
                    camera_range_m=(0.0, camera_end),
                    **self.table_settings(),
                )
                for part in scene.scattering
            )

        return scene.once(key, made)

    def endless_scatterers(
        self, spectrum: int, efficiency: int, channel: str | None = None
    ) -> tuple[tuple[Scatterer, ...], float]:
        """The same for water without an end, and how far it must be followed [m].

        From beyond a path of c + K = 16 comes less than e^-16 of what a lamp at the camera sends back.
        """
        both = np.sum(self.back_legs_per_m(spectrum), axis=0)
        seen = self.weight(spectrum, efficiency, channel) > 0.0
        end_m = ENDLESS / max(float(both[seen].min()) if seen.any() else float(both.min()), TINY)
        reaching = self.reaching(end_m, end_m)
        return reaching.scatterers(spectrum, efficiency, channel, range_m=end_m), end_m

    def scatter_weight(
        self, scattering_per_m: Array, spectrum: int, efficiency: int, channel: str | None = None
    ) -> Array:
        """Weight by wavelength of light that the water scatters; see `scatter_weight`."""
        scene = self.scene
        return scatter_weight(
            relative_spectrum(self.spectrum_names[spectrum], scene.wavelength_nm),
            wavelength_nm=scene.wavelength_nm,
            photopic=scene.photopic,
            scattering_per_m=scattering_per_m,
            quantum_efficiency=efficiency_curve(
                self.efficiencies[efficiency], scene.wavelength_nm, channel=channel
            ),
            n_water=scene.radiance_index,
        )


def phase_function(table: PhaseTable | None) -> Callable[[Array], Array]:
    """Of the cosine of the scattering angle [1/sr]; without a table the molecules' own."""
    return molecular_per_sr if table is None else partial(look_up, table=table)


def rounded_up(length_m: float) -> float:
    """The next length of a series in steps of 30 %."""
    return float(REACH_STEP ** np.ceil(np.log(length_m * 1.001) / np.log(REACH_STEP)))
