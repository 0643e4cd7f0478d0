"""Random small catalogues and missions that try every kind of part, written for the attack on the exact search.

Everything is drawn from one seed. Numbers are plausible rather than real; ranges are wide enough that
each rule of the search discards something in some case and that most cases have a feasible design.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from uwopt.catalog.parts.camera import Camera
from uwopt.catalog.parts.housing import Housing
from uwopt.catalog.parts.lens import Lens
from uwopt.catalog.parts.light import Light
from uwopt.catalog.parts.port import Port
from uwopt.catalog.parts.quantity import Curve, Quantity
from uwopt.catalog.records import exact
from uwopt.forward.parts import Parts
from uwopt.mission.mission import Mission, load_mission

Rng = np.random.Generator

MONO = Curve((380.0, 450.0, 520.0, 600.0, 700.0, 780.0), (0.35, 0.55, 0.68, 0.58, 0.30, 0.12))
COLOURS = {
    "red": Curve((380.0, 560.0, 600.0, 640.0, 780.0), (0.02, 0.05, 0.45, 0.40, 0.10)),
    "green": Curve((380.0, 470.0, 530.0, 600.0, 780.0), (0.02, 0.20, 0.55, 0.15, 0.05)),
    "blue": Curve((380.0, 450.0, 500.0, 560.0, 780.0), (0.10, 0.50, 0.30, 0.05, 0.02)),
}
LOBE = Curve((0.0, 10.0, 20.0, 30.0, 40.0, 60.0, 90.0), (1.0, 0.97, 0.8, 0.5, 0.2, 0.03, 0.0))
MOUNTS = ("C", "C", "C", "C", "C", "CS", "CS", "S")
#: a + b at 530 nm: Williamson and Hollins (2022) as printed; Solonenko and Mobley (2015) between 525 and 550 nm.
C_PER_M = {
    "measured": {"II": 0.0607 + 0.18, "III": 0.0806 + 0.291, "1C": 0.0948 + 0.432, "3C": 0.128 + 0.652,
                 "5C": 0.169 + 1.21},
    "solonenko-mobley": {"II": 0.43116, "III": 1.09748, "1C": 0.4586, "3C": 1.2108, "5C": 1.543},
}  # fmt: skip
OBJECTIVES: tuple[Any, ...] = (
    "power", "power", "cost", "mass", "snr_db", "gsd_mm", {"power": 1.0, "cost": 0.01}, {"power": 0.2, "snr_db": 1.0},
    {"cost": 0.001, "snr_db": 0.5}, {"mass": 1.0, "gsd_mm": 2.0, "power": 0.1},
)  # fmt: skip


def between(rng: Rng, low: float, high: float) -> float:
    """A number, evenly spread in its logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def chance(rng: Rng, share: float) -> bool:
    """True in a share of all draws."""
    return bool(rng.random() < share)


def pick(rng: Rng, options: Any) -> Any:
    """One of the options."""
    return options[int(rng.integers(len(options)))]


def price(rng: Rng, low: float, high: float) -> Quantity:
    """A price, rounded so that ties happen; sometimes an estimate with a range."""
    value = float(round(between(rng, low, high), -2) or 100.0)
    return Quantity(value, 0.8 * value, 1.5 * value, "estimated") if chance(rng, 0.3) else exact(value)


def camera(rng: Rng, name: str) -> Camera:
    """A camera with a global or rolling shutter, mono or colour."""
    width, height, pitch_um = pick(
        rng, [(640, 480, 5.6), (1280, 1024, 5.3), (1936, 1216, 3.45), (2448, 2048, 3.45)]
    )
    bits = pick(rng, [8, 10, 12, 12])
    well = between(rng, 6_000, 40_000)
    known_gain = chance(rng, 0.5)
    return Camera(
        id=name, price=price(rng, 300, 3000), mass_g=exact(between(rng, 40, 400)), mounts=(pick(rng, MOUNTS),),
        colour="mono", resolution_x_px=width, resolution_y_px=height, pixel_pitch_um=pitch_um,
        shutter="rolling" if chance(rng, 0.3) else "global",
        max_frame_rate_hz=exact(between(rng, 8, 120)), bit_depth=bits, read_noise_e=exact(between(rng, 1.5, 15)),
        saturation_e=exact(well), dark_current_e_s=exact(pick(rng, [0.0, 0.0, 0.01, 1.0])),
        gain_dn_per_e=(2.0**bits - 1) / well * between(rng, 0.9, 2.0) if known_gain else None, gain_bits=bits,
        max_gain_db=exact(pick(rng, [0.0, 12.0, 24.0, 36.0])), black_level_dn=pick(rng, [0.0, 0.0, 4.0]),
        min_exposure_us=exact(between(rng, 3, 100)), max_exposure_us=exact(between(rng, 5e3, 2e6)),
        exposure_offset_us=exact(pick(rng, [0.0, 13.73])), prnu_frac=exact(pick(rng, [0.0, 0.004, 0.01])),
        power_w=exact(float(round(between(rng, 1.5, 6), 1))),
        qe_curves=dict(COLOURS) if chance(rng, 0.3) else {"mono": MONO},
    )  # fmt: skip


def lens(rng: Rng, name: str) -> Lens:
    """A lens, its iris manual, motorised or fixed."""
    widest = pick(rng, [1.4, 1.8, 2.0, 2.8, 4.0])
    control = pick(rng, ["manual", "manual", "motorised", "fixed"])
    made = Lens(
        id=name, price=price(rng, 80, 1500), mass_g=exact(between(rng, 20, 300)),
        focal_length_mm=pick(rng, [4.0, 6.0, 8.0, 8.5, 12.0, 16.0, 25.0]), f_number_min=exact(widest),
        f_number_max=exact(widest if control == "fixed" else pick(rng, [8.0, 11.0, 16.0, 22.0])),
        aperture_control=control, image_circle_mm=pick(rng, [9.0, 11.0, 11.0, 16.0]), mounts=(pick(rng, MOUNTS),),
        transmission_frac=exact(rng.uniform(0.8, 1.0)),
        min_object_distance_m=exact(pick(rng, [0.0, 0.0, 0.05, 0.1, 0.3])),
    )  # fmt: skip
    return replace(made, aberration_pitch_um=exact(5.0 * made.transmission_frac.value - 3.0))  # 1 to 2 um, no draw


def port(rng: Rng, name: str) -> Port:
    """A flat port with or without a gap and a rim, or a dome."""
    common: dict[str, Any] = dict(
        id=name, price=price(rng, 100, 2000), mass_g=exact(between(rng, 100, 2000)), depth_rating_m=6000.0,
        refractive_index=exact(pick(rng, [1.49, 1.52, 1.76])), thickness_mm=exact(between(rng, 4, 20)),
    )  # fmt: skip
    if chance(rng, 0.5):
        radius_mm = between(rng, 40, 130)  # estimated: a search takes the central value alone
        estimated = Quantity(radius_mm, 0.9 * radius_mm, 1.2 * radius_mm, "estimated", "no source")
        return Port(geometry="dome", outer_radius_mm=estimated, **common)
    return Port(
        geometry="flat",
        gap_mm=pick(rng, [0.0, 0.0, 5.0, 30.0]),
        clear_diameter_mm=pick(rng, [None, 50.0, 100.0]),
        **common,
    )


def beam(rng: Rng) -> dict[str, Any]:
    """Any kind of beam, narrow to wide."""
    shape = pick(rng, ["cosine-power", "cosine-power", "cone", "disc", "tabulated"])
    medium = pick(rng, ["air", "water"])
    if shape == "tabulated":
        return dict(beam=shape, beam_profile=LOBE, beam_medium=medium)
    return dict(
        beam=shape, beam_angle_deg=exact(pick(rng, [20.0, 40.0, 60.0, 80.0, 100.0])), beam_medium=medium
    )


FADED_TO = (0.07, 0.5, 1.0)  # what a flash has left of its brightness when its duration is over


def light(rng: Rng, name: str, optics: dict[str, Any]) -> Light:
    """A lamp that burns, an LED that pulses or a flash; dimmed freely, from a least level, by steps or not at all."""
    kind = pick(rng, ["continuous", "continuous", "pulsed_led", "flash"])
    common: dict[str, Any] = dict(
        id=name, kind=kind, price=price(rng, 200, 3000), mass_g=exact(between(rng, 100, 2000)), depth_rating_m=6000.0,
        spectrum_id="generic-led", output_factor=exact(pick(rng, [1.0, 0.7])), **optics,
        **pick(rng, [{}, {"dim_min_frac": 0.1}, {"dim_levels": (1.0,)}, {"dim_levels": (0.1, 0.25, 0.5, 1.0)}]),
    )  # fmt: skip
    if kind == "flash":
        energy_j, duration_us = between(rng, 0.5, 100), between(rng, 100, 3000)
        return Light(
            flash_energy_j=exact(energy_j), flash_efficacy_lm_s_per_j=exact(35.0),
            flash_duration_us=exact(duration_us), recycle_s=exact(between(rng, 0.05, 3)),
            charging_efficiency_frac=exact(0.7), flash_duration_at_frac=exact(FADED_TO[int(duration_us) % 3]), **common,
        )  # fmt: skip
    flux = between(rng, 2e3, 6e4)
    common |= dict(flux_lm=exact(flux), power_w=exact(flux / between(rng, 60, 150)))
    if kind == "continuous":
        return Light(**common)
    return Light(
        min_pulse_us=exact(pick(rng, [1.0, 50.0, 500.0])), max_pulse_us=exact(between(rng, 500, 2e4)),
        max_duty_frac=exact(pick(rng, [0.02, 0.1, 1.0])), max_rate_hz=exact(between(rng, 2, 60)), **common,
    )  # fmt: skip


def parts(rng: Rng, most: int = 3) -> Parts:
    """A catalogue: up to `most` cameras, lenses and lights and up to three ports; lamps may share optics."""
    looks = [beam(rng) for _ in range(2)]
    sizes = [int(rng.integers(2, most + 1)) for _ in range(3)]
    return Parts(
        tuple(camera(rng, f"cam-{i}") for i in range(sizes[0])),
        tuple(lens(rng, f"lens-{i}") for i in range(sizes[1])),
        tuple(port(rng, f"port-{i}") for i in range(int(rng.integers(1, 4)))),
        tuple(light(rng, f"light-{i}", pick(rng, looks)) for i in range(sizes[2])),
    )


def housed(rng: Rng, parts: Parts) -> Parts:
    """The same catalogue with bodies of a size, some domes cut down to caps, each port in three housings,
    of which some fit few or cost no less."""

    def mm(low: float, high: float) -> Quantity:
        return exact(between(rng, low, high))

    cameras = tuple(
        replace(c, body_width_mm=mm(20, 60), body_height_mm=mm(20, 60), body_length_mm=mm(20, 60), plug_mm=mm(5, 50))
        for c in parts.cameras
    )
    lenses = tuple(
        replace(one, length_mm=mm(15, 70), diameter_mm=mm(15, 50), pupil_mm=mm(3, 20)) for one in parts.lenses
    )
    ports = []
    for port in parts.ports:
        for number in range(3):
            inner, length = between(rng, 50, 110), between(rng, 90, 220)
            housing = Housing(
                f"housing-{number}", price=price(rng, 200, 2000), mass_g=mm(300, 4000), depth_rating_m=6000.0,
                shape="sphere" if chance(rng, 0.2) else "tube", inner_length_mm=length,
                inner_diameter_mm=3.0 * inner if number == 2 else inner,
            )  # fmt: skip
            ports.append(replace(port, housing=housing))
    openings = {
        port.id: exact(between(rng, 0.9, 1.0) * 2.0 * (port.outer_radius_mm.value - port.thickness_mm.value))
        for port in parts.ports[1::2]
        if port.geometry == "dome"
    }  # of spherical caps
    ports = [replace(port, clear_diameter_mm=openings[port.id]) if port.id in openings else port for port in ports]
    return replace(parts, cameras=cameras, lenses=lenses, ports=tuple(ports))


def spaced(rng: Rng, parts: Parts) -> Parts:
    """The same catalogue with lenses that focus on nothing near, most of which may stand on rings or be screwed out."""
    lenses = tuple(
        replace(
            one, min_object_distance_m=exact(pick(rng, [0.1, 0.3, 0.5])),
            max_magnification=exact(pick(rng, [0.05, 0.3])),
            spacers_mm=pick(rng, [(), (0.1,), (0.25, 0.5), (0.1, 0.2, 0.3, 0.6)]),
            thread_travel_mm=pick(rng, [None, None, exact(0.2)]),
        )
        for one in parts.lenses
    )  # fmt: skip
    return replace(parts, lenses=lenses)


def with_rings(plain: dict[str, Any]) -> dict[str, Any]:
    """A mission that allows rings."""
    return {**plain, "catalog": {**plain.get("catalog", {}), "spacers": "allow"}}


def with_completes(rng: Rng, parts: Parts, count: int = 2) -> Parts:
    """The same catalogue with complete cameras, in three pieces each, of which some fire no lamp."""
    for number in range(count):
        name = f"whole-{number}"
        body, glass, window = camera(rng, f"{name} camera"), lens(rng, f"{name} lens"), port(rng, f"{name} port")
        body = replace(
            body, mounts=("complete",), complete=name, price=None, mass_g=None, fires_lamps=chance(rng, 0.5),
            storage_gb=pick(rng, [None, between(rng, 1, 300)]),
            min_interval_s=pick(rng, [None, exact(between(rng, 0.1, 3))]),
        )  # fmt: skip
        glass = replace(glass, mounts=("complete",), complete=name, price=None, mass_g=None, image_circle_mm=20.0)
        hull = Housing(f"{name} housing", outer_diameter_mm=exact(120.0), outer_length_mm=exact(200.0))
        window = replace(window, complete=name, housing=hull)
        parts = Parts((*parts.cameras, body), (*parts.lenses, glass), (*parts.ports, window), parts.lights)
    return parts


def scene(rng: Rng, number: int) -> dict[str, Any]:
    """Water and floor of one scene."""
    return {
        "name": f"scene {number}", "water": pick(rng, ["I", "II", "III", "1C", "3C", "5C"]), "depth_m": 100.0,
        "seafloor": float(round(rng.uniform(0.05, 0.5), 2)),
    }  # fmt: skip


def requirements(rng: Rng, speed_m_s: float) -> dict[str, Any]:
    """What images must be; every key is left out in some cases."""
    wanted: dict[str, Any] = {}
    if chance(rng, 0.8 if speed_m_s == 0.0 else 0.3):
        wanted["frame_interval_s"] = between(rng, 0.2, 10)
    if "frame_interval_s" not in wanted or chance(rng, 0.5):
        wanted["overlap"] = float(rng.uniform(0.0, 0.7))
    if chance(rng, 0.8):
        wanted["max_blur_px"] = pick(rng, [0.5, 1.0, 2.0])
    if chance(rng, 0.2):
        wanted["max_skew_px"] = between(rng, 1, 100)
    if chance(rng, 0.5):
        wanted["min_dof_m"] = between(rng, 0.02, 0.8)
    if chance(rng, 0.85):
        wanted["min_snr_db"] = float(rng.uniform(8, 36))
        wanted["snr_at"] = pick(rng, ["mean", "mean", "worst_px"])
    if chance(rng, 0.3):
        wanted["mean_level"] = pick(rng, [0.1, 0.3, 0.5])
    if chance(rng, 0.3):
        wanted["highlight_ratio"] = between(rng, 1.0, 4.0)
    if chance(rng, 0.2):
        wanted["dof_at"] = "corner"
    if chance(rng, 0.15):
        wanted["min_contrast"] = between(rng, 0.1, 0.9)
    if chance(rng, 0.15):
        wanted["min_uniformity"] = between(rng, 0.02, 0.5)
    return wanted


def mission(rng: Rng) -> dict[str, Any]:
    """A mission without limits, as plain values."""
    altitude_m = between(rng, 0.5, 4)
    speed_m_s = pick(rng, [0.0, 0.1, 0.5, 1.0])
    low = int(rng.integers(1, 3))
    vehicle: dict[str, Any] = {
        "altitude_m": altitude_m, "altitude_tolerance_m": pick(rng, [0.0, 0.0, 0.1, 0.25]) * altitude_m,
        "speed_m_s": speed_m_s, "orientation": pick(rng, ["any", "landscape", "portrait"]),
        "light_count": [low, low + int(rng.integers(0, 3))], "camera_count": pick(rng, [1, 1, 2]),
        "light_baseline_m": pick(rng, [0.1, 0.3, 0.5, [0.4, 0.45]]),
        "light_tilt_deg": pick(rng, [0.0, 0.0, 10.0, -15.0]),
        "pitch_rate_deg_s": pick(rng, [0.0, 0.0, 2.0]), "roll_rate_deg_s": pick(rng, [0.0, 0.0, 2.0]),
    }  # fmt: skip
    if chance(rng, 0.1):
        vehicle["light_mounts"] = [
            {"x_m": 0.2, "y_m": 0.3, "z_m": 0.05, "tilt_x_deg": 5.0}, {"y_m": -0.4, "tilt_y_deg": 10.0},
        ]  # fmt: skip
        vehicle["light_count"] = [2, 2]
    plain: dict[str, Any] = {
        "practice": "bare",
        "objective": pick(rng, OBJECTIVES), "physics": pick(rng, ["full", "full", "paper"]), "vehicle": vehicle,
        "requirements": requirements(rng, speed_m_s), "scenes": [scene(rng, 1)], "limits": {},
    }  # fmt: skip
    if chance(rng, 0.35):
        other = scene(rng, 2)
        if chance(rng, 0.5):
            other["altitude_m"] = altitude_m * between(rng, 0.6, 1.5)
            other["altitude_tolerance_m"] = 0.0
        if chance(rng, 0.5):
            other["min_snr_db"] = float(rng.uniform(10, 35))
        plain["scenes"].append(other)
    plain["limits"]["cost_basis"] = "high" if chance(rng, 0.2) else "central"
    if chance(rng, 0.3):
        plain["limits"]["max_exposure_ms"] = between(rng, 0.2, 50)
    if chance(rng, 0.15):
        plain["catalog"] = {"extras": [{"name": "housing", "cost": 1000.0, "mass_kg": 3.0, "power_w": 2.0}]}
    return plain


def in_hand(seed: int) -> dict[str, dict[str, Any]]:
    """Reserves, a lens stopped down, refusals and what else is counted, from a generator of their own.

    All else of a case stays as it is.
    """
    rng = np.random.default_rng([seed, 1])
    wanted: dict[str, Any] = {}
    reserve: dict[str, Any] = {}
    if chance(rng, 0.3):
        reserve = {"snr_db": 1.0, "blur": 0.1, "dof": 0.1}
    if chance(rng, 0.25):
        wanted["lens_stop_down"] = pick(rng, [0.5, 1.0, 2.0])
    if chance(rng, 0.25):
        wanted["max_airy_px"] = between(rng, 0.8, 4)
    catalog = {"rest": "estimate"} if chance(rng, 0.3) else {}
    return {"requirements": wanted, "reserve": reserve, "catalog": catalog}


def with_in_hand(plain: dict[str, Any], seed: int) -> dict[str, Any]:
    """The mission with what is kept in hand."""
    more = in_hand(seed)
    return {**plain, **{key: {**plain.get(key, {}), **own} for key, own in more.items()}}


def with_colours(rng: Rng, made: Parts) -> Parts:
    """The same catalogue with most cameras in colour."""
    cameras = tuple(
        replace(one, qe_curves=dict(COLOURS)) if chance(rng, 0.7) else one for one in made.cameras
    )
    return replace(made, cameras=cameras)


def asking_of_colours(rng: Rng, plain: dict[str, Any]) -> dict[str, Any]:
    """The mission with something asked of its colours, and subjects that move, of scenes one by one."""
    wanted: dict[str, Any] = {}
    if chance(rng, 0.8):
        wanted["min_snr_red_db"] = float(rng.uniform(5, 30))
    if chance(rng, 0.5):
        wanted["max_white_balance"] = between(rng, 1.5, 20)
    scenes = [
        {**given, "subject_speed_m_s": between(rng, 0.05, 1)} if chance(rng, 0.5) else given
        for given in plain["scenes"]
    ]
    return {**plain, "requirements": {**plain["requirements"], **wanted}, "scenes": scenes}


def with_readings(rng: Rng, plain: dict[str, Any]) -> dict[str, Any]:
    """The same waters, some given by what is read of them: the attenuation of their type, that its table is made of."""
    table = "solonenko-mobley" if plain["physics"] == "paper" else "measured"
    scenes = []
    for given in plain["scenes"]:
        if chance(rng, 0.5) and given["water"] != "I":  # no mission may ask for water so clear by its attenuation
            read = {"c_per_m": C_PER_M[table][given["water"]], "water_table": table}
            given = {key: value for key, value in given.items() if key != "water"} | read
        scenes.append(given)
    return {**plain, "scenes": scenes}


def in_mid_water(plain: dict[str, Any]) -> dict[str, Any]:
    """The same mission by night, of dark things without a floor behind them: the water may be brighter than they."""
    wanted = {key: value for key, value in plain["requirements"].items() if key != "overlap"}
    scenes = [
        {**{key: value for key, value in given.items() if key not in ("sun_lux", "overlap")},
         "target": "mid_water", "seafloor": 0.02}
        for given in plain["scenes"]
    ]  # fmt: skip
    return {**plain, "scenes": scenes, "requirements": {"frame_interval_s": 0.5, **wanted}}


def obliquely(rng: Rng, plain: dict[str, Any]) -> dict[str, Any]:
    """The same mission with a camera that looks ahead, in some scenes by another angle; physics `paper` cannot."""
    vehicle = {**plain["vehicle"], "pitch_deg": between(rng, 10, 50)}
    scenes = [{**given, "pitch_deg": between(rng, 5, 40)} if chance(rng, 0.3) else given for given in plain["scenes"]]
    return {**plain, "physics": "full", "vehicle": vehicle, "scenes": scenes}


def in_pairs(rng: Rng, plain: dict[str, Any]) -> dict[str, Any]:
    """The same mission with a stereo pair, turned inward in some."""
    pair = {"camera_count": 2, "camera_baseline_m": between(rng, 0.05, 0.6)}
    turned = {"camera_convergence_deg": between(rng, 2, 20)} if chance(rng, 0.5) else {}
    return {**plain, "vehicle": {**plain["vehicle"], **pair, **turned}}


def loaded(plain: dict[str, Any], limits: dict[str, float] | None = None, **wanted: float) -> Mission:
    """The mission with more limits and requirements on top."""
    return load_mission(
        {
            **plain,
            "limits": {**plain["limits"], **(limits or {})},
            "requirements": {**plain["requirements"], **wanted},
        }
    )
