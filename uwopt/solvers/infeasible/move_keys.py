"""Which keys of a mission are moved where nothing fits, and how far: lamps, water, height, speed, times, what feeds it.

A key is tried only where it can matter: what takes or holds energy where energy is counted against a limit. A battery
that the system brings along is tried larger where energy lacks, else smaller, where its price or mass counts.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from uwopt.forward.lamps import LAMP_FRONT_M
from uwopt.mission.duration import Duration
from uwopt.mission.mission import Mission
from uwopt.mission.sections.vehicle import MAX_LIGHTS
from uwopt.mission.varying import Value, Varied, rounded
from uwopt.mission.weakened import in_all_scenes
from uwopt.solvers.infeasible.freed_rules import BATTERY, HOURS, LAMPS, LAMPS_AT, LAMPS_LEAN, SWITCHES
from uwopt.solvers.infeasible.least_change import rounded_away

FARTHEST_SPEED = 0.1  # of the speed that is asked
ALTITUDES = (0.4, 0.65, 1.5, 0.15)  # of the altitude that is asked; what is near and fits at all fits soonest
STEADY = "altitude_tolerance_m"
STEADIEST = 0.25  # of the tolerance that is asked
FARTHEST_CLARITY = (40.0, 8.0)  # times as clear, but no clearer than a mission can say
CLEAREST = {"c_per_m": 0.055, "visibility_m": 80.0, "secchi_m": 80.0, "turbidity_ntu": 0.02}
LAMP_PLACES = (2.0, 4.0, 0.4)  # of the distance from port to lamps that is asked
FROM_NONE_M = (0.3, 0.6)  # the same, where they are asked at the port itself
FARTHEST_LAMP_M = 20.0  # as a mission can say
LEANINGS_DEG = (10.0, 25.0, -10.0, -25.0)  # more than what is asked
MOST_LEANING_DEG = 60.0  # more of it lights the water alone
BRIGHT_DAY_LUX = 100_000.0  # at the surface, at noon under a clear sky
FARTHEST_TIME = 10.0  # times as long between images
FARTHEST_ENERGY = (10.0, 100.0)  # times as short a mission, or as much in its battery
SMALLER = (0.5, 0.2, 0.08)  # of the battery that is asked, which must still last as long
#: Jerlov types from the clearest on, by their attenuation at 530 nm.
CLEAREST_FIRST = ("I", "IA", "IB", "II", "1C", "III", "3C", "5C", "7C", "9C")


@dataclass(frozen=True)
class Try:
    """A key and the values far from what is asked at which it is tried, in turn, until something fits."""

    key: Varied
    asked: Value
    values: tuple[Value, ...]


def tries_of(mission: Mission, *, for_want_of_energy: bool = False, for_want_of_budget: bool = False) -> Iterator[Try]:
    """Each key that may be moved; one on which the scenes differ is left alone.

    for_want_of_energy : whether it is energy that nothing has enough of: then what takes or holds it comes first
    for_want_of_budget : whether it is money or mass: then a battery that takes of them comes first
    """
    # what light takes is least to try, as the imagers stay; lamps are tried all at once before (`Mover.try_lamps`)
    others = [*_waters(mission), *_day(mission), *_vehicle(mission), *_lamps(mission)]
    energy = [*_energy(mission, for_want_of_energy=for_want_of_energy)]
    if for_want_of_budget and not for_want_of_energy:
        first = [one for one in energy if one.key.name == BATTERY]
        yield from [*first, *others, *(one for one in energy if one not in first)]
    else:
        yield from [*energy, *others] if for_want_of_energy else [*others, *energy]


def shared_keys(mission: Mission, *, for_want_of_energy: bool) -> dict[str, float]:
    """Keys of the vehicle that may give together with limits, as asked: by a share less, but of a battery more."""
    common = {key: in_all_scenes(mission, "vehicle", key) for key in ("speed_m_s", "altitude_m", STEADY)}
    if for_want_of_energy:
        energy = [one for one in _energy(mission, for_want_of_energy=True) if one.key.name in (BATTERY, HOURS)]
        common |= {one.key.name: float(one.asked) for one in energy}
    return {key: value for key, value in common.items() if value}


def _lamps(mission: Mission) -> Iterator[Try]:
    """How far from the port lamps stand, how they lean and how many they are, where the mission leaves no choice."""
    vehicle = mission.vehicle
    if vehicle.light_mounts or vehicle.light_count[1] == 0:
        return
    (near_m, far_m), (least_deg, most_deg) = vehicle.light_baseline_range_m, vehicle.light_tilt_range_deg
    if mission.physics != "paper":  # which has them on the axis wherever they stand
        if near_m == far_m:
            tried = [rounded_away(times * near_m, near_m) for times in LAMP_PLACES] if near_m else FROM_NONE_M
            kept = tuple(one for one in tried if LAMP_FRONT_M < one <= FARTHEST_LAMP_M)
            yield _try("vehicle", LAMPS_AT, near_m, kept)
        if least_deg == most_deg:
            leanings = tuple(rounded(least_deg + more) for more in LEANINGS_DEG)
            yield _try("vehicle", LAMPS_LEAN, least_deg, tuple(n for n in leanings if abs(n) <= MOST_LEANING_DEG))
    fewest, most = vehicle.light_count
    if fewest == most:
        yield _try("vehicle", LAMPS, most, tuple(n for n in (2 * most, most // 2) if 1 <= n <= MAX_LIGHTS))


def _vehicle(mission: Mission) -> Iterator[Try]:
    """Height, how steadily it is kept, speed, and the time between images."""
    if altitude := in_all_scenes(mission, "vehicle", "altitude_m"):
        values = tuple(rounded_away(factor * altitude, altitude) for factor in ALTITUDES)
        yield _try("vehicle", "altitude_m", altitude, values)
    if tolerance := in_all_scenes(mission, "vehicle", STEADY):
        yield _try("vehicle", STEADY, tolerance, (rounded_away(STEADIEST * tolerance, tolerance),))
    if speed := in_all_scenes(mission, "vehicle", "speed_m_s"):
        yield _try("vehicle", "speed_m_s", speed, (rounded_away(FARTHEST_SPEED * speed, speed),))
    if interval := in_all_scenes(mission, "requirements", "frame_interval_s"):
        yield _try("requirements", "frame_interval_s", interval, (rounded(FARTHEST_TIME * interval),))


def _energy(mission: Mission, *, for_want_of_energy: bool) -> Iterator[Try]:
    """What stays on between images, the battery that the system brings along, and how long that must last."""
    limits, of_all = mission.limits, Duration.of(mission)
    is_limited = math.isfinite(of_all.energy_wh) and of_all.duration_h is not None
    if in_all_scenes(mission, "requirements", "frame_interval_s") and (is_limited or limits.power_w is not None):
        for name in SWITCHES:
            if in_all_scenes(mission, "vehicle", name) == "on":
                yield _try("vehicle", name, "on", ("off",))
    if is_limited and limits.energy_wh is None and (battery_wh := of_all.battery_wh) is not None:
        is_dear = mission.catalog.rest == "estimate" and (limits.cost is not None or limits.mass_kg is not None)
        times = FARTHEST_ENERGY if for_want_of_energy or not is_dear else SMALLER
        yield _try("vehicle", BATTERY, battery_wh, tuple(rounded(one * battery_wh) for one in times))
    if of_all.duration_h and (is_limited or limits.storage_gb is not None):
        values = tuple(rounded(of_all.duration_h / times) for times in FARTHEST_ENERGY)
        yield _try("vehicle", HOURS, of_all.duration_h, values)


def _waters(mission: Mission) -> Iterator[Try]:
    """Clearer water, by the reading or by the type that the mission names."""
    waters = {(scene.clarity, scene.water) for scene in mission.scenes}
    if len(waters) > 1:
        return
    reading, water = waters.pop()
    if reading is not None:
        name, value = reading
        most = CLEAREST[name]
        far = [min(value * times, most) if most > value else max(value / times, most) for times in FARTHEST_CLARITY]
        if most != value:
            yield _try("scene", name, value, tuple(dict.fromkeys(rounded_away(one, value) for one in far)))
    elif water in CLEAREST_FIRST and water != CLEAREST_FIRST[0]:
        yield _try("scene", "water", water, (CLEAREST_FIRST[0],))


def _day(mission: Mission) -> Iterator[Try]:
    """A brighter day, where the sun gives light; physics `paper` knows of none."""
    suns = {scene.sun_lux for scene in mission.scenes}
    if mission.physics != "paper" and len(suns) == 1 and 0.0 < (sun_lux := suns.pop()) < BRIGHT_DAY_LUX:
        yield _try("scene", "sun_lux", sun_lux, (BRIGHT_DAY_LUX,))


def _try(section: str, name: str, asked: Value, values: tuple[Value, ...]) -> Try:
    return Try(Varied(name, section, name, values), asked, values)
