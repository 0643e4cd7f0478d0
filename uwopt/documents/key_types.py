"""Field types of missions and systems: numbers that refuse units and NaN, shares, choices, ranges.

A type says what is wrong in words that fit behind `key = value`; `uwopt.documents.validation` adds file, line and
the way out. Nothing here knows a mission.
"""

import math
import re
from collections.abc import Mapping
from functools import partial
from typing import Annotated, Any, ClassVar, Literal, TypeVar

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    create_model,
    model_validator,
)
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

from uwopt.documents.faults import nearest, without_comma

_UNIT_TEXT = re.compile(r"\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*[^\d\s.,].*", re.DOTALL)
_PERCENT = re.compile(r"\s*([-+]?\d{1,9}\.?\d*)\s*%\s*")
SMALLEST = 1e-12  # of what may not be 0: products of a few such stay within what a float holds
_SPELLINGS = {"color": "colour", "monochrome": "mono", "grey": "mono", "highest": "high"}


FAULT, OUT_OF_REACH = "fault", "out_of_reach"  # no value of a key; one that is, but that nothing can meet


def refusal(what: str, mend: str = "", kind: Literal["fault", "out_of_reach"] = FAULT) -> PydanticCustomError:
    """The fault of one value: what is wrong with it, and how to mend it ("": say what the key holds)."""
    return PydanticCustomError(kind, "{what}", {"what": what, "mend": mend})


def to_number(value: Any) -> float:
    """A finite number; also from text such as `1e-3`, which YAML 1.1 leaves as text."""
    if isinstance(value, bool):
        raise refusal("is not a number")
    if isinstance(value, str):
        value = _number_from_text(value)
    if not isinstance(value, (int, float)):
        raise refusal("is not a number")
    try:
        number = float(value)
    except (OverflowError, ValueError):
        number = math.inf
    if math.isnan(number):
        raise refusal("is not a number (NaN)")
    if math.isinf(number):
        raise refusal("is not finite", "leave the key out where nothing limits it")
    return number


def _number_from_text(text: str) -> float | str:
    try:
        if "_" not in text:
            return float(text)
    except ValueError:
        pass
    if mend := without_comma(text):
        raise refusal("is not a number", mend)
    if percent := _PERCENT.fullmatch(text):
        raise refusal("is not a number", f"a share is written without sign: {float(percent[1]) / 100:g}")
    if _UNIT_TEXT.fullmatch(text):
        raise refusal("is not a number", "the unit belongs in the key, the value is a bare number")
    return text


def at_least(low: float) -> AfterValidator:
    """Validator of numbers above 0 that are no thing's below some other."""
    return AfterValidator(partial(_not_below, low=low))


def _not_below(value: float, low: float) -> float:
    if value < low:
        raise refusal(f"is below {low:g}", "check its unit")
    return value


def to_whole(value: Any) -> int:
    """A whole number; 3.0 counts as one."""
    number = to_number(value)
    if number != math.floor(number):
        raise refusal("is not a whole number")
    return value if isinstance(value, int) else int(number)


def to_text(value: Any) -> str:
    """One line of text; a bare number counts as its digits."""
    if isinstance(value, bool) or not isinstance(value, (str, int, float)):
        raise refusal("is not text", "put the text in quotes")
    text = str(value).strip()
    if not text:
        raise refusal("is empty")
    if len(text) > 300 or not text.isprintable():
        raise refusal("is not one line of at most 300 characters")
    return text


def to_texts(value: Any) -> Any:
    """A list of texts; one text counts as a list of one."""
    return [value] if isinstance(value, (str, int, float)) and not isinstance(value, bool) else value


def to_choice(value: Any) -> Any:
    """Spelling made plain before a choice is looked up."""
    if not isinstance(value, str):
        return value
    plain = value.strip().casefold()
    return _SPELLINGS.get(plain, plain)


def to_range(value: Any, low: float, high: float, whole: bool = False) -> tuple[float, float]:
    """A number or `[low, high]` as an ordered pair inside the allowed limits."""
    convert = to_whole if whole else to_number
    is_pair = isinstance(value, (list, tuple))
    if is_pair and len(value) != 2:
        raise refusal("is not a number or a range of two", "write [lowest, highest]")
    ends = tuple(convert(end) for end in value) if is_pair else (convert(value),) * 2
    if ends[0] > ends[1]:
        raise refusal("is not ordered", f"write [{ends[1]:g}, {ends[0]:g}]")
    if ends[0] < low or ends[1] > high:
        raise refusal(f"is outside {low:g} to {high:g}")
    return ends[0], ends[1]


def number_or_range(low: float, high: float) -> BeforeValidator:
    """Validator of a key that takes a number or a range; a number stays one."""

    def check(value: Any) -> float | tuple[float, float]:
        ends = to_range(value, low, high)
        return ends if isinstance(value, (list, tuple)) else ends[0]

    return BeforeValidator(check)


def whole_range(low: int, high: int) -> BeforeValidator:
    """Validator of a key that takes a count or a range of counts; always a pair afterwards."""
    return BeforeValidator(lambda value: to_range(value, low, high, whole=True))


def one_of(word: str, known: tuple[str, ...], hint: str = "") -> PydanticCustomError:
    """The fault of a word that is not among the known ones."""
    near = nearest(word, known, 0.5)
    mend = f"did you mean {near!r}?" if near else hint
    return refusal(f"is not one of {', '.join(known)}", mend)


NUMBER = BeforeValidator(to_number)
WHOLE = BeforeValidator(to_whole)
CHOICE = BeforeValidator(to_choice)

Positive = Annotated[float, Field(gt=0, le=1e12), at_least(SMALLEST), NUMBER]
NonNegative = Annotated[float, Field(ge=0, le=1e12), NUMBER]
Share = Annotated[float, Field(ge=0, le=1), NUMBER]
Count = Annotated[int, Field(ge=1, le=64), WHOLE]
Text = Annotated[str, BeforeValidator(to_text)]
Texts = Annotated[tuple[Text, ...], BeforeValidator(to_texts)]


class Section(BaseModel):
    """A mapping of a file: frozen, unknown keys are faults, an empty key takes its default."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)
    other_names: ClassVar[tuple[str, ...]] = ()  # by which a file may call some of its keys

    @model_validator(mode="before")
    @classmethod
    def _empty_keys_take_their_default(cls, data: Any) -> Any:
        if not isinstance(data, Mapping):
            return data
        return without_empty(data, cls)


def without_empty(data: Mapping[Any, Any], model: type[BaseModel]) -> dict[Any, Any]:
    """What a mapping of a file says; an empty key is left out where the default is something."""
    fields = keys_of(model)
    return {k: v for k, v in data.items() if v is not None or k not in fields or fields[k].default is None}


def keys_of(model: type[BaseModel]) -> dict[str, FieldInfo]:
    """Fields of a model by the key that a file uses."""
    return {info.alias or name: info for name, info in model.model_fields.items()}


def spelled_keys(model: type[BaseModel]) -> tuple[str, ...]:
    """Every name by which a file may give a key of a section."""
    return (*keys_of(model), *(model.other_names if issubclass(model, Section) else ()))


def given_values(section: BaseModel | None) -> dict[str, Any]:
    """What a file stated in a section, by key; defaults left out."""
    if section is None:
        return {}
    names = type(section).model_fields
    return {names[n].alias or n: getattr(section, n) for n in names if n in section.model_fields_set}


M = TypeVar("M", bound=BaseModel)


def all_optional(model: type[M], name: str) -> type[M]:
    """The same keys with the same checks, none of them required: what a scene may override."""
    fields: dict[str, Any] = {}
    for field_name, info in model.model_fields.items():
        inner: Any = Annotated[(info.annotation, *info.metadata)] if info.metadata else info.annotation  # pyrefly: ignore[not-a-type]
        fields[field_name] = (
            inner | None,
            Field(default=None, alias=info.alias, description=info.description),
        )
    made: Any = create_model(
        name, __base__=Section, __doc__=f"Keys of {model.__name__}, all optional.", **fields
    )
    made.other_names = model.other_names if issubclass(model, Section) else ()
    return made
