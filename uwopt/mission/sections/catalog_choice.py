"""Which parts may be used, and what else is bought: the section `catalog` of a mission."""

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from uwopt.documents.key_types import (
    CHOICE,
    WHOLE,
    NonNegative,
    Section,
    Text,
    Texts,
)
from uwopt.mission import keys as words


class OwnedPart(Section):
    """A part that is already there and costs nothing."""

    id: Text = Field(description="id of a part of the catalogue")
    quantity: Annotated[int, Field(ge=0, le=1000), WHOLE] = Field(
        default=1, description="number of pieces at hand"
    )


class Extra(Section):
    """Something that every system needs besides its parts: housing, cables, computer."""

    name: Text = Field(description="name of the item")
    cost: NonNegative = Field(default=0.0, description="cost in limits.currency")
    mass_kg: NonNegative = Field(default=0.0, description="mass in kilograms")
    power_w: NonNegative = Field(default=0.0, description="electrical power in watts")


class CatalogChoice(Section):
    """Which parts may be used; patterns are globs or plain parts of an id or a manufacturer."""

    cameras: Texts = Field(default=(), description="patterns of cameras that may be used; none allows all")
    lenses: Texts = Field(default=(), description="patterns of lenses that may be used; none allows all")
    ports: Texts = Field(default=(), description="patterns of ports that may be used; none allows all")
    lights: Texts = Field(default=(), description="patterns of lights that may be used; none allows all")
    housings: Texts = Field(default=(), description="patterns of housings that may be used; none allows all")
    complete_cameras: Texts = Field(
        default=(), description="patterns of complete cameras that may be used; none allows all"
    )
    exclude: Texts = Field(default=(), description="patterns of parts that must not be used")
    files: Texts = Field(
        default=(),
        description="CSV or YAML files of own parts, or of changes to the catalogue, relative to the mission file",
    )
    prices: Text | None = Field(
        default=None, description="CSV of own quotes that override prices, relative to the mission file"
    )
    owned: Annotated[tuple[OwnedPart, ...], BeforeValidator(words.to_owned)] = Field(
        default=(), description="list of parts already there, each {id, quantity}"
    )
    generic: Annotated[Literal["fallback"] | words.Made, BeforeValidator(words.to_generic)] = Field(
        default="fallback",
        description="use of generic parts, which no shop sells as such and which have to be made: fallback takes those "
        "of as few kinds as come within 10 % of all, lamps last, where nothing sold fits; allow, never, or a list of "
        "the kinds that may be made: housing, port, light",
    )
    verified: Annotated[tuple[str, ...], BeforeValidator(words.to_part_fields)] = Field(
        default=(), description="list of part fields that must come from a source, such as price"
    )
    accept_unrated: Texts = Field(
        default=(), description="ids of parts whose unknown depth rating is accepted"
    )
    port_mounts: Texts = Field(
        default=(),
        description="mounts of ports, such as nauticam-n120, for which a housing or an adapter is to hand; ports that "
        "fit only their maker's housings are left out otherwise",
    )
    lens_rating: Annotated[Literal["warn", "limit"], CHOICE] = Field(
        default="warn",
        description="what a lens rated for larger pixels than the camera's is: warn tells of it, limit refuses it",
    )
    interfaces: Annotated[tuple[str, ...], BeforeValidator(words.to_interfaces)] = Field(
        default=(),
        description="interfaces that the host has, such as [USB3, GigE]; cameras of another, or of an unknown one, "
        "are left out; none allows all",
    )
    availability: Annotated[Literal["any", "known"], CHOICE] = Field(
        default="any",
        description="parts of which nobody says whether they are still sold: any lets them in, known leaves them out",
    )
    host: Annotated[Literal["none", "estimate"], CHOICE] = Field(
        default="none",
        description="the computer that takes the images: none leaves it out, estimate (recommended, unless it is among "
        "the extras) counts power and cost by the camera's interface",
    )
    rest: Annotated[Literal["none", "estimate"], CHOICE] = Field(
        default="none",
        description="the rest that every system needs: none leaves it out, estimate (recommended, unless there are "
        "extras) counts connectors and cables by depth, trigger electronics, a battery of its own, spares and a "
        "pressure test in the cost",
    )
    housing: Annotated[Literal["none", "required"], CHOICE] = Field(
        default="none",
        description="housing of each port: none leaves it out, required (recommended, unless it is among the extras) "
        "chooses one that takes port, camera and lens, and counts its depth rating, cost and mass",
    )
    spacers: Annotated[Literal["none", "allow"], CHOICE] = Field(
        default="none",
        description="spacer rings between lens and camera, on which it focuses nearer: none leaves them out, allow "
        "(recommended) takes the shortest that the focus needs, and counts its price",
    )
    complete: Annotated[Literal["none", "also", "only"], BeforeValidator(words.to_complete), CHOICE] = Field(
        default="none",
        description="complete cameras, which are bought with lens and port in one housing: none leaves them out, also "
        "(or true) searches them beside the assembled ones, only searches nothing else",
    )
    extras: tuple[Extra, ...] = Field(
        default=(), description="list of items added to every system: {name, cost, mass_kg, power_w}"
    )

    @property
    def generic_at_first(self) -> words.Made:
        """The parts to be made that a search may use at first: none where they only step in."""
        return "never" if self.generic == "fallback" else self.generic

    @property
    def generic_at_last(self) -> words.Made:
        """The parts to be made that may be used where nothing else does."""
        return "allow" if self.generic == "fallback" else self.generic
