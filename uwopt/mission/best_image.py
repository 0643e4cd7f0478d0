"""The objective `best_image`: which quality it is of, and what a watt and 100 USD must buy of it."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BaseModel, Field, ValidationError

from uwopt.documents.faults import nearest, plain_name
from uwopt.documents.key_types import CHOICE, NUMBER, Section, keys_of, refusal
from uwopt.mission.keys import BEST_IMAGE, to_objective

if TYPE_CHECKING:
    from uwopt.mission.mission import Mission

NAME = BEST_IMAGE
Gain = Annotated[float, Field(ge=0, le=10), NUMBER]


class BestImage(Section):
    """The knee: where one more watt or 100 USD more buy less than these gains."""

    of: Annotated[Literal["auto", "information", "snr"], CHOICE] = Field(
        default="auto",
        description="quality of the image: information (bit per square metre of floor), snr where no texture is "
        "wanted, or auto, information where it can be asked",
    )
    per_w: Gain = Field(
        default=0.01, description="share by which one more watt must better the quality, such as 0.01; 0: power is free"
    )
    per_100_usd: Gain = Field(
        default=0.01, description="share by which 100 USD more must better the quality, such as 0.01; 0: money is free"
    )


class BestImageGoal(Section):
    """The objective `best_image` with its gains."""

    best_image: BestImage = Field(
        default_factory=BestImage, description="quality (of) and the gains per_w and per_100_usd that end at the knee"
    )


def why_no_information(mission: "Mission") -> list[str]:
    """What keeps a mission from asking for information; nothing where it may."""
    if mission.physics == "paper":
        return ["information needs sharpness, which physics paper does not know; use auto or full"]
    return [
        "information grows without end as the image shrinks; add requirements.min_swath_m, or an overlap at speed, "
        f"in scene {view.scene.name!r}"
        for view in mission.views
        if view.requirements.min_swath_m is None
        and (view.vehicle.speed_m_s == 0 or view.requirements.overlap is None)
    ]


def to_goal(value: Any) -> Any:
    """The best image with its gains, the name of a figure, or weights by name."""
    if isinstance(value, BestImageGoal):
        return value
    named = {plain_name(str(key)): given for key, given in value.items()} if isinstance(value, Mapping) else {}
    if NAME in named:
        if len(named) > 1:
            other = next(name for name in named if name != NAME)
            mend = f"it has prices of power and cost: {{{NAME}: {{per_w: 0.01}}}}"
            raise refusal(f"weighs {NAME} with {other}", mend)
        return BestImageGoal(best_image=_gains(named[NAME]))
    if isinstance(value, str) and plain_name(value) == NAME:
        return BestImageGoal()
    return to_objective(value)


def _gains(given: Any) -> BestImage:
    """The keys below `best_image`; the first fault names its key."""
    if given is None:
        return BestImage()
    if isinstance(given, BestImage):
        return given
    if not isinstance(given, Mapping):
        raise refusal(f"gives {NAME} no keys", f"write {{{NAME}: {{per_w: 0.01, per_100_usd: 0.01}}}}")
    try:
        return BestImage.model_validate(dict(given))
    except ValidationError as error:
        detail = error.errors(include_url=False)[0]
        raise refusal(*_fault_of(BestImage, str(detail["loc"][0]))) from None


def _fault_of(model: type[BaseModel], key: str) -> tuple[str, str]:
    """What is wrong with one key of a mapping that stands in one value, and how to mend it."""
    known = keys_of(model)
    if key not in known:
        near = nearest(key, known)
        return f"holds {key}, which is no key of {NAME}", f"did you mean {near}?" if near else "see `uwopt schema`"
    return f"has a wrong {key}", f"give the {known[key].description}"
