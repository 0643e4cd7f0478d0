"""Parts written into a system file: what they may hold, made from the fields of the records they become.

An inline part states only what the model uses; the keys are the fields of the records, as bare numbers.
What it leaves out is not checked against anything (`inline=True`), and these defaults stand in for it:

    camera  12 bits, global shutter, mono; gain unknown: full scale at saturation; up to 48 dB of gain
    lens    F1.4 to F16, 90 % transmission (80 to 100 %)
    port    index 1.5, 10 mm thick
    housing no wall: as wide outside as inside
    light   continuous, all nameplate lumens leave the window (output_factor 1), generic white LED
"""

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic import Field as Key
from pydantic import ValidationError, ValidationInfo, create_model, field_validator, model_validator

from uwopt.catalog.parts.agreement import FAULTS
from uwopt.catalog.parts.cell import ANY, OF_RECORD, Field, Inline, Range, beyond, fields_of
from uwopt.catalog.parts.kinds import PARTS
from uwopt.catalog.parts.part import Kind, Part
from uwopt.documents.key_types import CHOICE, NUMBER, SMALLEST, WHOLE, Section, Text, Texts, at_least, refusal
from uwopt.errors import CatalogError

MOST = 1e12  # of a number that nothing else bounds


@cache
def inline_keys(kind: Kind) -> dict[str, tuple[Field, Inline]]:
    """The fields that an inline record of this kind may state, by name."""
    return {f.name: (f, f.inline) for f in fields_of(PARTS[kind].record) if f.inline is not None}


#: Kinds of which a system file may write a part of its own.
INLINE_KINDS: tuple[Kind, ...] = tuple(kind for kind, part in PARTS.items() if part.inline_doc)

#: Other names that an inline record may use, by kind.
SYNONYMS: dict[str, dict[str, str]] = {
    kind: {other: name for name, (_, inline) in inline_keys(kind).items() for other in inline.names}
    for kind in INLINE_KINDS
}


class InlinePart(Section):
    """What any inline part may hold; the keys of each kind are made from its record."""

    part_kind: ClassVar[Kind]

    @field_validator("*")
    @classmethod
    def _of_a_part(cls, value: Any, info: ValidationInfo) -> Any:
        if not isinstance(value, (int, float)) or isinstance(value, bool):
            return value
        field, _ = inline_keys(cls.part_kind)[info.field_name or ""]
        if fault := beyond(float(value), field.cell.span):
            raise refusal(f"{fault}, as none is made", "check its unit")
        return value

    @model_validator(mode="before")
    @classmethod
    def _one_name_a_key(cls, data: Any) -> Any:
        return renamed(cls.part_kind, data)


def renamed(kind: str, data: Any) -> Any:
    """An inline record with its synonyms under their own names."""
    if not isinstance(data, Mapping):
        return data
    plain = dict(data)
    for other, name in SYNONYMS[kind].items():
        if other in plain:
            if plain.get(name) is not None:
                raise refusal(f"holds both {other} and {name}", "keep one of them")
            plain[name] = plain.pop(other)
    return plain


def _model(kind: Kind) -> type[InlinePart]:
    """The model of an inline record: a key for each field that one may state."""
    keys: dict[str, Any] = {name: _key(field, inline) for name, (field, inline) in inline_keys(kind).items()}
    name, doc = f"Inline{kind.capitalize()}", PARTS[kind].inline_doc
    model = create_model(name, __base__=InlinePart, __doc__=doc, __module__=__name__, **keys)
    model.part_kind = kind
    return model


def _key(field: Field, inline: Inline) -> tuple[Any, Any]:
    """Type and default of a key."""
    meaning = inline.doc or field.cell.doc
    if inline.unless:
        meaning += inline.unless if inline.unless.startswith(";") else f", {inline.unless}"
    value_type = inline.type or _type_of(field, inline)
    if inline.needed:
        return value_type, Key(description=meaning)
    default = inline.default
    if default is OF_RECORD:
        default = None if field.bare_type is str else field.default
    return (value_type if default is not None else value_type | None), Key(default, description=meaning)


def _type_of(field: Field, inline: Inline) -> Any:
    bare = field.bare_type
    if field.form == "text":
        return Text
    if get_origin(bare) is Literal:
        return Annotated[bare, CHOICE]
    if field.form == "list":
        return Texts
    return _number_type(inline.within or field.cell.within, whole=bare is int)


def _number_type(within: Range, *, whole: bool) -> Any:
    bounds: list[Any] = []
    if within != ANY:
        low, high = _bound(within.low), _bound(min(within.high, MOST))
        bounds = [Gt(low) if within.open_low else Ge(low), Lt(high) if within.open_high else Le(high)]
        bounds += [at_least(SMALLEST)] if within.open_low and within.high > MOST else []
    return Annotated[(int if whole else float, *bounds, WHOLE if whole else NUMBER)]


def _bound(value: float) -> float:
    """A bound as a schema prints it: 1, not 1.0."""
    return int(value) if value < MOST and value == int(value) else value


if TYPE_CHECKING:  # a type checker takes no class that is made as the program runs
    InlineCamera = InlinePart
    InlineLens = InlinePart
    InlinePort = InlinePart
    InlineLight = InlinePart
    InlineHousing = InlinePart
else:
    InlineCamera, InlineLens, InlinePort, InlineLight, InlineHousing = map(_model, INLINE_KINDS)

INLINE_MODELS: dict[str, type[InlinePart]] = {
    "camera": InlineCamera,
    "lens": InlineLens,
    "port": InlinePort,
    "light": InlineLight,
    "housing": InlineHousing,
}


def inline_faults(kind: str, values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Keys of an inline record that do not agree: (key, rest of the sentence)."""
    return FAULTS[kind](values)


def part_from_inline(
    kind: Kind, mapping: Mapping[str, Any] | InlinePart, base_dir: Path | None = None
) -> Part:
    """The record of an inline part; files that it names are looked for in `base_dir`.

    Given numbers have status "user"; what is left out takes the defaults of this module's head.
    """
    from uwopt.catalog.readers.readers import READERS  # needs NumPy, which loading a file does not

    part = _validated_part(kind, mapping)
    return READERS[kind].from_inline(_values(part), base_dir)


def _validated_part(kind: str, mapping: Mapping[str, Any] | InlinePart) -> InlinePart:
    if isinstance(mapping, InlinePart):
        return mapping
    try:
        part = INLINE_MODELS[kind].model_validate(mapping)
    except ValidationError as error:
        details = error.errors(include_url=False)
        raise CatalogError(
            [
                f"inline {kind}: {'.'.join(map(str, d['loc']))} {d['msg'][:1].lower()}{d['msg'][1:]}."
                for d in details
            ]
        ) from None
    if faults := [f"inline {kind}: {key} {text}." for key, text in inline_faults(kind, _values(part))]:
        raise CatalogError(faults)
    return part


def _values(part: InlinePart) -> dict[str, Any]:
    return {name: getattr(part, name) for name in type(part).model_fields}
