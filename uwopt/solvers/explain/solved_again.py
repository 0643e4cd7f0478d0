"""A mission solved before and after something was learned, such as makers' answers: what changed, and why."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from uwopt.catalog.offers import Offer
from uwopt.documents.faults import plain_name
from uwopt.results.design import Design
from uwopt.results.result import Result


@dataclass(frozen=True, kw_only=True)
class SolvedAgain:
    """A mission solved before and after something was learned."""

    before: Result
    after: Result

    def former_now(self) -> Design | None:
        """The system that was recommended before, as it stands among those found after."""
        if self.before.best is None or self.after.best is None:
            return None
        ids = self.before.best.hardware.ids
        return next((one for one in [self.after.best, *self.after.runners_up] if one.hardware.ids == ids), None)

    def replaced(self) -> Iterator[tuple[str, str, str]]:
        """Kind, id before and id now of every part that is another one."""
        if self.before.best is None or self.after.best is None:
            return
        old, new = self.before.best.hardware.parts, self.after.best.hardware.parts
        for kind in dict.fromkeys((*old, *new)):
            was, now = (parts[kind].id if kind in parts else "none" for parts in (old, new))
            if was != now:
                yield kind, was, now


@dataclass(frozen=True, kw_only=True)
class QuotedAgain(SolvedAgain):
    """What came of answers: the offers, the log that they make, and the mission solved before and with them."""

    offers: tuple[Offer, ...]
    log: str

    def offer_of(self, part_id: str) -> Offer | None:
        """The offer of a part that counts."""
        return next((o for o in self.offers if o.usable and plain_name(o.part_id) == plain_name(part_id)), None)
