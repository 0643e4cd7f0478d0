"""What is recommended of what a search found: the best at likeliest values, or what holds as often as asked."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from uwopt.api.common import halfway
from uwopt.api.recommendation import Recommendation
from uwopt.api.searching import Searched, Searches
from uwopt.api.so_far import held_line
from uwopt.api.watch import Watch
from uwopt.api.yielding import KnownToHold, all_to_hold, fewest_to_hold, most_held, share_to_hold
from uwopt.deadline import effort_s
from uwopt.mission.doubt import CENTRAL
from uwopt.mission.mission import Mission
from uwopt.mission.yielding import Yield, with_yields
from uwopt.solvers.recommend import best_settable, design_of, with_fewest_lamps

if TYPE_CHECKING:
    from uwopt.api.counting import Counts


MOST_ROUNDS = 3  # in which less and less gives way
AS_SURE = 0.02  # shares of fresh scenarios that lie as near are as good as the same


def chosen_of(searched: Searched, watch: Watch, before: Counts | None = None) -> Recommendation:
    """What is recommended at the mission's confidence.

    before : what was counted for a mission that differs in a few keys
    """
    mission, sought, given_way = searched.mission, searched.sought, searched.given_way
    deadline, cut, few = watch.deadline, False, sought
    winner, is_counted = None, mission.confidence != CENTRAL and not sought.outcome.interrupted  # else nobody waits
    with watch.timed("evaluation"):
        try:
            sought = few = with_fewest_lamps(sought, deadline)
            if not is_counted or math.isfinite(deadline.end_s):  # else what is recommended is still to be chosen
                sought, winner = best_settable(sought, deadline)
        except KeyboardInterrupt:  # what is proven is not lost; asked again, it is
            cut, winner = True, design_of(sought, sought.outcome.best[0])
    if is_counted and not cut:
        from uwopt.api.certainty import with_confidence

        try:
            made = with_confidence(sought, winner, watch, before)
            more_to_make = made.counts is not None and made.counts.of_all_parts
            return replace(made, mission=mission, listed=None if more_to_make else sought, given_way=given_way)
        except KeyboardInterrupt:
            cut = True
    winner = winner or design_of(sought, sought.outcome.best[0])
    listed = None if cut else sought
    proven = searched.sought.outcome if sought is few else sought.outcome  # fewer lamps change no proof
    return Recommendation(mission, sought, proven, winner, listed, given_way=given_way, cut=cut)


def held_by_yielding(
    asked: Mission, first: Recommendation, searches: Searches, watch: Watch
) -> Recommendation:
    """What is recommended where good practice gives way so that it holds as often as is asked; the first if it does.

    asked : the mission with all of good practice
    """
    every = all_to_hold(asked, first.given_way)
    if first.cut or first.counts is None or first.is_enough or every == first.given_way:
        return first
    if not first.counts.seen.scenarios.is_drawn:
        return first

    def with_given_way(given_way: tuple[Yield, ...], counts: Counts, before: Recommendation) -> Recommendation:
        found = searches.of(with_yields(asked, given_way), scenes_of=first.sought.problem, fits=True)
        if not found.fits or not found.sought.outcome.complete:
            return before
        made = chosen_of(replace(found, given_way=given_way), watch, before=counts)
        if made.cut:
            return replace(before, cut=True)
        return replace(made, to_hold=True) if surer(first, made) is made and as_sure(made, before) else before

    best, known = first, KnownToHold()
    watch.so_far(held_line(first))
    try:
        counts, reached = counted_with(with_yields(asked, every), first, searches, watch, known)
        if first.counted is None or reached < halfway(first.counted.held, first.counted.asked):
            return first
        given_way = every
        for _ in range(MOST_ROUNDS):  # hardware that is found on the way may need less
            if best.cut or best.counts is None:
                break
            with watch.stage("practice"):
                fewest = fewest_to_hold(asked, first.given_way, given_way, counts, watch.deadline, known)
            if fewest is None or fewest == best.given_way:
                break
            given_way = fewest
            made = with_given_way(given_way, counts, best)
            if made is best:
                break
            best, counts = made, made.counts or counts
        could_hold = min(reached, share_to_hold(counts)) - AS_SURE
        unsure = best.counted is not None and best.counted.held_in_choice < could_hold
        if unsure and not best.cut and not best.is_enough and best.given_way != every:
            best = with_given_way(every, counts, best)
    except KeyboardInterrupt:  # what is known is not lost
        best = replace(best, cut=True)
    return best


def counted_with(
    weaker: Mission, first: Recommendation, searches: Searches, watch: Watch, known: KnownToHold
) -> tuple[Counts, float]:
    """Hardware that may hold as often as is asked in a weaker mission, and in what share of the scenarios some does.

    Of what was counted, or where that does not hold as often, and yet at least half as far, of a search.
    """
    from uwopt.api.counting import CERTAINTY_S, counts_of
    from uwopt.solvers.confidence.search import OF_CENTRAL

    counts, counted = first.counts, first.counted
    assert counts is not None and counted is not None
    with watch.stage("practice"):
        reached = most_held(counts, weaker, known)
    if halfway(counted.held, counted.asked) <= reached < share_to_hold(counts):  # other hardware may do better
        no_list = replace(searches, top=OF_CENTRAL)  # a proof of the next best takes longer than of the best
        found = no_list.of(weaker, scenes_of=counts.sought.problem, fits=True)
        if found.fits and found.sought.outcome.complete:
            patient = watch.until(watch.deadline.or_after(CERTAINTY_S, effort_s))
            counts = counts_of(found.sought, patient, counts) or counts
            reached = max(reached, counts.seen.held)
    return counts, reached


def as_sure(one: Recommendation, other: Recommendation) -> bool:
    """Whether one holds as often as asked, or as often as another."""
    if one.counted is None or other.counted is None:
        return False
    return one.counted.enough or one.counted.held >= other.counted.held - AS_SURE


def surer(one: Recommendation, other: Recommendation) -> Recommendation:
    """Of two, the other where it holds as often as asked, or at least half as far from that."""
    if one.counted is None or other.counted is None:
        return one
    return other if other.counted.enough or other.counted.held >= halfway(one.counted.held, one.counted.asked) else one
