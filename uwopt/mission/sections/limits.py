"""What the system may cost, draw and weigh: the section `limits` of a mission."""

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from uwopt.documents.key_types import (
    CHOICE,
    NUMBER,
    NonNegative,
    Positive,
    Section,
)
from uwopt.mission import keys as words


class Limits(Section):
    """What the system may cost, draw and weigh; a key that is left out limits nothing."""

    cost: NonNegative | None = Field(
        default=None, description="highest cost of the whole system in limits.currency"
    )
    currency: Annotated[str, BeforeValidator(words.to_currency_code)] = Field(
        default="USD", description="currency of costs as three letters, such as USD"
    )
    rates: Annotated[dict[str, Positive], BeforeValidator(words.to_rates)] = Field(
        default_factory=dict,
        description="exchange rates by currency, USD per unit, that override the shipped ones",
    )
    cost_basis: Annotated[Literal["central", "high"], CHOICE] = Field(
        default="high",
        description="end of estimated prices that must be within the cost limit: high, or central (the likeliest); the "
        "objective cost is at the likeliest prices either way",
    )
    power_w: Positive | None = Field(default=None, description="highest mean electrical power in watts")
    peak_power_w: Positive | None = Field(
        default=None, description="highest electrical power at any moment in watts"
    )
    energy_wh: Positive | None = Field(
        default=None,
        description="most energy over vehicle.duration_h in watt-hours, scenes weighed by their time_share",
    )
    storage_gb: Positive | None = Field(
        default=None,
        description="most storage for images over vehicle.duration_h in gigabytes (10^9 byte), uncompressed",
    )
    mass_kg: Positive | None = Field(default=None, description="highest mass in kilograms")
    mass_water_kg: Annotated[float, Field(ge=-1e4, le=1e4), NUMBER] | None = Field(
        default=None,
        description="highest mass in water, in kilograms, of the cameras in their housings, lamps not counted; needs "
        "catalog.housing: required",
    )
    size_mm: Positive | None = Field(
        default=None,
        description="largest outer length or diameter of a housing with its port, in millimetres; needs "
        "catalog.housing: required",
    )
    diameter_mm: Positive | None = Field(
        default=None,
        description="largest outer diameter of a housing with its port, in millimetres, however long, as of a borehole "
        "or a hatch; needs catalog.housing: required",
    )
    depth_rating_m: Annotated[float, Field(ge=0, le=11_000), NUMBER] | None = Field(
        default=None,
        description="depth that ports and lights must be rated for, in metres, as it stands; the deepest scene "
        "with its reserve (reserve.depth) unless given",
    )
    data_rate_mb_s: Positive | None = Field(
        default=None, description="highest data rate in megabytes (10^6 byte) per second"
    )
    max_exposure_ms: Positive = Field(default=1000.0, description="longest exposure in milliseconds")
