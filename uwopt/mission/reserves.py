"""Reserves of a mission: reserves on what it asks for, and defaults of what an expert would refuse.

Here and nowhere else do requirements as asked become requirements as held: search, evaluation and explanations see
the latter alone. The former stay beside them, so that a margin can say how much of its limit is reserve.
"""

import math
from collections.abc import Collection, Iterable, Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from uwopt.documents.key_types import NUMBER, Section, one_of
from uwopt.mission.sections.requirements import Requirements
from uwopt.mission.sections.vehicle import Vehicle
from uwopt.units import S_PER_H, db_to_ratio, ratio_to_db

RECOMMENDED = "recommended"
BATTERY_IN_HAND = 0.2  # of its energy: lithium cells give a fifth less where they are old or cold (convention)
RECOMMENDED_RESERVE: Mapping[str, float] = {
    "snr_db": 3.0, "blur": 0.20, "swath": 0.10, "dof": 0.10, "depth": 1.25, "tilt_deg": 3.0,
    "max_gain_db": 12.0, "energy": BATTERY_IN_HAND,
}  # fmt: skip
IN_DB = ("min_snr_db", "min_snr_red_db")  # what the reserve of the signal-to-noise ratio is added to
MADE_FOR_M = 6000.0  # the deepest that instruments are rated for, but for those of full ocean depth, 11 000 m
REFUSED_DEPTH = 1.1  # rating over depth: a margin below 10 %


class Reserve(Section):
    """What designs keep in hand of each requirement; what is left out keeps nothing, or what good practice says."""

    snr_db: Annotated[float, Field(ge=0, le=40), NUMBER] = Field(
        default=0.0, description="reserve of the signal-to-noise ratio in decibels, recommended 3"
    )
    blur: Annotated[float, Field(ge=0, le=0.9), NUMBER] = Field(
        default=0.0, description="share of the allowed motion blur that stays unused, recommended 0.2"
    )
    swath: Annotated[float, Field(ge=0, le=10), NUMBER] = Field(
        default=0.0, description="share by which the swath is wider than asked for, recommended 0.1"
    )
    dof: Annotated[float, Field(ge=0, le=10), NUMBER] = Field(
        default=0.0, description="share by which the depth of field is longer than asked for, recommended 0.1"
    )
    depth: Annotated[float, Field(ge=1, le=10), NUMBER] | None = Field(
        default=None,
        description="depth rating over the deepest scene, recommended 1.25; decides whatever is refused, and left out "
        "it is 1, or 1.1 with refuse: depth; limits.depth_rating_m is a rating and taken as it stands",
    )
    tilt_deg: Annotated[float, Field(ge=0, le=30), NUMBER] = Field(
        default=0.0,
        description="degrees that every lamp may lean inward or outward before what is asked for is lost, "
        "recommended 3; held by the settings to set, of the best hardware for which there are such",
    )

    max_gain_db: Annotated[float, Field(ge=0, le=120), NUMBER] | None = Field(
        default=None,
        description="highest gain in decibels while anything fits below it, recommended 12; solve lifts it where "
        "nothing does, with a warning",
    )
    energy: Annotated[float, Field(ge=0, le=0.9), NUMBER] = Field(
        default=0.0,
        description="share of a battery that is part of the system (vehicle.supply: battery) that stays unused, "
        "recommended 0.2: cells that are old or cold give less than their plate says; limits.energy_wh is taken as it "
        "stands",
    )

    @property
    def snr_ratio(self) -> float:
        """The reserve of the signal-to-noise ratio as a factor."""
        return float(db_to_ratio(self.snr_db))


def to_reserve(value: Any) -> Any:
    """The values of the word `recommended`; else as given."""
    if not isinstance(value, str):
        return value
    if value.strip().casefold() != RECOMMENDED:
        raise one_of(value, (RECOMMENDED,), "or give keys such as {snr_db: 3, blur: 0.2}")
    return dict(RECOMMENDED_RESERVE)


#: The key that each refusal holds, with its default; `depth` is held by the depth rating, `swath` see below.
REFUSED: Mapping[str, tuple[str, float]] = {
    "airy": ("max_airy_px", 2.0), "skew": ("max_skew_px", 2.0), "swath": ("min_swath_m", 1.0),
    "white_balance": ("max_white_balance", 4.0),
}  # fmt: skip


def with_refusals(wanted: Requirements, vehicle: Vehicle) -> Requirements:
    """Requirements with the default of each refusal in place; a key that the mission gives stays as it is.

    Area per hour is swath x (1 - sidelap) x speed, so that it asks for a swath, of a stereo pair for the strip that
    both cameras see; bars ask for pixels and an SNR.

    The swath is refused in a survey alone: at speed, with an overlap.
    """
    survey = vehicle.speed_m_s > 0.0 and wanted.overlap is not None
    made = {
        key: refused_at(word, vehicle.nearest_m)
        for word, (key, _) in REFUSED.items()
        if word in wanted.refuse and getattr(wanted, key) is None and (survey or word != "swath")
    }
    if wanted.min_area_m2_h is not None and vehicle.speed_m_s > 0.0:
        swath_m = wanted.min_area_m2_h / (S_PER_H * vehicle.speed_m_s * (1.0 - wanted.sidelap))
        key = "min_swath_m" if vehicle.camera_baseline_m is None else "min_common_swath_m"
        made[key] = max(swath_m, getattr(wanted, key) or made.get(key, 0.0))
    if wanted.resolve_mm is not None:
        made |= asked_by_bars(wanted, wanted.resolve_mm)
    return wanted.model_copy(update=made) if made else wanted


def refused_at(word: str, nearest_m: float) -> float:
    """The default of a refusal in a scene whose floor comes as near as this.

    Who is asked to work near sees little: a swath is refused that is narrower than 1 m and than that distance too,
    which is a view of 2 atan(1/2) = 53 degrees in water.
    """
    value = REFUSED[word][1]
    return min(value, nearest_m) if word == "swath" else value


def asked_by_bars(wanted: Requirements, bar_mm: float) -> dict[str, float]:
    """What bars on the floor ask for beside their contrast: no pixel is wider, and a tenth shows in the noise."""
    from uwopt.model.sharpness import RESOLVED_SNR  # brings numpy, which loading a mission does without

    made = {"max_gsd_mm": min(bar_mm, wanted.max_gsd_mm or bar_mm)}
    if (wanted.min_snr or 0.0) < RESOLVED_SNR:
        key, value = ("min_snr_db", float(ratio_to_db(RESOLVED_SNR)))
        if wanted.min_snr_db is None and wanted.min_snr_given is not None:
            key, value = ("min_snr_given", RESOLVED_SNR)
        made[key] = value
    return made


def factors_of(reserve: Reserve) -> dict[str, float]:
    """What is held over what is asked for, by key."""
    return {
        "min_snr_given": reserve.snr_ratio,
        "max_blur_px": 1.0 - reserve.blur,
        "min_swath_m": 1.0 + reserve.swath,
        "min_common_swath_m": 1.0 + reserve.swath,
        "min_dof_m": 1.0 + reserve.dof,
    }


def held_of(asked: Requirements, reserve: Reserve) -> Requirements:
    """Requirements as designs must meet them: those asked for, and the reserve on top."""
    made = {
        key: value * factor
        for key, factor in factors_of(reserve).items()
        if factor != 1.0 and (value := getattr(asked, key)) is not None
    }
    for key in IN_DB:
        if reserve.snr_db and (value := getattr(asked, key)) is not None:
            made[key] = value + reserve.snr_db
    if reserve.max_gain_db is not None:
        made["max_gain_db"] = min(reserve.max_gain_db, math.inf if asked.max_gain_db is None else asked.max_gain_db)
    return asked.model_copy(update=made) if made else asked


def asked_when_held(reserve: Reserve, key: str, held: float) -> float:
    """What a mission asks for when this is what must be held: the reserve taken off again."""
    return held - reserve.snr_db if key in IN_DB else held / factors_of(reserve).get(key, 1.0)


def depth_factor(given: float | None, refused: Iterable[Collection[str]], rating_m: float | None = None) -> float:
    """Depth that parts must be rated for, over the one asked for: what is given, else as any scene refuses.

    A rating that is asked for has its own margin: classification tests a pressure hull at 1.25 times its rated depth
    (ABS, underwater vehicles, section 3.1), so that a factor on it would keep that twice. Instruments rated to 6000 m
    work at 6000 m.
    """
    if rating_m is not None:
        return 1.0
    if given is not None:
        return given
    return REFUSED_DEPTH if any("depth" in words for words in refused) else 1.0


def kept_of(asked: Requirements, held: Requirements, key: str) -> float:
    """How much of a held limit is reserve, in the requirement's unit; 0 where nothing is asked."""
    if key == "min_snr_db" and asked.min_snr_given is not None and held.min_snr_given is not None:
        return float(ratio_to_db(held.min_snr_given / asked.min_snr_given))
    first, last = getattr(asked, key), getattr(held, key)
    return 0.0 if first is None or last is None else abs(last - first)


ReserveOrWord = Annotated[Reserve, BeforeValidator(to_reserve)]
