"""The words that special keys of a mission may hold: water, seafloor, objective, currencies, owned parts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, get_args

from pydantic import BeforeValidator
from pydantic_core import PydanticCustomError

from uwopt.documents.faults import nearest, show
from uwopt.documents.key_types import one_of, refusal, to_choice, to_number, to_text
from uwopt.quantities import TERMS
from uwopt.units import is_number

JERLOV_TYPES = ("I", "IA", "IB", "II", "III", "1C", "3C", "5C", "7C", "9C")
CLARITY_KEYS = ("c_per_m", "visibility_m", "secchi_m", "turbidity_ntu")  # the best known first
WATER_KEYS = ("water", *CLARITY_KEYS)  # how clear it is, which a person can wait for and not choose
SEAFLOORS = ("sand", "hard", "coral", "organic", "benthic-average")
OBJECTIVES = tuple(TERMS)
BEST_IMAGE = "best_image"  # and the one that is no figure: of the most information for its price
Refusal = Literal["airy", "skew", "swath", "depth", "lamp", "white_balance"]
REFUSALS: tuple[str, ...] = get_args(Refusal)
INTERFACES = ("USB3", "GigE", "2.5GigE", "5GigE", "10GigE", "CSI-2", "Camera Link", "coax", "Ethernet RTSP")
Target = Literal["floor", "wall", "ceiling", "mid_water"]
MadeKind = Literal["light", "port", "housing"]  # of which there are classes of parts to be made, the worst first
Made = Literal["allow", "never"] | tuple[MadeKind, ...]
GENERIC = ("fallback", "allow", "never")
#: Other names of keys of `vehicle`, for what is not a floor.
OTHER_NAMES = {"distance_m": "altitude_m", "distance_tolerance_m": "altitude_tolerance_m"}
#: What is looked at, and how far it is, in words.
TARGET_WORDS: Mapping[str, tuple[str, str]] = {
    "floor": ("floor", "altitude"), "wall": ("wall", "distance"), "ceiling": ("ceiling", "distance"),
    "mid_water": ("target", "distance"),
}  # fmt: skip


def to_target(value: Any) -> Any:
    """What is looked at, with underscores."""
    plain = to_choice(value)
    return plain.replace("-", "_").replace(" ", "_") if isinstance(plain, str) else plain


MOST_PITCH_DEG, UP_DEG = 80.0, 100.0


def to_pitch(value: Any) -> float:
    """Degrees from square on what is looked at; told from straight down, what to say of a camera that looks level or
    up instead."""
    pitch_deg = to_number(value)
    if pitch_deg > UP_DEG:
        raise refusal(
            "is of a camera that looks up", f"set scene.target: ceiling, with pitch_deg: {abs(180.0 - pitch_deg):g} "
            "from straight up (daylight is not reckoned there)",
        )  # fmt: skip
    if pitch_deg > MOST_PITCH_DEG:
        raise refusal(
            f"is above {MOST_PITCH_DEG:g}, of a camera that looks level", "set scene.target: wall or mid_water, with "
            "pitch_deg: 0 for square on it",
        )  # fmt: skip
    return pitch_deg


def to_water(value: Any) -> str:
    """A Jerlov type in its usual spelling, or the name of a CSV."""
    if is_number(value):
        near = {1: "I or 1C", 2: "II", 3: "III or 3C", 5: "5C", 7: "7C", 9: "9C"}.get(
            int(value) if value == value and abs(value) < 99 else 0
        )
        types = ", ".join(JERLOV_TYPES)
        raise refusal(
            "is a number, not a Jerlov type", f"write {near}" if near else f"write one of {types}, or a CSV"
        )
    text = to_text(value)
    if text.casefold().endswith(".csv"):
        return text
    plain = text.casefold().removeprefix("jerlov").removeprefix("type").strip(" -_").upper()
    if plain not in JERLOV_TYPES:
        raise one_of(plain, JERLOV_TYPES, "or name a CSV profile with wavelength_nm and attenuation_per_m")
    return plain


def to_seafloor(value: Any) -> float | str:
    """A reflectance, a known floor, or the name of a CSV."""
    try:
        number = to_number(value) if isinstance(value, (int, float)) or _is_number(value) else None
    except ValueError:
        number = None
    if number is not None:
        if not 0 <= number <= 1:
            raise refusal("is not a reflectance 0..1", "did you mean 0.2 for 20 %?")
        return number
    text = to_text(value)
    if text.casefold().endswith(".csv"):
        return text
    plain = text.casefold().replace("_", "-").replace(" ", "-")
    if plain in SEAFLOORS:
        return plain
    measured = {name.casefold().replace("_", "-").replace(" ", "-"): name for name in _measured_seafloors()}
    if plain not in measured:
        raise one_of(
            plain, SEAFLOORS, "or give a reflectance 0..1, or a CSV with wavelength_nm and reflectance"
        )
    return measured[plain]


def _is_number(value: Any) -> bool:
    try:
        return isinstance(value, str) and float(value) == float(value)
    except ValueError:
        return False


def _measured_seafloors() -> set[str]:
    from uwopt.catalog.tables import built_in_rows

    return {row["type"] for row in built_in_rows("bottom_reflectance.csv")}


def to_objective(value: Any) -> str | dict[str, float]:
    """The name of a figure, or weights by name."""
    if isinstance(value, str):
        return _objective_name(value, (*OBJECTIVES, BEST_IMAGE))
    if not isinstance(value, Mapping):
        raise refusal(
            f"is not one of {', '.join((*OBJECTIVES, BEST_IMAGE))}", "or give weights such as {power: 1, cost: 0.01}"
        )
    weights: dict[str, float] = {}
    for key, given in value.items():
        name = _objective_name(key)
        try:
            weight = to_number(given)
        except PydanticCustomError as fault:
            known = fault.context or {}
            raise refusal(f"has a weight for {name} that {known['what']}", known["mend"]) from None
        if weight < 0:
            raise refusal(
                f"has a negative weight for {name}", "every term is already turned so that less is better"
            )
        if name in weights:
            raise refusal(f"names {name} twice", "give one weight a figure")
        weights[name] = weight
    if not any(weights.values()):
        raise refusal("has no weight above 0", "give weights such as {power: 1, cost: 0.01}")
    return weights


def _objective_name(value: Any, known: tuple[str, ...] = OBJECTIVES) -> str:
    plain = str(value).strip().casefold().replace("-", "_")
    plain = {"power_w": "power", "mass_kg": "mass", "snr": "snr_db", "gsd": "gsd_mm"}.get(plain, plain)
    if plain not in OBJECTIVES:
        raise one_of(plain, known)
    return plain


def to_refusals(value: Any) -> Any:
    """A list of refusals, each once; `all` stands for all of them."""
    given = [value] if isinstance(value, str) else value
    if not isinstance(given, (list, tuple)):
        return value
    names = [to_choice(word) for word in given]
    for word in names:
        if not isinstance(word, str) or word not in (*REFUSALS, "all"):
            raise one_of(str(word), (*REFUSALS, "all"))
    return REFUSALS if "all" in names else tuple(dict.fromkeys(names))


def to_interfaces(value: Any) -> Any:
    """A list of interfaces as the catalogue spells them, each once; case, `-`, `_` and blanks are ignored."""

    def plain(name: str) -> str:
        return "".join(sign for sign in name.casefold() if sign not in "-_ ")

    given = [value] if isinstance(value, str) else value
    if not isinstance(given, (list, tuple)):
        return value
    by_name, found = {plain(name): name for name in INTERFACES}, []
    for word in given:
        if plain(str(word)) not in by_name:
            raise one_of(str(word), INTERFACES)
        found.append(by_name[plain(str(word))])
    return tuple(dict.fromkeys(found))


def to_generic(value: Any) -> Any:
    """Whether parts to be made may be used, or a list of the kinds of which they may."""
    kinds, is_list = get_args(MadeKind), isinstance(value, (list, tuple))
    asked = [to_choice(item) for item in (value if is_list else [value])]
    if not is_list and asked[0] in GENERIC:
        return asked[0]
    if unknown := [str(item) for item in asked if item not in kinds]:
        many = f"or list some of {', '.join(kinds)}, of which parts may be made"
        raise one_of(unknown[0], kinds, f"take {unknown[0]!r} out") if is_list else one_of(unknown[0], GENERIC, many)
    return tuple(kind for kind in kinds if kind in asked) or "never"


def to_currency_code(value: Any) -> str:
    """Three letters, upper case."""
    code = to_text(value).upper()
    if len(code) != 3 or not code.isascii() or not code.isalpha():
        raise refusal("is not a currency", "write three letters such as USD")
    return code


def to_rates(value: Any) -> Any:
    """Exchange rates by currency code."""
    if not isinstance(value, Mapping):
        return value
    return {to_currency_code(key): rate for key, rate in value.items()}


def to_owned(value: Any) -> Any:
    """A list of owned parts; a bare id means one piece."""
    if isinstance(value, (str, Mapping)):
        value = [value]
    if not isinstance(value, (list, tuple)):
        return value
    return [{"id": item} if isinstance(item, str) else item for item in value]


def to_part_fields(value: Any) -> tuple[str, ...]:
    """Names of fields of a part's record."""
    from uwopt.catalog import records

    names = [value] if isinstance(value, str) else value
    if not isinstance(names, (list, tuple)):
        raise refusal("is not a list", "write a list such as [price]")
    kinds = (records.Camera, records.Lens, records.Port, records.Light)
    known = tuple(sorted({name for kind in kinds for name in kind.__dataclass_fields__}))
    for name in names:
        if name not in known:
            near = nearest(str(name), known)
            mend = f"did you mean {near}?" if near else "name fields such as price, power_w, read_noise_e"
            raise refusal(f"holds {show(name)}, which no part has", mend)
    return tuple(names)


def number_or_recommended(recommended: float) -> BeforeValidator:
    """A number, or the word that stands for what good practice asks for."""

    def to_value(value: Any) -> float:
        plain = value.strip().casefold() if isinstance(value, str) else value
        return recommended if plain == "recommended" else to_number(value)

    return BeforeValidator(to_value)


def to_on_off(value: Any) -> Any:
    """On or off, which YAML also reads as true and false."""
    return ("on" if value else "off") if isinstance(value, bool) else value


def to_complete(value: Any) -> Any:
    """Whether complete cameras are searched; true is beside the others, false not at all."""
    return ("also" if value else "none") if isinstance(value, bool) else value
