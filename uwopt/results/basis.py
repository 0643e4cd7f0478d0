"""What a result rests on: objective, physics, assumptions; what stood in the way of others, or of all."""

from typing import Any

from pydantic import Field
from pydantic.dataclasses import dataclass

from uwopt.results.design import Design
from uwopt.results.record import RECORD, Flag, Number, Record, Whole


@dataclass(frozen=True, config=RECORD)
class ObjectiveValue(Record):
    """What was to be best, and what it came to."""

    name: str = Field(description="a term, or terms with their weights")
    direction: str = Field(description="minimise | maximise")
    value: Number | None = Field(description="of the best design; null without one")
    unit: str = Field(description="of the value")


@dataclass(frozen=True, config=RECORD)
class Opinion(Record):
    """What another solver finds for the settings of one hardware; null and 0 where it does not tell."""

    method: str = Field(description="solver, or algorithm of NLopt")
    hardware: list[str] = Field(default_factory=list, description="camera, lens, port and light by id")
    status: str = Field(
        default="not applicable", description="optimal | feasible | infeasible | failed | not applicable"
    )
    objective_value: Number | None = Field(default=None, description="of the settings that it found")
    difference_rel: Number | None = Field(default=None, description="from the search's value, a share")
    agrees: Flag = Field(default=False, description="whether that is no more than rounding")
    max_violation: Number | None = Field(default=None, description="of the rule that is missed most, a share")
    kkt_residual: Number | None = Field(default=None, description="how nearly the conditions of an optimum hold")
    multipliers: dict[str, Number | None] = Field(default_factory=dict, description="of rules that bind")
    iterations: Whole = Field(default=0, description="or nodes")
    run_time_s: Number = Field(default=0.0, description="of this solver")
    message: str = Field(default="", description="its own words")


@dataclass(frozen=True, config=RECORD)
class UsedEffect(Record):
    """A part of the physics that a scene may not need."""

    name: str = Field(description="as in the list of effects")
    bound: Number | None = Field(description="most that it changes, a share; null: a requirement asks for it")
    kept: Flag = Field(description="whether the model has it here")
    time_saved_s: Number = Field(description="by leaving it out, estimated")


@dataclass(frozen=True, config=RECORD)
class UsedWater(Record):
    """The water that a reading was taken for."""

    scene: str = Field(description="name of the scene")
    key: str = Field(description="c_per_m | visibility_m | secchi_m | turbidity_ntu")
    given: Number = Field(description="the reading, in the key's unit")
    c_per_m: Number = Field(description="beam attenuation at 530 nm that was taken")
    c_low_per_m: Number = Field(description="the same of the clearest water that the reading leaves open")
    c_high_per_m: Number = Field(description="the same of the murkiest")
    water: str = Field(description="what it is made of")
    source: str = Field(description="the relation and where it was published")
    advice: str = Field(description="what is measured best")


@dataclass(frozen=True, config=RECORD)
class UsedPhysics(Record):
    """Which physics, how finely, and what it leaves out."""

    name: str = Field(description="auto | full | paper")
    asked: str = Field(description="what the mission or the call asked for")
    tolerance: Number = Field(description="of effects that may be left out, a share")
    fineness: dict[str, Number] = Field(description="factor on the nodes of every integral")
    water_table: str | dict[str, str] = Field(description="of all scenes, or by scene where they differ")
    effects: list[UsedEffect] = Field(description="those that a scene may not need")
    not_modelled: list[str] = Field(description="what no physics of this program has")
    waters: list[UsedWater] = Field(default_factory=list, description="those that were made from a reading")


@dataclass(frozen=True, config=RECORD)
class Assumption(Record):
    """Something that is not known, and what was taken for it."""

    path: str = Field(description="the field, or the scene's key")
    part: str = Field(description="id of the part; empty where it is of none")
    value: Any = Field(description="what was taken")
    low: Number | None = Field(description="low end of an estimated number")
    high: Number | None = Field(description="high end of an estimated number")
    unit: str = Field(description="of the numbers")
    status: str = Field(description="estimated | assumed | ...")
    source: str = Field(description="why it was taken")


#: Why what a given system misses is a risk; a page that lists what is missed leaves these out of its risks.
MISSED, MISSED_OF_PRACTICE = "the requirement is missed", "what the mission itself says is met"


@dataclass(frozen=True, config=RECORD)
class Risk(Record):
    """What may go wrong with a system."""

    what: str = Field(description="in a few words")
    because: str = Field(description="why; empty where it needs no reason")
    figure: str = Field(description="how much, with its unit; empty where there is no number")


@dataclass(frozen=True, config=RECORD)
class Bought(Record):
    """What a little more power or money would buy of the image's quality."""

    name: str = Field(description="power_w | cost")
    more: Number = Field(description="how much more than the best system's")
    unit: str = Field(description="of it: W or the currency")
    gain: Number = Field(description="share by which the best system within it is better; 0: none is")
    hardware: dict[str, str] = Field(description="ids of that system by kind; empty where none is better")
    beyond_limit: Flag = Field(description="whether the mission's limit would have to be raised for it")


@dataclass(frozen=True, config=RECORD)
class Knee(Record):
    """Where the best image stands between its quality and its price."""

    quality: str = Field(description="information | snr")
    value: Number = Field(description="of the quality, by exact settings; snr as a ratio")
    unit: str = Field(description="of the value")
    per_w: Number = Field(description="share that a watt must buy")
    per_100_usd: Number = Field(description="share that 100 USD must buy")
    bought: list[Bought] = Field(description="what a watt and 100 USD more would buy")


AS_EVEN = 0.9  # of the darkest place's share of the mean light: what is less is seen


@dataclass(frozen=True, config=RECORD)
class LessMoney(Record):
    """A system that costs much less than the best and is little worse; by medians where scenarios were counted."""

    hardware: dict[str, str] = Field(description="its ids by kind")
    light_count: Whole = Field(description="how many lamps it has")
    price: Number = Field(description="sum of the likeliest prices, or the median of it over the scenarios")
    price_of_best: Number = Field(description="the same of the best system")
    currency: str = Field(description="of the prices")
    value: Number = Field(description="of the objective, by exact settings, or its median")
    value_of_best: Number = Field(description="the same of the best system")
    uniformity: Number | None = Field(
        default=None, description="darkest place of the lit target over its mean, in the worst scene; null: no lamps"
    )
    held: Number | None = Field(default=None, description="share of the choice's scenarios; null: none were counted")
    cost_limit: Number | None = Field(
        default=None, description="limits.cost that lets it through; null where scenarios were counted"
    )

    def is_less_even(self, uniformity: float | None) -> bool:
        """Whether its darkest place gets less of the mean light than that of another system, by a tenth or more."""
        return self.uniformity is not None and uniformity is not None and self.uniformity < AS_EVEN * uniformity


@dataclass(frozen=True, config=RECORD)
class Excluded(Record):
    """What a rule keeps from being a solution."""

    name: str = Field(description="the rule")
    n_excluded: Whole = Field(description="combinations that it discards first")
    n_is_bound: Flag = Field(description="proven by a bound, before the settings were looked at")


@dataclass(frozen=True, config=RECORD)
class Relaxed(Record):
    """A requirement whose change alone would let a system through."""

    name: str = Field(description="the requirement")
    limit: Number | None = Field(description="what is asked")
    needed: Number | None = Field(description="what could be had; null: it would have to be left out")
    miss_rel: Number = Field(description="how far apart the two are; large where that is not known")
    fits_at_central_prices: Flag = Field(
        default=False, description="a limit of cost that a system keeps unless its prices turn out high"
    )
    nearest: Flag = Field(
        default=False, description="whether nothing fits where this alone gives a little less; false: not known"
    )
    gives_up: list[str] | None = Field(
        default=None,
        description="what of good practice has to be relaxed too, with what is held instead, where that was in vain; "
        "null: not looked for",
    )


@dataclass(frozen=True, config=RECORD)
class NoHelp(Record):
    """A requirement or key of which it is known that it alone does not help, and why not."""

    name: str = Field(description="the requirement, or the key that was moved")
    still: list[str] = Field(description="rules that still stand in the way without it: by which most fall first")


@dataclass(frozen=True, config=RECORD)
class Lacking(Record):
    """A size that stops a fit."""

    name: str = Field(
        description="housing_diameter_mm | housing_length_mm | tube_mouth_mm | dome_radius_mm | port_width_mm"
    )
    needed_mm: Number = Field(description="what the parts need")
    room_mm: Number = Field(description="what there is")


@dataclass(frozen=True, config=RECORD)
class NearestFit(Record):
    """What comes nearest to fitting into a housing, where nothing does."""

    hardware: dict[str, str] = Field(description="ids by kind; empty where no housing is made for any of the ports")
    lacking: list[Lacking] = Field(description="sizes that are too small, most missing first")


@dataclass(frozen=True, config=RECORD)
class TooShallow(Record):
    """Parts of a kind that are left out for their depth rating alone."""

    needed_m: Number = Field(description="depth for which parts must be rated, reserve included")
    unrated: Whole = Field(description="number of them of which no rating is known; the others are rated for less")
    deepest: str = Field(description="id of the one that is rated deepest; empty where no rating is known")
    deepest_m: Number | None = Field(description="what that is rated for")


@dataclass(frozen=True, config=RECORD)
class NoneLeft(Record):
    """A kind of part of which a mission's choice leaves none, whatever else is asked."""

    kind: str = Field(description="camera, lens, port, light or housing")
    reasons: dict[str, str] = Field(
        description="why each is left out, by id: a few parts that the mission names; else those rated deep enough"
    )
    by_rule: dict[str, Whole] = Field(
        default_factory=dict, description="number of parts that each rule leaves out first: all of them together"
    )
    too_shallow: TooShallow | None = Field(
        default=None, description="those that the rule on depth ratings leaves out; null: none"
    )


@dataclass(frozen=True, config=RECORD)
class Price(Record):
    """What a step more of one requirement, or of the speed, costs."""

    name: str = Field(description="the key")
    unit: str = Field(description="of what is asked, and of the step")
    asked: Number = Field(description="by the mission")
    step: Number = Field(description="that asks for more; negative of a limit from above")
    change: Number | None = Field(description="of the objective, as it is reported; null: the system no longer fits")
    slope: Number | None = Field(default=None, description="per unit of what is asked, there, by a central difference")
    slope_casadi: Number | None = Field(default=None, description="the same by the multiplier of CasADi's program")
    until: Number | None = Field(default=None, description="value up to which the system stays the best, if searched")
    then: str = Field(default="", description="the system that takes over there; empty: nothing fits")
    free_until: Number | None = Field(
        default=None, description="value up to which it costs nothing, as the system reaches it so; null: it binds"
    )
    without: Number | None = Field(
        default=None, description="objective of the best system where it is not asked for, if searched"
    )


@dataclass(frozen=True, config=RECORD)
class Moved(Record):
    """A key of the mission, no requirement, whose move alone would let a system through."""

    name: str = Field(description="the key, such as speed_m_s, water, duration_h or camera_between_images")
    asked: Number | str = Field(description="where it stands")
    needed: Number | str = Field(description="where something fits, which has been solved")
    unit: str = Field(description="of both; empty for words")
    nearest: Flag = Field(description="whether nothing fits a little nearer to what is asked")
    gives_up: list[str] | None = Field(
        default=None,
        description="what of good practice has to be relaxed too, with what is held instead, where that was in vain; "
        "null: not looked for",
    )


@dataclass(frozen=True, config=RECORD)
class WhyNothing(Record):
    """Why no system fits, and what would help."""

    requirements: list[Excluded] = Field(description="rules in their order")
    relaxations: list[Relaxed] = Field(description="the smallest change first")
    nearest_miss: Design | None = Field(
        description="the design of the smallest change, by the mission as it stands"
    )
    together: list[Relaxed] = Field(
        default_factory=list,
        description="changes that help together: where none but clearer water does alone those of which all are needed "
        "at once, else each a smaller share of what is asked than any that does",
    )
    nearest_fit: NearestFit | None = Field(
        default=None,
        description="where nothing that meets the rest so far fits into any housing; null: that does not stop it",
    )
    none_left: list[NoneLeft] = Field(
        default_factory=list, description="kinds of parts of which none is left, and not for depth alone"
    )
    moves: list[Moved] = Field(
        default_factory=list, description="keys that are no requirements, of which one moved alone would help"
    )
    contradiction: list[str] = Field(
        default_factory=list,
        description="requirements that contradict each other: nothing fits where these alone are asked, and something "
        "does without any of them; empty where that is not known",
    )
    contradiction_is_least: Flag = Field(
        default=False, description="whether that something fits without any one of those is known of each"
    )
    no_help: list[NoHelp] = Field(
        default_factory=list, description="requirements and keys that alone do not help, however far they give"
    )
    not_known: list[str] = Field(
        default_factory=list, description="requirements and keys of which there was no time to know whether they help"
    )
    in_part: dict[str, int] = Field(
        default_factory=dict,
        description="of these requirements, without which systems were looked at in vain before time ended: how many",
    )
    unmet: list[str] = Field(
        default_factory=list,
        description="requirements that nothing meets even where no other is asked, as the scene and the vehicle are: "
        "each has to give",
    )


@dataclass(frozen=True, config=RECORD)
class OtherMaker(Record):
    """What a maker has to offer none of whose parts is shown."""

    kind: str = Field(description="camera | light")
    maker: str = Field(description="as the catalogue names it")
    hardware: dict[str, str] | None = Field(default=None, description="ids by kind of its best system")
    values: dict[str, Number] = Field(default_factory=dict, description="of the objectives, in their units")
    outcome: str = Field(default="infeasible", description="worse | dominated | infeasible | not allowed")
    by: str | None = Field(default=None, description="the point of a front that dominates it")
    rule: str | None = Field(default=None, description="the last obstacle, where nothing fits")
    text: str = Field(default="", description="why it was not chosen")
