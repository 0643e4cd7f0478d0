"""What all records of a result share: checked when made, frozen, to plain values and back.

A record is a pydantic dataclass: `@dataclass(frozen=True, config=RECORD)`, a line of meaning a field. It is made of
the program's own values or of those read from a file by the same checks, so that both ways know one layout.
"""

from collections.abc import Mapping
from dataclasses import fields
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, ConfigDict, Strict
from pydantic_core import to_json, to_jsonable_python

RECORD = ConfigDict(extra="forbid", defer_build=True)


def of_numpy(value: Any) -> Any:
    """NumPy's numbers as Python's."""
    return value.item() if hasattr(value, "item") else value


Number = Annotated[float, Strict(), BeforeValidator(of_numpy)]
Whole = Annotated[int, Strict(), BeforeValidator(of_numpy)]
Flag = Annotated[bool, Strict(), BeforeValidator(of_numpy)]


class Record:
    """A record of a result; a field is also found by its key, as in the file."""

    def __getitem__(self, key: str) -> Any:
        if key not in getattr(self, "__dataclass_fields__"):  # noqa: B009
            raise KeyError(key)
        return getattr(self, key)


class FiledRecord(Record):
    """A record that is a file of its own."""

    def to_dict(self) -> dict[str, Any]:
        """Plain values, ready for JSON."""
        values: dict[str, Any] = plain(self)
        return values

    def to_json(self) -> str:
        """The file's text."""
        return to_json(self.to_dict(), indent=1).decode()  # json's own indents eight times as slowly

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """From plain values, as read from a file; a key that a later version adds at the top is passed over."""
        known = {field.name for field in fields(cls)}  # pyrefly: ignore[bad-argument-type]
        return cls(**{key: value for key, value in data.items() if key in known})


def plain(value: Any) -> Any:
    """Records, arrays and NumPy numbers as plain values; what is not finite becomes None."""
    return to_jsonable_python(
        value, inf_nan_mode="null", serialize_as_any=True, fallback=lambda array: array.tolist()
    )
