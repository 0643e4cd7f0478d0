"""What follows from records of the catalogue, worked out once for each of them: missions that are tried one after
another have the same parts.

Records are told apart by identity, which is quick: a catalogue is loaded once. They are frozen, and so is what is
made of them; both are kept, so that no other record takes the place of one that is gone.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from functools import wraps
from typing import Any, Generic, TypeVar

T = TypeVar("T")
MOST_RECORDS = 20_000  # whose results one function keeps


class Once(Generic[T]):
    """Results by records and by what else they depend on; the oldest are forgotten once there are too many.

    most, most_records : results that are kept, and records that they are of; the last is kept whatever it is of
    """

    def __init__(self, most: int, most_records: int = MOST_RECORDS):
        self.most, self.most_records, self.n_records = most, most_records, 0
        self.known: dict[Hashable, tuple[tuple[Any, ...], T]] = {}

    def of(self, records: Sequence[Any], others: Hashable, make: Callable[[], T]) -> T:
        """What is known, or made."""
        key = (tuple(map(id, records)), others)
        found = self.known.get(key)
        if found is None:
            found = self.known[key] = tuple(records), make()
            self.n_records += len(records)
            while len(self.known) > 1 and (len(self.known) > self.most or self.n_records > self.most_records):
                self.n_records -= len(self.known.pop(next(iter(self.known)))[0])
        return found[1]


class HashedOnce(tuple[Any, ...]):
    """A tuple that stands in keys, as any other; its hash is worked out once, for curves have hundreds of numbers."""

    def __hash__(self) -> int:
        """As of a tuple."""
        if "known" not in self.__dict__:
            self.known = super().__hash__()
        return self.known


def once_each(make: Callable[..., T]) -> Callable[..., T]:
    """A function of one or more records, called once for each choice of them."""
    known: Once[T] = Once(MOST_RECORDS)

    @wraps(make)
    def remembered(*records: Any) -> T:
        return known.of(records, None, lambda: make(*records))

    return remembered
