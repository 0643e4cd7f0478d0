"""One system with its settings: parts, settings, figures, margins, totals and bill, as results hold it."""

from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any, Self

from pydantic import Field
from pydantic.dataclasses import dataclass

from uwopt.results.frames import bill_rows, figure_rows, frame_of, margin_rows
from uwopt.results.record import RECORD, Flag, Number, Record, Whole
from uwopt.units import db_to_ratio

if TYPE_CHECKING:
    import pandas as pd

NOT_SETTABLE = "not_settable"  # code of the note that no settings to type in are offered
SNR_INSTEAD = "snr_instead"  # code of the note that says why the best image is by signal to noise
PRACTICE_YIELDS = "practice_yields"  # nothing meets all of good practice
PRACTICE_MISSED = "practice_missed"  # what is missed is good practice alone, not what the mission itself says
PRACTICE_WOULD_YIELD = "practice_would_yield"  # the same, where all of it is asked nevertheless
PRACTICE_IN_VAIN = "practice_in_vain"  # nothing fits even with all relaxed that may be
PRACTICE_UNTRIED = "practice_untried"  # whether something fits with less of it was not known in time
AS_CENTRAL = "certainty_left_out"  # it was not chosen by how many scenarios it holds in, though that is asked
#: Settings that a system file states; its light level as a share, for flashes too.
STATED = ("f_number", "exposure_ms", "pulse_ms", "gain", "dim_frac", "frame_rate_hz", "focus_distance_m")
FARTHEST_M = 10_000.0  # focus that may be stated or set; in place of one at infinity, or beyond
COLOUR_LEFT_OPEN = "colour_left_open"  # code of the note that says what sensor was chosen where none was asked


@dataclass(frozen=True, config=RECORD)
class Note(Record):
    """What a user should know of an input, a design or a result."""

    code: str = Field(description="which, in one word")
    path: str = Field(description="the key that it is about")
    message: str = Field(description="one sentence")


@dataclass(frozen=True, config=RECORD)
class UsedPart(Record):
    """One part by its names."""

    id: str = Field(description="in the catalogue, or of an inline record")
    name: str = Field(description="maker and model")
    generic: Flag = Field(description="to be made: a class of parts, no product")


@dataclass(frozen=True, config=RECORD)
class LampPlace(Record):
    """Where a lamp stands, from the port, and how it leans."""

    x_m: Number = Field(description="forward")
    y_m: Number = Field(description="starboard")
    z_m: Number = Field(description="down")
    tilt_x_deg: Number = Field(description="forward")
    tilt_y_deg: Number = Field(description="outward")


@dataclass(frozen=True, config=RECORD)
class UsedHardware(Record):
    """Which parts, how many, and how they stand."""

    camera: UsedPart = Field(description="each with its lens and port")
    lens: UsedPart = Field(description="on the camera")
    port: UsedPart = Field(description="before the lens")
    light: UsedPart = Field(description="all lamps are of one kind")
    camera_count: Whole = Field(description="cameras")
    light_count: Whole = Field(description="lamps")
    orientation: str = Field(
        description="landscape: the image's height along the motion; portrait: its width"
    )
    light_mounts: list[LampPlace] = Field(description="one a lamp")
    housing: UsedPart | None = Field(
        default=None, description="that each port is built into; null where none is asked for"
    )
    spacer_mm: Number = Field(default=0.0, description="length of the rings between lens and camera")
    complete: UsedPart | None = Field(
        default=None, description="the complete camera that camera, lens and port are pieces of; null where none is"
    )
    camera_baseline_m: Number | None = Field(
        default=None, description="between the ports of a stereo pair, across track; null of others"
    )
    camera_convergence_deg: Number = Field(default=0.0, description="between the axes of a stereo pair")

    @property
    def parts(self) -> dict[str, UsedPart]:
        """The parts by kind: four, and the housing where there is one."""
        housing = {} if self.housing is None else {"housing": self.housing}
        return {"camera": self.camera, "lens": self.lens, "port": self.port, **housing, "light": self.light}

    @property
    def named(self) -> dict[str, UsedPart]:
        """The same as they are bought: a complete camera in the place of its pieces."""
        return self.parts if self.complete is None else {"complete": self.complete, "light": self.light}

    @property
    def ids(self) -> list[str]:
        """Ids of camera, lens, port, housing where there is one, and light."""
        return [*self.ids_by_kind.values()]

    @property
    def ids_by_kind(self) -> dict[str, str]:
        """The same by kind."""
        return {kind: part.id for kind, part in self.parts.items()}


@dataclass(frozen=True, config=RECORD)
class Cost(Record):
    """What is to pay, with the range that estimated prices leave."""

    value: Number = Field(description="with every estimate at its likeliest value")
    low: Number = Field(description="with all estimates at their low ends")
    high: Number = Field(description="with all estimates at their high ends")
    currency: str = Field(description="of all of these")
    estimated: Number = Field(description="how much of the value is estimated")
    estimated_low: Number = Field(description="the same at the low ends")
    estimated_high: Number = Field(description="the same at the high ends")


@dataclass(frozen=True, config=RECORD)
class Totals(Record):
    """What the whole system costs, draws and weighs; of several scenes the most."""

    cost: Cost = Field(description="of what is not owned")
    power_w: Number | None = Field(description="on average")
    light_power_w: Number | None = Field(description="of it the lamps'")
    light_peak_power_w: Number | None = Field(description="while the lamps burn, or flashes recharge")
    mass_kg: Number | None = Field(description="of all parts")
    mass_water_kg: Number | None = Field(
        default=None, description="in water, of the cameras in their housings; null without housings"
    )
    size_mm: list[Number] | None = Field(
        default=None, description="length and diameter of a housing with its port; null without housings"
    )
    housing_heat_w: Number | None = Field(
        default=None, description="that each housing's camera, and a computer in it, give off; null without housings"
    )
    housing_warmer_k: list[Number] | None = Field(
        default=None, description="air in a housing over the water, at the least and the most; null without housings"
    )
    energy_wh: Number | None = Field(
        default=None,
        description="over the mission's duration, scenes weighed by their time; null without one",
    )
    storage_gb: Number | None = Field(
        default=None,
        description="of uncompressed images over the mission's duration, 10^9 byte; null without one",
    )
    endurance_h: Number | None = Field(
        default=None, description="that the vehicle's battery lasts; null without one"
    )
    run_time_h: Number | None = Field(
        default=None, description="that the cameras' own batteries last; null where the vehicle feeds them"
    )


@dataclass(frozen=True, config=RECORD)
class BillRow(Record):
    """One row of the bill of materials."""

    kind: str = Field(description="camera | lens | port | light | housing | complete | extra")
    id: str = Field(description="of the part")
    manufacturer: str = Field(description="empty where there is none")
    model: str = Field(description="maker's name of the part")
    count: Whole = Field(description="how many are needed")
    owned: Whole = Field(description="how many of them are there already")
    unit_price: Number | None = Field(description="null where nobody knows it")
    unit_price_low: Number | None = Field(description="low end of an estimate")
    unit_price_high: Number | None = Field(description="high end of an estimate")
    currency: str = Field(description="of the prices")
    price_status: str = Field(description="list | own | quoted | derived | estimated | to be made | unknown")
    price_date: str = Field(description="YYYY-MM-DD")
    generic: Flag = Field(description="to be made: a class of parts, no product")
    source: str = Field(description="where the part is described")
    price_basis: str = Field(description="where the price is from")
    note: str = Field(default="", description="what the catalogue remarks of the part, such as limits of its use")
    purpose: str = Field(default="", description="what it was made for")
    availability: str = Field(default="", description="current | unknown | ...; empty where it is no product")
    checked: str = Field(default="", description="YYYY-MM-DD on which the row was held against its source")
    unit_mass_kg: Number | None = Field(default=None, description="of one, in air; null where nobody knows it")
    power_w: Number | None = Field(
        default=None, description="that all of them draw on average, in the scene that takes most; null: none"
    )

    @property
    def to_buy(self) -> int:
        """Pieces that are not owned yet."""
        return max(0, self.count - self.owned)

    @property
    def estimated(self) -> bool:
        """Whether nobody quotes the price."""
        return self.price_status in ("estimated", "to be made")


@dataclass(frozen=True, config=RECORD)
class SettableCheck(Record):
    """How a design does with the settings that a person can set."""

    feasible: Flag = Field(description="whether every requirement still holds")
    objective_value: Number | None = Field(description="what the objective becomes")
    missed: list[str] = Field(description="requirements that the nearest settings miss")
    power_w: Number | None = Field(default=None, description="mean power with these settings [W]")
    totals: Totals | None = Field(default=None, description="cost, power and mass with these settings")


MISFIT = "fits: "  # how margins begin of what does not fit together


@dataclass(frozen=True, config=RECORD)
class Margin(Record):
    """One requirement held against its limit, worst over the altitudes."""

    requirement: str = Field(
        description="its key in a mission, with the part's id where a part sets the limit"
    )
    value: Number | None = Field(description="what is reached")
    limit: Number | None = Field(description="null where there is none")
    sense: str = Field(description="<=, >= or =")
    margin: Number | None = Field(description="what is left; negative: missed")
    unit: str = Field(description="of value, limit and margin")
    at_altitude_m: Number | None = Field(description="where it is worst; null where altitude does not matter")
    satisfied: Flag = Field(description="whether it is met")
    binding: Flag = Field(description="whether nothing is left of it")
    word: str = Field(default="", description="in place of a value that is no number")
    reserve: Number = Field(default=0.0, description="how much of the limit is a reserve, beyond what is asked for")

    @property
    def asked(self) -> float | None:
        """The limit that the mission asks for; the one held is stricter by the reserve."""
        if self.limit is None:
            return None
        return self.limit + self.reserve if self.sense == "<=" else self.limit - self.reserve

    @property
    def is_of_fit(self) -> bool:
        """Whether it only says that something does not fit, which no number tells."""
        return self.requirement.startswith(MISFIT)

    @property
    def key(self) -> str:
        """The requirement without the part that sets its limit."""
        return self.requirement.partition(" (")[0]

    @property
    def share_left(self) -> float | None:
        """What is left as a share of what is asked for, its reserve included; of decibels as a ratio.

        None where nothing is asked for that could be used up.
        """
        if self.margin is None or not self.asked or self.sense == "=":
            return None
        left = self.margin + self.reserve
        return float(db_to_ratio(left)) - 1.0 if self.unit == "dB" else left / abs(self.asked)


@dataclass(frozen=True, config=RECORD)
class SceneResult(Record):
    """Settings, figures at the nominal altitude, and margins of one scene."""

    name: str = Field(description="the scene's in the mission")
    settings: dict[str, Number | None] = Field(description="the exact optimum, or as given")
    settings_to_set: dict[str, Number | None] | None = Field(description="rounded to what a person can set")
    figures: dict[str, Any] = Field(description="numbers by name, flags of what is infinite; at `settings`")
    margins: list[Margin] = Field(description="one a requirement that applies; at `settings`")
    figures_as_set: dict[str, Any] | None = Field(default=None, description="figures at `settings_to_set`")
    margins_as_set: list[Margin] | None = Field(default=None, description="margins at `settings_to_set`")


@dataclass(frozen=True, config=RECORD)
class Design(Record):
    """One system with its settings."""

    hardware: UsedHardware = Field(description="parts, how many, and where the lights stand")
    objective_value: Number | None = Field(description="in the objective's unit, not negated")
    feasible: Flag = Field(description="whether every margin is met")
    totals: Totals = Field(description="cost, power and mass")
    scenes: list[SceneResult] = Field(min_length=1, description="in the mission's order")
    bom: list[BillRow] = Field(description="what to order")
    rounded: SettableCheck | None = Field(default=None, description="the settings to set, checked again")
    warnings: list[Note] = Field(default_factory=list, description="what to know of this design")

    @property
    def is_settable(self) -> bool:
        """Whether no settings to set were looked for, or some were found with which every requirement holds."""
        return self.rounded is None or self.rounded.feasible

    @property
    def margins(self) -> list[Margin]:
        """Those of all scenes."""
        return [margin for scene in self.scenes for margin in scene.margins]

    @property
    def missed(self) -> list[Margin]:
        """Those of them that are not met."""
        return [margin for margin in self.margins if not margin.satisfied]

    def least(self, figure: str) -> float | None:
        """The least of a figure over the scenes; None where none has it."""
        told = [value for scene in self.scenes if (value := scene.figures.get(figure)) is not None]
        return min(told, default=None)

    @property
    def as_set(self) -> Self:
        """This design at the settings that a person sets: its settings, figures, margins, totals and objective.

        The design itself where none are to set, or where its file is of before their figures were kept.
        """
        check, first = self.rounded, self.scenes[0]
        if check is None or not check.feasible or check.totals is None or first.figures_as_set is None:
            return self
        scenes = [
            replace(
                one, settings=one.settings_to_set or one.settings, figures=one.figures_as_set or one.figures,
                margins=one.margins_as_set or one.margins,
            )
            for one in self.scenes
        ]  # fmt: skip
        return replace(self, objective_value=check.objective_value, totals=check.totals, scenes=scenes)

    @property
    def power_as_set_w(self) -> float | None:
        """Mean power [W] with the settings to set; with the exact ones where none are to set."""
        as_set = self.rounded.power_w if self.rounded is not None and self.is_settable else None
        return self.totals.power_w if as_set is None else as_set

    def as_system(self, *, to_set: bool = False) -> dict[str, Any]:
        """The keys of a system file that `evaluate` takes: parts by id, places, and the exact settings by scene.

        `to_set`: the settings to type in instead, where there are any.
        """
        made = self.hardware
        parts = {kind: part.id for kind, part in made.named.items()}
        places = [asdict(place) for place in made.light_mounts]
        spacer = {"spacer_mm": made.spacer_mm} if made.spacer_mm else {}
        return {
            **parts, **spacer, "camera_count": made.camera_count, "light_count": made.light_count,
            "orientation": made.orientation, **({"light_mounts": places} if places else {}),
            "scenes": {
                one.name: given_settings((to_set and one.settings_to_set) or one.settings) for one in self.scenes
            },
        }  # fmt: skip

    def margins_frame(self) -> "pd.DataFrame":
        """All margins as a table, one row a requirement and scene."""
        return frame_of({"margins": lambda: margin_rows(self)}, "margins")

    def figures_frame(self) -> "pd.DataFrame":
        """All figures as a table, one column a scene."""
        return frame_of({"figures": lambda: figure_rows(self)}, "figures").set_index("figure")

    def bom_frame(self) -> "pd.DataFrame":
        """The bill of materials as a table."""
        return frame_of({"bill": lambda: bill_rows(self)}, "bill")


def lamps_in_words(count: int, lamp: str, times: str = "x") -> str:
    """How many lamps of which kind, `2 x lamp`; without any `no lamp`, whatever stands for that."""
    return f"{count} {times} {lamp}" if count else "no lamp"


def given_settings(settings: Mapping[str, float | None]) -> dict[str, float]:
    """One scene's settings as a system file states them."""
    known = {key: value for key in STATED if (value := settings.get(key)) is not None}
    return {"focus_distance_m": FARTHEST_M, **known}
