"""How certain it is that a system does what is asked, as results tell it."""

from pydantic import Field
from pydantic.dataclasses import dataclass

from uwopt.results.basis import Moved
from uwopt.results.record import RECORD, Flag, Number, Record, Whole


@dataclass(frozen=True, config=RECORD)
class LostTo(Record):
    """What is missed first where a system does not hold."""

    requirement: str = Field(description="rule or requirement; light: no settings give enough of it without too much")
    share: Number = Field(description="of the scenarios")


@dataclass(frozen=True, config=RECORD)
class CertaintyPoint(Record):
    """What a confidence costs."""

    confidence: Number = Field(description="share of the scenarios in which the hardware holds at least")
    objective_p50: Number = Field(description="median of the objective of the best hardware counted")
    hardware: list[str] = Field(description="its parts")
    held_again: Number | None = Field(
        default=None, description="share of further scenarios in which it holds, where these were to decide"
    )


@dataclass(frozen=True, config=RECORD)
class WorthKnowing(Record):
    """An uncertain number, and what it would be worth to know before buying."""

    what: str = Field(description="field of the part, or what of the water")
    part: str = Field(description="id of the part; empty where it is of none")
    worth: Number = Field(description="fall of the median of the objective, on average")


@dataclass(frozen=True, config=RECORD)
class Decides(Record):
    """An uncertain number on which it depends whether a system holds."""

    what: str = Field(description="field of the part, or what of the water")
    part: str = Field(description="id of the part; empty where it is of none")
    held_low: Number = Field(description="share of the scenarios that holds where it is low; of a choice, by the first")
    held_high: Number = Field(description="the same where it is high; by the other")


@dataclass(frozen=True, config=RECORD)
class WouldHold(Record):
    """Keys of which other values, all of them together, would let hardware hold as often as asked."""

    moves: list[Moved] = Field(description="the keys, with values that were counted")
    hardware: list[str] = Field(
        description="parts of what holds then, the lamps with their number; empty: what is recommended"
    )
    held: Number = Field(description="share of fresh scenarios in which it holds then")


@dataclass(frozen=True, config=RECORD)
class InVain(Record):
    """A key that was moved far, alone, which is not enough for what is recommended."""

    move: Moved = Field(description="the key, with the value that was counted")
    held: Number = Field(description="share of the scenarios that the choice was made on in which it holds then")


@dataclass(frozen=True, config=RECORD)
class Surest(Record):
    """Hardware that holds more often than what is recommended, but misses something at likeliest values."""

    hardware: list[str] = Field(description="its parts")
    held: Number = Field(description="share of the scenarios that the choice was made on in which it holds")
    misses: list[str] = Field(
        default_factory=list, description="requirement that it misses first with every estimate at its likeliest value"
    )


@dataclass(frozen=True, config=RECORD)
class CertaintyProof(Record):
    """Where all hardware went, of which none holds as often as asked and is better in half of the scenarios."""

    best_possible: Number | None = Field(
        description="no hardware that holds as often has a better median than this; null: none holds as often"
    )
    complete: Flag = Field(description="whether all hardware that may hold and be better was counted")
    combinations: Whole = Field(description="of all parts in the search")
    by_panel: Whole = Field(description="discarded: fail, or no better, where nothing is worse than in most of them")
    by_bounds: Whole = Field(description="discarded likewise by bounds in groups of scenarios of like water")
    counted: Whole = Field(description="counted in every scenario")
    left: Whole = Field(description="of which nothing is known but best_possible")
    argued: list[str] = Field(
        default_factory=list,
        description="what its bounds rest on that is argued and held against counts, not strict; none: all is",
    )

    def adds_up(self) -> bool:
        """Whether every combination is accounted for once."""
        return self.combinations == self.by_panel + self.by_bounds + self.counted + self.left


@dataclass(frozen=True, config=RECORD)
class FixedSettings(Record):
    """What is set in one scene before the water is seen, and left so in all scenarios."""

    scene: str = Field(description="name of the scene")
    light_level: Number = Field(description="of the lamps, a share of full")
    light_time_ms: Number = Field(description="that collects light: exposure, or pulse")
    gain_db: Number = Field(description="of the camera")


@dataclass(frozen=True, config=RECORD)
class Confidence(Record):
    """In how many scenarios of what is uncertain a system holds, and with which objective."""

    asked: Number | str = Field(description="share of the scenarios, or ends: the worst of all ends")
    enough: Flag = Field(description="whether it holds as often as asked")
    held: Number = Field(description="share of the scenarios in which settings meet every requirement")
    held_low: Number = Field(description="low end of that share, with 95 % confidence (Wilson)")
    held_high: Number = Field(description="high end of it")
    scenarios: Whole = Field(description="in which it was counted: of solve fresh ones, unless time was short (fresh)")
    held_in_choice: Number = Field(description="share of the scenarios that the choice was made on")
    scenarios_in_choice: Whole = Field(description="how many those are")
    objective_p50: Number | None = Field(description="kept or bettered in half of them; null: not held in as many")
    objective_p90: Number | None = Field(description="kept or bettered in nine of ten; null: not held in as many")
    f_number: Number | None = Field(description="where the iris stands in all of them; null: moved at sea")
    lost_to: list[LostTo] = Field(description="what is missed where it does not hold, the most frequent first")
    price_p50: Number | None = Field(
        default=None, description="of all that is to buy, in the mission's currency: in half of them no more; null: "
        "where the worst of all ends is asked for"
    )
    central_objective: Number | None = Field(
        default=None, description="best objective with every estimate at its likeliest value"
    )
    central_hardware: list[str] = Field(default_factory=list, description="the hardware that reaches it")
    central_held: Number | None = Field(default=None, description="share of the choice's scenarios in which that holds")
    central_p50: Number | None = Field(default=None, description="objective that it keeps or betters in half of those")
    p50_in_choice: Number | None = Field(
        default=None, description="the same of what is recommended: kept or bettered in half of the choice's scenarios"
    )
    fixed: list[FixedSettings] = Field(
        default_factory=list, description="by scene what is set before the water is seen; none: set once it is seen"
    )
    counted: Whole = Field(default=1, description="hardware whose outcomes were counted in every scenario")
    fresh: Flag = Field(default=True, description="whether the choice has not seen these scenarios")
    complete: Flag = Field(default=True, description="whether there was time for all of it")
    proof: CertaintyProof | None = Field(
        default=None, description="that no other hardware holds as often and is better; null: not proven"
    )
    curve: list[CertaintyPoint] = Field(default_factory=list, description="what confidence costs, from 0.5 to 0.99")
    ask_first: list[WorthKnowing] = Field(
        default_factory=list, description="what would be worth knowing before buying, the most first"
    )
    decided_by: list[Decides] = Field(
        default_factory=list, description="on what it depends most whether it holds; none where luck does as well"
    )
    would_hold: list[Moved] = Field(
        default_factory=list, description="keys of which less would let it hold as often as asked, each moved alone"
    )
    would_hold_else: list[WouldHold] = Field(
        default_factory=list,
        description="where no key moved alone is enough: keys that are together; where none are, other hardware that "
        "would hold with one key moved; where none does, other hardware that would with a limit raised",
    )
    in_vain: list[InVain] = Field(
        default_factory=list, description="where no key moved alone is enough: what each of them comes to"
    )
    beyond_limits: Number | None = Field(
        default=None,
        description="greatest share in which anything holds that was counted with all limits on cost, power and the "
        "like four times as far; null: not looked for, or something holds as often as asked then",
    )
    surest: Surest | None = Field(
        default=None,
        description="of what was counted, what holds more often where nothing holds as often as asked, though it "
        "misses a requirement with every estimate at its likeliest value, so that there are no settings to tell; null: "
        "none does",
    )
    drawn: list[str] = Field(default_factory=list, description="what the scenarios draw, in words")
