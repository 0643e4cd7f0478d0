"""What is declared of a field of a part, next to its type, and what follows from it.

A field of a record carries a `Cell`: what the number means, what may stand in a file, between which numbers any
part lies, what favours a design, and how an inline record of a system file states it. A class variable with a
`Cell` is stated in files only: fields of the record are made from it.
"""

import math
import types
from dataclasses import MISSING, dataclass
from dataclasses import fields as dataclass_fields
from functools import cache, cached_property
from inspect import get_annotations
from typing import Any, ClassVar, Literal, Union, get_args, get_origin

from pydantic import GetCoreSchemaHandler
from pydantic_core import CoreSchema, core_schema

from uwopt.catalog.parts.quantity import Quantity, exact

Form = Literal["number", "text", "choice", "list", "flag"]

#: Of any number but 0: products of a few of the least stay within what a float holds.
SMALLEST, LARGEST = 1e-12, 1e12

#: Default of an inline key: what the record takes.
OF_RECORD = object()


@dataclass(frozen=True, slots=True)
class Range:
    """The numbers that may be stated; an open end is not one of them."""

    low: float = -math.inf
    high: float = math.inf
    open_low: bool = False
    open_high: bool = False

    def holds(self, value: float) -> bool:
        """Whether a number lies within."""
        above = value > self.low if self.open_low else value >= self.low
        return above and (value < self.high if self.open_high else value <= self.high)

    def words(self) -> str:
        """The range in words, such as `above 0 and at most 1`."""
        low = "" if self.low == -math.inf else f"{'above' if self.open_low else 'at least'} {self.low:g}"
        high = "" if self.high == math.inf else f"{'below' if self.open_high else 'at most'} {self.high:g}"
        return " and ".join(end for end in (low, high) if end)


ANY = Range()
POSITIVE = Range(0.0, open_low=True)
FROM_ZERO = Range(0.0)
SHARE = Range(0.0, 1.0)
POSITIVE_SHARE = Range(0.0, 1.0, open_low=True)


@dataclass(frozen=True, slots=True)
class Inline:
    """How an inline record states a field, where that differs from a file of parts.

    What it leaves out takes `default`; the record of a number that it leaves out holds `estimate`.
    """

    needed: bool = False
    default: Any = OF_RECORD
    estimate: Quantity | None = None
    unless: str = ""  # put behind the meaning: what is taken when the key is left out
    doc: str = ""  # instead of the meaning
    within: Range | None = None
    names: tuple[str, ...] = ()  # other names of the key
    type: Any = None  # instead of the type that the field's own tells


@dataclass(frozen=True, slots=True)
class Cell:
    """What is declared of a field, once; its name, its unit and its form stand in name and type."""

    doc: str = ""
    within: Range = ANY
    span: tuple[float, float] = (SMALLEST, LARGEST)  # of parts that can be made: outside, the unit is wrong
    #: Which end of an estimate favours a design; "either": that depends on the design; "": it enters no figure.
    favours: Literal["low", "high", "either", ""] = ""
    unknown: float = 0.0  # stands in the model's columns where nothing is known
    at_most: str = ""  # the field that must not be smaller
    choices: tuple[str, ...] = ()  # of a list; a choice's are those of its type
    form: Form | None = None  # where a file states it in another form than the record keeps
    needed: bool = False  # without it a row says nothing about a part
    tells: bool = False  # its mere presence in a header tells the kind of part
    in_files: bool = True
    inline: Inline | Literal["as in files", "never"] = "as in files"
    status: str = ""  # the field that says how this one is known
    shown: bool = True  # to people, in lists

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """A bare number is a quantity without doubt."""
        schema = handler(source)
        is_quantity = Quantity in get_args(source)
        return core_schema.no_info_before_validator_function(_quantity, schema) if is_quantity else schema


NEEDED = Inline(needed=True)
OR_ZERO = Inline(within=FROM_ZERO)  # where 0 may stand for next to nothing
MADE = Cell(in_files=False)  # by a kind's reader, from other fields
UNSEEN = Cell(in_files=False, shown=False)


def _quantity(value: Any) -> Any:
    return exact(float(value)) if isinstance(value, (int, float)) else value


@dataclass(frozen=True)
class Field:
    """A declared field: its name, its type, its default and its cell; what follows from its type is told once."""

    name: str
    type: Any
    cell: Cell
    kept: bool  # in the record; False: only in files
    default: Any = None

    @property
    def inline(self) -> Inline | None:
        """How an inline record states it; None where none does."""
        if isinstance(self.cell.inline, Inline):
            return self.cell.inline
        return Inline() if self.cell.inline != "never" and self.kept and self.cell.in_files else None

    @cached_property
    def bare_type(self) -> Any:
        """The type of what is stated: numbers for quantities, nothing optional."""
        inner = [item for item in get_args(self.type) if item is not type(None)]
        is_union = get_origin(self.type) in (Union, types.UnionType)
        bare = inner[0] if is_union else self.type
        return float if bare is Quantity else bare

    @cached_property
    def is_quantity(self) -> bool:
        """Whether the record keeps it with its doubt."""
        return Quantity in (self.type, *get_args(self.type))

    @property
    def form(self) -> Form:
        """What a cell of a file holds."""
        bare = self.bare_type
        by_type: dict[Any, Form] = {float: "number", int: "number", bool: "flag", str: "text"}
        if self.cell.form or bare in by_type:
            return self.cell.form or by_type[bare]
        return "choice" if get_origin(bare) is Literal else "list"

    @property
    def choices(self) -> tuple[str, ...]:
        """The words that may stand there."""
        return get_args(self.bare_type) if get_origin(self.bare_type) is Literal else self.cell.choices


def fields_of(record: type) -> tuple[Field, ...]:
    """The declared fields of a kind of part, those of its base first, each in its order."""
    known: Any = record  # a class can be hashed, whatever its instances can
    return _declared(known)


def kept_fields(record: type) -> tuple[Field, ...]:
    """The fields of a record, without what only files state."""
    known: Any = record
    return _kept(known)


@cache
def _kept(record: type) -> tuple[Field, ...]:
    return tuple(field for field in _declared(record) if field.kept)


@cache
def _declared(record: type) -> tuple[Field, ...]:
    defaults = {f.name: f.default for f in dataclass_fields(record)}
    hints = {n: hint for base in reversed(record.__mro__) for n, hint in get_annotations(base, eval_str=True).items()}
    return tuple(_field(name, hint, defaults.get(name, MISSING)) for name, hint in hints.items())


def _field(name: str, hint: Any, default: Any) -> Field:
    kept = get_origin(hint) is not ClassVar
    plain, cell = get_args(hint if kept else get_args(hint)[0])
    return Field(name, plain, cell, kept, None if default is MISSING else default)


def beyond(value: float, span: tuple[float, float]) -> str:
    """What is wrong with a number that no part has: `is below 0.05`; empty where nothing is.

    The span lies a hundred times beyond anything made: outside, the unit is wrong. Zero is left to the ranges.
    """
    least, most = span
    if value == 0.0 or least <= abs(value) <= most:
        return ""
    return f"is below {least:g}" if abs(value) < least else f"is above {most:g}"
