"""What every part has, and what a kind of part brings along."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass as plain_dataclass
from dataclasses import field
from typing import Annotated, Any, ClassVar, Literal

from pydantic.dataclasses import dataclass

from uwopt.catalog.parts.cell import FROM_ZERO, POSITIVE, UNSEEN, Cell, Inline
from uwopt.catalog.parts.quantity import Known, Quantity

Kind = Literal["camera", "lens", "port", "light", "housing", "complete"]
KINDS: tuple[Kind, ...] = ("camera", "lens", "port", "light", "housing", "complete")
OF_A_DESIGN = KINDS[:4]  # each design has one of each; the port has its housing
Availability = Literal["current", "discontinued", "not_a_product", "unknown"]
PriceStatus = Literal["quoted", "derived", "estimated"]

MOUNT_NAMES = ("C", "CS", "S", "M12", "F", "EF", "MFT", "TFL", "TFL-II", "M42", "M58", "M72", "T2", "none")
MOUNTS = Cell("lens mounts", choices=MOUNT_NAMES, inline=Inline(unless="such as [C]"))
FORMAT = Cell("such as 2/3", inline="never")
RATED_TIME = Cell("hours under water up to which the depth rating holds; empty: any", POSITIVE, span=(1.0, 1e6))


@dataclass(frozen=True, slots=True)
class Part:
    """What every part has: identity, price, and where the facts come from."""

    part: ClassVar[Annotated[Kind, Cell("kind of part, where a file holds several kinds")]]
    id: Annotated[
        str, Cell("maker_model; never reused", needed=True, inline=Inline(doc="name of the part in results"))
    ]
    manufacturer: Annotated[str, Cell("maker of the part")] = ""
    model: Annotated[str, Cell("maker's name of the part")] = ""
    availability: Annotated[Availability, Cell(inline="never")] = "unknown"
    generic: Annotated[bool, UNSEEN] = False  # "to be made": no product, a class of parts
    inline: Annotated[bool, UNSEEN] = False  # from a system file: gaps are not checked
    complete: Annotated[str, UNSEEN] = ""  # the complete camera that it is a piece of; no other part goes with it
    price: Annotated[Known, Cell("price of one piece", FROM_ZERO, favours="low", at_most="price_high")] = None
    price_low: ClassVar[Annotated[float, Cell("", FROM_ZERO, at_most="price")]]
    price_high: ClassVar[Annotated[float, Cell("", FROM_ZERO)]]
    currency: Annotated[
        str, Cell("currency of the price, three letters", shown=False, inline=Inline(default="USD"))
    ] = "USD"
    price_date: Annotated[str, Cell("YYYY-MM-DD", inline="never")] = ""
    price_status: ClassVar[Annotated[PriceStatus, Cell("how the price is known")]]
    mass_g: Annotated[
        Known, Cell("mass of one piece in grams", FROM_ZERO, favours="low", at_most="mass_high_g")
    ] = None
    mass_low_g: ClassVar[Annotated[float, Cell("", FROM_ZERO, at_most="mass_g")]]
    mass_high_g: ClassVar[Annotated[float, Cell("", FROM_ZERO)]]
    source_url: Annotated[str, Cell("where the numbers are from", inline="never")] = ""
    checked: Annotated[str, Cell("YYYY-MM-DD on which the row was held against its source", inline="never")] = ""
    correction: Annotated[
        str, Cell("old value and reason, where a source was corrected", inline="never")
    ] = ""
    note: Annotated[str, Cell("remark")] = ""


#: The columns of a file begin with these; price, mass and sources end it.
OPENING = ("part", "id", "manufacturer", "model", "availability")


@plain_dataclass(frozen=True)
class PartKind:
    """One kind of part: its record, its files, an example row, and a part of it in a few words."""

    name: Kind
    record: type[Part]
    files: Mapping[str, Literal["published", "generic"]]  # built-in tables, and whether they hold products
    example: Mapping[str, str]
    summary: Callable[[Any], tuple[str, ...]]  # words of which the empty ones are left out
    inline_doc: str  # what an inline record of it is; empty where there is none
    pieces: Mapping[type[Part], frozenset[str]] = field(default_factory=dict)  # whose columns rows have, but for some


def marked_number(before: str, quantity: Quantity | None, after: str) -> str:
    """A quantity with its unit; `~` marks an estimate; empty when unknown."""
    if quantity is None:
        return ""
    number = f"{quantity.value:.3g}" if abs(quantity.value) < 1000.0 else f"{quantity.value:.0f}"
    return f"{before}{'~' if quantity.estimated else ''}{number}{after}"


def shown_depth(depth_rating_m: float | None, rated_time_h: float | None = None) -> str:
    """How deep a part may go, and for how long where that is limited; empty when unknown."""
    depth = "" if depth_rating_m is None else f"to {depth_rating_m:g} m"
    return depth if not depth or rated_time_h is None else f"{depth} for {rated_time_h:g} h"
