"""What follows from records is made once for each, and for each choice of what else it depends on."""

from __future__ import annotations

import pickle
from pathlib import Path

from uwopt.forward.assembly import load_catalog, selected
from uwopt.forward.once import HashedOnce, Once, once_each
from uwopt.mission.mission import load_mission

REEF = Path(__file__).parents[2] / "problems" / "reef-mosaic.yaml"


class Record:
    """Equal to all others: records are told apart by identity."""

    def __eq__(self, other: object) -> bool:
        return True

    __hash__ = None  # type: ignore[assignment]


def test_what_follows_is_made_once_for_each_record():
    made = []

    @once_each
    def follows(record, *others):
        made.append(record)
        return [record, *others]

    one, other = Record(), Record()
    assert follows(one) is follows(one)
    assert follows(other)[0] is other
    assert follows(one, other) is follows(one, other)
    assert len(made) == 3


def test_what_else_counts_is_told_apart_and_the_oldest_is_forgotten():
    known, made, records = Once[int](2), [], [Record(), Record()]

    def make() -> int:
        made.append(0)
        return len(made)

    assert [known.of(records, currency, make) for currency in ("USD", "EUR", "USD")] == [1, 2, 1]
    assert known.of(records[:1], "USD", make) == 3  # the third: the first is forgotten
    assert known.of(records, "EUR", make) == 2
    assert known.of(records, "USD", make) == 4


def test_results_of_too_many_records_are_forgotten_but_for_the_last():
    known, records = Once[int](9, most_records=3), [Record() for _ in range(5)]
    assert known.of(records[:2], "USD", lambda: 1) == 1
    assert known.of(records[2:], "USD", lambda: 2) == 2  # five records: the first two are forgotten
    assert known.of(records[2:], "USD", lambda: 3) == 2
    assert known.of(records[:2], "USD", lambda: 4) == 4  # as are the three then
    assert known.of(records[:1], "USD", lambda: 5) == 5 and known.of(records[:2], "USD", lambda: 6) == 4


def test_a_tuple_that_is_hashed_once_stands_in_keys_as_any_other():
    asked = []

    class Counted(int):
        def __hash__(self) -> int:
            asked.append(self)
            return hash(int(self))

    key = HashedOnce((Counted(1), 2))
    assert hash(key) == hash(key) == hash((1, 2)) and len(asked) == 1
    assert {("table", key): "known"}["table", (1, 2)] == "known"
    again = pickle.loads(pickle.dumps(HashedOnce((1, 2))))  # as copies of the process send it
    assert again == key and hash(again) == hash(key)


def test_missions_that_choose_alike_have_one_selection_and_others_their_own():
    mission = load_mission(REEF)
    catalog = load_catalog(mission)
    made = selected(mission, catalog, generic="allow")
    cheaper = mission.with_changes(limits={**mission.to_dict()["limits"], "cost": 1000.0})
    assert selected(cheaper, catalog, generic="allow") is made
    deeper = selected(mission, catalog, generic="allow", depth_m=4000.0)
    assert all(light.depth_rating_m >= 4000.0 for light in deeper.lights) and len(deeper.lights) < len(made.lights)
    dim = selected(mission.with_changes(fixed={"f_number": 16.0}), catalog, generic="allow")
    assert 0 < len(dim.lenses) < len(made.lenses)
    assert not any(part.generic for part in selected(mission, catalog, generic="never").ports)
