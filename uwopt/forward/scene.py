"""A scene made ready for the model: water, floor and altitudes as arrays on one spectral grid.

Physics `paper` and `full` differ here in the table of water, in how it is continued beyond its ends,
and in how many altitudes stand for the tolerance.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, Self, TypeVar

import numpy as np

from uwopt.arrays import Array
from uwopt.catalog.curves import phase_functions, spectra
from uwopt.catalog.curves.clarity import Clarity, ClarityEnd, clarity
from uwopt.errors import RangeError
from uwopt.forward.waters_beside import WatersBeside
from uwopt.mission.mission import SceneView
from uwopt.mission.sections.scene import Scene
from uwopt.model import fineness as fine
from uwopt.model import multiple, water
from uwopt.model.beam import Beam, half_power_angle_rad
from uwopt.model.scattering import PhaseTable, share_beyond
from uwopt.model.sent_back import widened_phase
from uwopt.model.spectrum import SPAN_NM, resample, wavelength_grid_nm
from uwopt.model.sunlight import turned_per_sr
from uwopt.model.widened import arriving_share, ways_m, widened

Made = TypeVar("Made")
LampLeg = Literal["diffuse", "least", "most"]
Pixels = Literal["darkest", "frame"]  # which an SNR may be asked of: the darkest one, or all but a share of the image
LOST: dict[LampLeg, float] = {"diffuse": 1.0, "least": multiple.LOST_FACTORS[0], "most": multiple.LOST_FACTORS[1]}
COLOURS = ("red", "green", "blue")  # channels of a colour sensor
SNR_PIXELS: dict[str, Pixels | None] = {"mean": None, "worst": "frame", "worst_px": "darkest"}

PAPER_N_WATER = 1.33
DESIGN_WAVELENGTH_NM = 550.0  # rays and virtual images are computed for green light
PAPER_ALTITUDES = 3
FULL_ALTITUDES = 5
FAINTEST_SUN_LX = 1e-6  # a billionth of what lamps give; starlight on the sea is a thousand times more
STEEPEST_SUN_PATH = 0.85  # way of light straight down over that of the sun at 60 deg, with room
FAINT = 1e-12  # 1/m, below which no coefficient counts
LEAST_SHARE = 1e-3  # of a step: a kink nearer to a point of the grid lies on it
GRID_STEP_NM = 0.5  # 1 nm would err by up to 2e-4 where turbid water leaves little light, 5 nm by 2e-3


@dataclass(frozen=True)
class Scattering:
    """One of the things that scatter in a water: particles, or the water's molecules."""

    name: str
    scattering_per_m: Array  # b on the grid
    table: PhaseTable | None  # phase function of particles; None: the molecules' own

    def share_beyond(self, angle_rad: float) -> float:
        """What of it is scattered by more than an angle."""
        return share_beyond(angle_rad, self.table)


@dataclass(frozen=True)
class SceneOptics:
    """Water, floor and altitudes of one scene; SI, spectra on `wavelength_nm`."""

    view: SceneView
    paper: bool
    range_m: Array  # along the optical axis to the target, at the altitudes over which requirements hold, rising;
    # views are worked out too of rows that fly at heights of their own, (n_altitudes, n)
    nominal: int  # index of the altitude itself
    wavelength_nm: Array
    photopic: Array
    attenuation_per_m: Array  # c: camera leg
    lamp_attenuation_per_m: Array  # K: lamp leg, of single scattering and of daylight's veil
    reflectance: Array
    n_water: float  # at the design wavelength
    n_water_spectrum: Array
    water_table: str
    clarity: Clarity | None = None  # the reading that the water was made from
    notes: tuple[str, ...] = field(default=())
    scattering: tuple[Scattering, ...] = ()  # none in physics `paper`, or where the water's b is unknown
    diffuse_attenuation_per_m: Array | None = None  # K_d, of daylight
    lamp_lost: float = 1.0  # factor on the share of what is scattered that lamp light loses, all orders counted
    fineness: fine.Fineness = fine.DEFAULT  # of all integrals in this scene
    pitch_rad: float = 0.0  # of the optical axis from the normal of the target's plane
    # Weights and loss tables by light spectrum and efficiency curve, shared by all problems in this scene.
    cache: dict[Any, Any] = field(default_factory=dict, repr=False, compare=False)

    def once(self, key: Hashable, make: Callable[[], Made]) -> Made:
        """What a key stands for in this scene, worked out once."""
        if key not in self.cache:
            self.cache[key] = make()
        found: Made = self.cache[key]
        return found

    @property
    def name(self) -> str:
        """Name of the scene."""
        return self.view.scene.name

    @property
    def slope(self) -> float:
        """How fast the target's plane recedes along the axis, over the distance forward of it."""
        return float(np.tan(self.pitch_rad))

    @property
    def altitude_m(self) -> Array:
        """Heights of the port over the target's plane at these ranges."""
        return np.asarray(self.range_m * np.cos(self.pitch_rad))

    @property
    def scatters(self) -> bool:
        """Whether light that forms no image reaches the camera at all."""
        return bool(self.scattering) or not np.array_equal(
            self.attenuation_per_m, self.lamp_attenuation_per_m
        )

    @property
    def at_nominal(self) -> Self:
        """With its nominal altitude alone."""
        return replace(self, range_m=self.range_m[self.nominal : self.nominal + 1], nominal=0)

    @property
    def counts_orders(self) -> bool:
        """Whether light scattered more than once can be counted: where the water's b and phase function are known."""
        return bool(self.scattering) and self.view.scene.multiple_scattering

    def lamp_leg_per_m(self, half_power_angle_rad: float) -> Array:
        """K of all orders of scattering on the way from lamps of this lobe to the floor."""
        angle = float(multiple.lamp_angle_rad(half_power_angle_rad))
        return self._effective_per_m(lambda one: min(self.lamp_lost * one.share_beyond(angle), 1.0))

    def near_leg_per_m(self) -> Array:
        """K of light that comes from the floor to the camera near its straight way, image or veil."""
        angle = float(np.deg2rad(multiple.NEAR_DEG))
        return self._effective_per_m(lambda one: one.share_beyond(angle))

    def veil_leg_per_m(self, way_m: float) -> Array:
        """K of all light that comes from a floor so far off to the camera, no more than near its straight way."""
        angle, absorbed = float(np.deg2rad(multiple.VEIL_DEG)), self.absorption_per_m() * way_m
        k = self._effective_per_m(lambda one: 1.0 - arriving_share(one.table, absorbed, within_rad=angle))
        return np.minimum(k, self.near_leg_per_m())

    def sun_leg_per_m(self) -> Array:
        """K of daylight that comes from the floor to the camera, by whatever way."""
        angle = float(np.deg2rad(multiple.SUN_VEIL_DEG))
        return self._effective_per_m(lambda one: one.share_beyond(angle))

    def absorption_per_m(self) -> Array:
        """What daylight's path radiance loses on its way: a."""
        return np.maximum(self._effective_per_m(lambda one: 0.0), 0.0)  # c - b of water that only scatters rounds

    def particles_per_m(self) -> Array:
        """What particles scatter, of which some shows detail; 0 where none are known."""
        own = [one.scattering_per_m for one in self.scattering if one.table is not None]
        return np.asarray(sum(own)) if own else np.zeros_like(self.wavelength_nm)

    def sun_turned_per_m_sr(self, cos_field: Array, *, elevation_rad: float, n_azimuth: int) -> Array:
        """What of sunlight is scattered into rays at these angles from straight down by its first turn (..., n)."""
        sun: dict[str, Any] = dict(elevation_rad=elevation_rad, n_water=self.n_water, n_azimuth=n_azimuth)
        each = [
            one.scattering_per_m * turned_per_sr(cos_field, one.table, **sun)[..., None] for one in self.scattering
        ]
        return np.asarray(sum(each))

    def back_leg_per_m(self, half_power_angle_rad: float) -> Array:
        """K of light that the water sends back, from lamps of this lobe and to the camera."""
        share = float(multiple.back_share(half_power_angle_rad))
        k = self._effective_per_m(lambda one: min(share * one.share_beyond(np.pi / 2), 1.0))
        return np.maximum(k, multiple.LEAST_OF_ABSORPTION * self.absorption_per_m())

    def widened_lobe(self, lobe: Beam, relative_spectrum: Array, *, way_m: float, back: bool = False) -> Beam:
        """A lamp's lobe after a way through this water, over what K (`lamp_leg_per_m`) leaves of its light.

        back : of backscatter, along all of that way; else of the floor at its end

        One lobe for all colours: of the scattering where the lamp's light gets through there and back. K is the central
        one: what is in doubt about it remains.
        """
        legs = self.lamp_leg_per_m(half_power_angle_rad(lobe))[None, :]
        ways = ways_m(way_m) if back else np.array([way_m])
        met = WatersBeside.of([self]).on_the_way(ways, lobe, relative_spectrum, legs, back=back)
        return widened(lobe, met.turned, way_m, absorbed=met.absorbed, returned=met.returned, sent_back=back)

    def sent_back(self, relative_spectrum: Array, range_m: float) -> tuple[PhaseTable | None, ...]:
        """Phase functions of `scattering` as lamp light meets them that has turned, before a floor so far off.

        One for all colours, of those that get through; molecules scatter too evenly for it to matter.
        """
        each = WatersBeside.of([self]).turned_before(range_m, relative_spectrum)
        turned = [(float(thickness[0]), table) for thickness, table in each]
        return tuple(None if one.table is None else widened_phase(one.table, turned) for one in self.scattering)

    def backward_per_m(self) -> Array:
        """b_b: what is scattered by more than 90 deg."""
        return np.asarray(sum(one.scattering_per_m * one.share_beyond(np.pi / 2) for one in self.scattering))

    def _effective_per_m(self, lost_share: Callable[[Scattering], float | Array]) -> Array:
        left = self.attenuation_per_m
        for one in self.scattering:
            left = multiple.effective_attenuation_per_m(
                left, scattering_per_m=one.scattering_per_m, lost_share=lost_share(one)
            )
        return left

    @property
    def pixels(self) -> Pixels | None:
        """Which pixels the SNR is asked of; None: of the image's mean alone."""
        needs = self.view.requirements
        if self.paper or needs.min_snr is None:
            return None
        return SNR_PIXELS[needs.snr_at]

    @property
    def least_snr(self) -> float:
        """The SNR that those pixels must reach, or the image's mean where it is asked of no pixels; 0 of none."""
        needs = self.view.requirements
        return (needs.min_snr if self.pixels is None else needs.min_snr_there) or 0.0

    @property
    def least_mean_snr(self) -> float:
        """The SNR that the image's mean must reach where pixels may have less; 0 where they may not."""
        needs = self.view.requirements
        return (needs.min_snr or 0.0) if self.pixels is not None and needs.snr_at_less_db > 0.0 else 0.0

    @property
    def channels(self) -> tuple[str, ...]:
        """Colour channels that something is asked of: red first, all for a white balance."""
        needs = self.view.requirements
        if needs.max_white_balance is not None:
            return COLOURS
        return COLOURS[:1] if needs.min_snr_red is not None else ()

    @property
    def at_worst(self) -> bool:
        """Whether the SNR is asked of pixels, not of the mean."""
        return self.pixels is not None

    @property
    def sunlit(self) -> bool:
        """Whether any sunlight is to be reckoned with: over a microlux at the highest camera, in the clearest colour.

        Under a thousand metres of water a sun at the surface changes nothing, and must not cost a search.
        """
        asked = self.view.scene
        if self.paper or asked.sun_lux <= 0.0 or self.diffuse_attenuation_per_m is None:
            return not self.paper and asked.sun_lux > 0.0
        seen = self.diffuse_attenuation_per_m[self.photopic > 0.0]
        above_m = max(asked.depth_m - float(self.range_m[-1]), 0.0) * STEEPEST_SUN_PATH
        return asked.sun_lux * float(np.exp(-seen.min() * above_m)) > FAINTEST_SUN_LX

    @property
    def open_water(self) -> bool:
        """Whether the camera sees past its targets into water that scatters."""
        return self.view.scene.target == "mid_water" and bool(self.scattering)

    @property
    def radiance_index(self) -> Array | float:
        """n_w of the radiance theorem; 1 in physics `paper`, which leaves it out."""
        return 1.0 if self.paper else self.n_water_spectrum


def scene_optics(
    view: SceneView,
    *,
    paper: bool,
    base_dir: Path | None = None,
    water_table: str | None = None,
    lamp_leg: LampLeg = "diffuse",
    fineness: fine.Fineness = fine.DEFAULT,
    water_end: ClarityEnd = "central",
) -> SceneOptics:
    """Tabulate one scene.

    `water_table` and `lamp_leg` override the scene's table and K on the way from lamp to floor, to test a
    decision against them. All orders counted, K = a + s b with another share s lost (`multiple.LOST_FACTORS`); else K_d
    where it lies between a + b_b (`least`) and c (`most`), or one of these ends.
    `water_end` takes the clearest or the murkiest water that a reading such as a visibility leaves open.
    `fineness` sets the step of the spectral grid, and goes with the scene to all other integrals.
    """
    scene = view.scene
    grid = wavelength_grid_nm(SPAN_NM / round(SPAN_NM / GRID_STEP_NM * fineness.spectrum))
    table = water_table or jerlov_table_of(scene, paper=paper)
    known = clarity_of(scene, table)
    profile = known.profiles[water_end] if known else water_of(scene, table, base_dir)
    scattering: tuple[Scattering, ...] = ()
    if not paper:
        grid = np.union1d(grid, kinks_nm(profile, grid, scene.backscatter_ratio))
    if profile.a_per_m is not None and profile.b_per_m is not None:
        a, b = (
            absorption(profile, grid, paper=paper),
            resample(grid, table_nm=profile.wavelength_nm, table_values=profile.b_per_m, outside="hold"),
        )
        c = water.beam_attenuation_per_m(a, b)
        lamp = c if paper else lamp_attenuation(profile, grid, a, b, scene.backscatter_ratio, lamp_leg)
        scattering = () if paper else scatterers_of(grid, b, scene, base_dir)
    else:
        c = resample(
            grid, table_nm=profile.wavelength_nm, table_values=profile.attenuation_per_m, outside="hold"
        )
        lamp = c
        if not paper and profile.kd_per_m is not None and profile.kd_wavelength_nm is not None:
            kd = resample(
                grid, table_nm=profile.kd_wavelength_nm, table_values=profile.kd_per_m, outside="hold"
            )
            lamp = np.minimum(kd, c)
    floor = spectra.seafloor_reflectance(scene.seafloor, base_dir=base_dir)
    photopic = spectra.photopic()
    index = np.full_like(grid, PAPER_N_WATER) if paper else index_of_water(grid, scene)
    tolerance = view.vehicle.altitude_tolerance_m
    count = 1 if tolerance == 0 else (PAPER_ALTITUDES if paper else FULL_ALTITUDES)
    altitude = view.vehicle.altitude_m
    pitch_rad = float(np.deg2rad(view.vehicle.pitch_deg))
    ranges = np.linspace(altitude - tolerance, altitude + tolerance, count) / np.cos(pitch_rad)
    if not np.all(ranges > 0):
        raise RangeError(f"scene {view.scene.name!r}: altitude minus tolerance is not above 0 m")
    return SceneOptics(
        view=view,
        paper=paper,
        range_m=ranges,
        nominal=count // 2,
        wavelength_nm=grid,
        photopic=resample(grid, table_nm=photopic.wavelength_nm, table_values=photopic.value, outside="zero"),
        attenuation_per_m=c,
        lamp_attenuation_per_m=lamp,
        reflectance=resample(grid, table_nm=floor.wavelength_nm, table_values=floor.value, outside="hold"),
        n_water=PAPER_N_WATER if paper else float(np.interp(DESIGN_WAVELENGTH_NM, grid, index)),
        n_water_spectrum=index,
        water_table=profile.table,
        clarity=known,
        notes=profile.notes + floor.notes,
        scattering=scattering,
        diffuse_attenuation_per_m=daylight_attenuation(profile, grid, c),
        lamp_lost=LOST[lamp_leg],
        fineness=fineness,
        pitch_rad=pitch_rad,
    )


def seen_anew(known: SceneOptics, view: SceneView) -> SceneOptics | None:
    """The same scene asked for other things, its tables shared; None where water, floor or heights differ."""
    old, new = known.view, view
    heights = ("altitude_m", "altitude_tolerance_m", "pitch_deg")
    plain = {"vehicle": None, "requirements": None}  # a scene's own stand in its view
    same = old.scene.model_copy(update=plain) == new.scene.model_copy(update=plain) and all(
        getattr(old.vehicle, key) == getattr(new.vehicle, key) for key in heights
    )
    return replace(known, view=view) if same else None


def without_reserve(known: SceneOptics, *keys: str) -> SceneOptics:
    """The same scene in which these requirements hold as they are asked for, with nothing kept in hand."""
    view = known.view
    asked = {key: getattr(view.asked, key) for key in keys}
    if all(getattr(view.requirements, key) == value for key, value in asked.items()):
        return known
    return replace(known, view=replace(view, requirements=view.requirements.model_copy(update=asked)))


def jerlov_table_of(scene: Scene, *, paper: bool) -> str | None:
    """The table of Jerlov types that a scene's water is from; None: measured where that has the type."""
    return scene.water_table or ("solonenko-mobley" if paper else None)


def clarity_of(scene: Scene, table: str | None) -> Clarity | None:
    """The waters that a scene's reading may mean; None where its water is a type or a file."""
    if scene.clarity is None:
        return None
    key, value = scene.clarity
    return clarity(key, value, table, scene.water)


def water_of(scene: Scene, table: str | None, base_dir: Path | None) -> spectra.WaterProfile:
    """The water of a scene's type or file."""
    return spectra.water_profile(str(scene.water), table=table, base_dir=base_dir)  # pyrefly: ignore[bad-argument-type]


def daylight_attenuation(profile: spectra.WaterProfile, grid: Array, c_per_m: Array) -> Array:
    """K_d of daylight: the profile's, at most c; c where the profile has none."""
    if profile.kd_per_m is None or profile.kd_wavelength_nm is None:
        return c_per_m
    kd = resample(grid, table_nm=profile.kd_wavelength_nm, table_values=profile.kd_per_m, outside="hold")
    return np.asarray(np.minimum(kd, c_per_m))


def scatterers_of(grid: Array, b_per_m: Array, scene: Any, base_dir: Path | None) -> tuple[Scattering, ...]:
    """Particles, and the water's molecules unless the phase function was measured with the water in it."""
    known = phase_functions.phase_function(
        scene.phase_function, backscatter_ratio=scene.backscatter_ratio, base_dir=base_dir
    )
    if known.includes_water:
        return (Scattering("water with particles", b_per_m, known.table),)
    molecular = np.minimum(
        phase_functions.pure_water_scattering_per_m(grid, salinity_psu=scene.salinity_psu), b_per_m
    )
    return (
        Scattering("particles", b_per_m - molecular, known.table),
        Scattering("molecules", molecular, None),
    )


def absorption(profile: spectra.WaterProfile, grid: Array, *, paper: bool) -> Array:
    """a(lambda) on the grid; beyond the table held (paper) or continued with pure water (full)."""
    assert profile.a_per_m is not None
    if paper:
        return np.asarray(
            resample(grid, table_nm=profile.wavelength_nm, table_values=profile.a_per_m, outside="hold")
        )
    pure = spectra.pure_water()
    return np.asarray(
        water.extend_absorption_per_m(
            grid,
            table_nm=profile.wavelength_nm,
            table_a_per_m=profile.a_per_m,
            pure_water_nm=pure.wavelength_nm,
            pure_water_a_per_m=pure.a_per_m,
        )
    )


def kinks_nm(profile: spectra.WaterProfile, grid: Array, backscatter_ratio: float) -> Array:
    """Wavelengths where K meets an end of its range, a + b_b or c, and so has a kink: (n,) [nm].

    In short paths of clear water the forward veil lives in the few colours where K is below c; with these
    wavelengths on the grid the trapezoid rule follows it.
    """
    if profile.kd_per_m is None or profile.kd_wavelength_nm is None:
        return np.empty(0)
    kd = resample(grid, table_nm=profile.kd_wavelength_nm, table_values=profile.kd_per_m, outside="hold")
    if profile.a_per_m is None or profile.b_per_m is None:
        c = profile.attenuation_per_m
        ends = [resample(grid, table_nm=profile.wavelength_nm, table_values=c, outside="hold")]
    else:
        a = absorption(profile, grid, paper=False)
        b = resample(grid, table_nm=profile.wavelength_nm, table_values=profile.b_per_m, outside="hold")
        ends = [water.beam_attenuation_per_m(a, b), a + backscatter_ratio * b]
    found = []
    for end in ends:
        over = kd - end
        at = np.flatnonzero(over[:-1] * over[1:] < 0.0)
        share = over[at] / (over[at] - over[at + 1])
        found.append(
            (grid[at] + share * (grid[at + 1] - grid[at]))[(share > LEAST_SHARE) & (share < 1 - LEAST_SHARE)]
        )
    return np.concatenate(found)


def lamp_attenuation(
    profile: spectra.WaterProfile, grid: Array, a: Array, b: Array, backscatter_ratio: float,
    lamp_leg: LampLeg = "diffuse",
) -> Array:  # fmt: skip
    """K of the lamp leg: K_d held within a + b_b and c, or one of them; c where the profile has no K_d."""
    c = water.beam_attenuation_per_m(a, b)
    if lamp_leg != "diffuse":
        return np.asarray(c if lamp_leg == "most" else a + backscatter_ratio * b)
    if profile.kd_per_m is None or profile.kd_wavelength_nm is None:
        return np.asarray(c)
    kd = resample(grid, table_nm=profile.kd_wavelength_nm, table_values=profile.kd_per_m, outside="hold")
    return np.asarray(
        water.illumination_attenuation_per_m(a, b_per_m=b, kd_per_m=kd, backscatter_ratio=backscatter_ratio)
    )


def geometric(central: Array, end: Array, share: Array | float) -> Array:
    """Between two spectra: the central one at 0, the end at 1, even in their logarithms."""
    low, high = np.maximum(central, FAINT), np.maximum(end, FAINT)
    return np.asarray(low * (high / low) ** share)


def index_of_water(grid: Array, scene: Any) -> Array:
    """n_w(lambda) at the scene's temperature and salinity (Quan and Fry 1995)."""
    return np.asarray(
        water.refractive_index_quan_fry(
            grid,
            temperature_c=scene.temperature_c,
            salinity_psu=scene.salinity_psu,
            coefficients=list(spectra.quan_fry_coefficients()),
        )
    )


def glass_index(material: str) -> float:
    """Index of a named glass at the design wavelength."""
    from uwopt.model.port import refractive_index_dispersion

    formula = spectra.glass_coefficients(material)
    return float(
        refractive_index_dispersion(
            DESIGN_WAVELENGTH_NM, formula=formula.formula, coefficients=list(formula.coefficients)
        )
    )
