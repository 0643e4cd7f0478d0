"""Keys of a mission that nothing meets which a person would move: how fast, how high, in what water.

They are no requirements that could be dropped; each is tried far from where it stands, and where something fits there,
drawn back as near as something still fits (`least_change`). Whatever is told has been solved.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from uwopt.catalog.catalogue import Catalog
from uwopt.deadline import Deadline
from uwopt.errors import UwoptError
from uwopt.forward.assembly import Generic
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.mission.varying import Value, Varied, VariedMission, rounded
from uwopt.objectives.objective import Objective
from uwopt.results.basis import Moved
from uwopt.solvers.explain.least_change import least_change, rounded_away
from uwopt.solvers.recommend import Sought, seek
from uwopt.units import split_unit

ANY = Objective.of("power")  # where any design that fits will do
FARTHEST_SPEED = 0.1  # of the speed that is asked
ALTITUDES = (0.6, 1.5, 0.35)  # of the altitude that is asked, in the order in which they are tried
FARTHEST_CLARITY = 4.0  # times as clear
TURN = 0.5  # of the time left: what one key may take of it
#: Jerlov types from the clearest on, by their attenuation at 530 nm.
CLEAREST_FIRST = ("I", "IA", "IB", "II", "1C", "III", "3C", "5C", "7C", "9C")


@dataclass(frozen=True)
class Try:
    """A key and the values far from what is asked at which it is tried, in turn, until something fits."""

    key: Varied
    asked: Value
    values: tuple[Value, ...]


@dataclass
class Mover:
    """Searches of one mission with single keys moved; `like` is the problem of the search that found nothing."""

    mission: Mission
    catalog: Catalog
    generic: Generic
    deadline: Deadline
    like: Problem
    base: VariedMission = field(init=False)

    def __post_init__(self) -> None:
        self.base = VariedMission(self.mission, {})

    def all(self) -> list[Moved]:
        """The keys that help when moved alone, each as little as is known to do."""
        made = []
        for one in self.tries():
            if self.deadline.passed():
                self.deadline.left_out.append(f"whether another {one.key.name} would do")
                continue
            moved = self.moved(one)
            made += [] if moved is None else [moved]
        return made

    def tries(self) -> Iterator[Try]:
        """Speed, water, then heights; a key on which the scenes differ is left alone."""
        vehicles = [view.vehicle for view in self.mission.views]
        speeds, altitudes = ({getattr(v, key) for v in vehicles} for key in ("speed_m_s", "altitude_m"))
        if len(speeds) == 1 and (speed := speeds.pop()) > 0.0:
            yield self._try("vehicle", "speed_m_s", speed, (rounded_away(FARTHEST_SPEED * speed, speed),))
        yield from self._waters()
        if len(altitudes) == 1:
            altitude = altitudes.pop()
            yield self._try(
                "vehicle", "altitude_m", altitude, tuple(rounded_away(f * altitude, altitude) for f in ALTITUDES)
            )

    def _waters(self) -> Iterator[Try]:
        """Clearer water, by the reading or by the type that the mission names."""
        waters = {(scene.clarity, scene.water) for scene in self.mission.scenes}
        if len(waters) > 1:
            return
        reading, water = waters.pop()
        if reading is not None:
            name, value = reading
            clearer = name in ("visibility_m", "secchi_m")
            far = value * FARTHEST_CLARITY if clearer else value / FARTHEST_CLARITY
            yield self._try("scene", name, value, (rounded_away(far, value),))
        elif water in CLEAREST_FIRST and water != CLEAREST_FIRST[0]:
            yield self._try("scene", "water", water, (CLEAREST_FIRST[0],))

    @staticmethod
    def _try(section: str, name: str, asked: Value, values: tuple[Value, ...]) -> Try:
        return Try(Varied(name, section, name, values), asked, values)

    def moved(self, one: Try) -> Moved | None:
        """How far a key has to move; None where nothing fits at any of the values that are tried."""
        turn = self.deadline.at_most(TURN * self.deadline.left_s)
        for value in one.values:
            found = self._search(one.key, value, turn)
            if found is not None and found.outcome.best:
                return self._nearest(one, value, found, turn)
            if found is not None and not found.outcome.complete:
                self.deadline.left_out.append(f"whether another {one.key.name} would do")
                return None
        return None

    def _nearest(self, one: Try, value: Value, found: Sought, turn: Deadline) -> Moved:
        """The value nearest to what is asked at which something fits."""
        if isinstance(value, str) or isinstance(one.asked, str):
            return self._nearest_type(one, turn)
        change = least_change(
            float(one.asked), float(value), found, relaxed=lambda v: self._at(one.key, v), deadline=turn,
            search=lambda mission: self._seek(mission, turn), name=one.key.name,
        )  # fmt: skip
        return Moved(one.key.name, float(one.asked), rounded(change.limit), unit_of(one.key.name), not turn.left_out)

    def _nearest_type(self, one: Try, turn: Deadline) -> Moved:
        """The type of water nearest to the mission's at which something fits."""
        place = CLEAREST_FIRST.index(str(one.asked))
        for water in CLEAREST_FIRST[place - 1 : 0 : -1]:
            found = self._search(one.key, water, turn)
            if found is not None and found.outcome.best:
                return Moved(one.key.name, one.asked, water, "", True)
            if turn.passed() or (found is not None and not found.outcome.complete):
                return Moved(one.key.name, one.asked, CLEAREST_FIRST[0], "", False)
        return Moved(one.key.name, one.asked, CLEAREST_FIRST[0], "", True)

    def _at(self, key: Varied, value: Value) -> Mission:
        return self.base.with_values({key: value})

    def _search(self, key: Varied, value: Value, turn: Deadline) -> Sought | None:
        """A search for any design with a key at another value; None where the mission does not allow it."""
        try:
            return self._seek(self._at(key, value), turn)
        except UwoptError:
            return None

    def _seek(self, mission: Mission, turn: Deadline) -> Sought:
        found = seek(
            mission, self.catalog, ANY, generic=self.generic, top=1, enough=True, deadline=turn, like=self.like
        )
        if found.outcome.interrupted:
            raise KeyboardInterrupt
        return found


def unit_of(name: str) -> str:
    """The unit of a key."""
    return split_unit(name)[1]

