"""How certain a recommendation is to be, and what is uncertain beside the numbers of the parts."""

from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field
from pydantic_core import PydanticCustomError

from uwopt.documents.key_types import (
    CHOICE,
    WHOLE,
    Positive,
    Section,
    Share,
    number_or_range,
    one_of,
    refusal,
    to_number,
)

CENTRAL, ENDS = "central", "ends"
LEAST_CONFIDENCE, MOST_CONFIDENCE = 0.5, 0.99
OUTPUT = (0.85, 1.07)  # makers of LEDs state 7 % either way; warm and used they give less
FLOOR = (0.8, 1.25)
BEYOND_BAND = 0.25
FOCUS = (0.98, 1.02)  # what a tape and the target's place leave open; marks of a ring err more
FOCUS_PX = 1.0  # a blur disc that is seen on a screen beside none, pixel by pixel


def to_confidence(value: Any) -> Any:
    """A share from 0.5 to 0.99, or one of the words."""
    if isinstance(value, str) and value.strip().casefold() in (CENTRAL, ENDS):
        return value.strip().casefold()
    try:
        share = to_number(value.rstrip(" %") if isinstance(value, str) else value)
    except PydanticCustomError:
        raise one_of(str(value), (CENTRAL, ENDS), "or give a share such as 0.9") from None
    if LEAST_CONFIDENCE <= share <= MOST_CONFIDENCE:
        return share
    what = f"is not a share from {LEAST_CONFIDENCE:g} to {MOST_CONFIDENCE:g}"
    if 100.0 * LEAST_CONFIDENCE <= share <= 100.0 * MOST_CONFIDENCE:
        raise refusal(what, f"for {share:g} % write {share / 100.0:g}")
    raise refusal(what, f"or give {CENTRAL} (no doubt) or {ENDS} (the worst of all ends)")


Confidence = Annotated[float | Literal["central", "ends"], BeforeValidator(to_confidence)]


def about_one(value: Any) -> Any:
    """A range of factors that holds 1; a single number is no range."""
    if not isinstance(value, tuple):
        raise refusal("is no range", "give [least, most] about 1, such as [0.8, 1.25]")
    if not value[0] <= 1.0 <= value[1]:
        raise refusal("does not hold 1", "give factors about 1, such as [0.8, 1.25]")
    return value


Factors = Annotated[tuple[float, float], number_or_range(0.01, 100.0), AfterValidator(about_one)]


class Doubt(Section):
    """What scenarios draw: each number triangular over its low, central and high value."""

    parts: bool = Field(
        default=True, description="whether numbers of parts that are estimates are drawn: yes or no"
    )
    clarity: bool = Field(
        default=True, description="whether what a reading such as a visibility leaves open is drawn: yes or no"
    )
    lamp_leg: bool = Field(
        default=True,
        description="whether K from lamp to floor is drawn, by the share of scattered light that is lost: yes or no",
    )
    other_water_table: Share = Field(
        default=0.5, description="probability 0..1 that the other published table of the Jerlov types holds"
    )
    floor: Factors = Field(
        default=FLOOR, description="[least, most] factor on the reflectance of the floor, about 1; [1, 1]: it is known"
    )
    lamp_output: Factors = Field(
        default=OUTPUT,
        description="[least, most] factor on the light of a lamp as its maker states it, about 1; [1, 1]: it is known",
    )
    beyond_band: Share = Field(
        default=BEYOND_BAND,
        description="how far a vehicle that moves leaves its band of altitudes at most, as a share of "
        "altitude_tolerance_m; 0: never",
    )
    focus: Factors = Field(
        default=FOCUS,
        description="[least, most] factor on the distance at which the lens is focused before the port is sealed, "
        "about 1; [1, 1]: it is known",
    )
    focus_px: Positive = Field(
        default=FOCUS_PX,
        description="blur disc in pixels, at the lens's widest opening, that is seen when the lens is focused on a "
        "target: it stands no farther off than that at the ends of focus, where they allow more",
    )
    settings: Annotated[Literal["adapt", "fixed"], CHOICE] = Field(
        default="adapt",
        description="adapt: exposure, gain and light level are set once the water is seen; fixed: before, as f-number "
        "and focus are",
    )
    scenarios: Annotated[int, Field(ge=32, le=4096), WHOLE] = Field(
        default=256, description="number of scenarios that the search draws"
    )

    @property
    def none(self) -> Self:
        """The same settings where nothing is in doubt: every number at its central value."""
        known = {"parts": False, "clarity": False, "lamp_leg": False, "other_water_table": 0.0, "beyond_band": 0.0}
        return self.model_copy(update=known | dict.fromkeys(("floor", "lamp_output", "focus"), (1.0, 1.0)))
