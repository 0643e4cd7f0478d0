"""Requirements of which one alone stands in the way: each dropped in turn, and of those that help the least change.

Several that no imager's rule knows are first dropped at once: where nothing fits even so, none of them helps.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

from uwopt.deadline import Deadline
from uwopt.mission.mission import Mission
from uwopt.mission.weakened import DEEP, with_central_prices, without
from uwopt.objectives.objective import Objective
from uwopt.solvers.infeasible.freed_rules import (
    MAY_PASS,
    MOST_SUSPECTS,
    OF_LIGHT,
    asked_by,
    of_lamps,
    suspects_of,
)
from uwopt.solvers.infeasible.joint_changes import few_that_give
from uwopt.solvers.infeasible.least_change import in_rounds, same_hardware
from uwopt.solvers.infeasible.least_limit import LeastLimit
from uwopt.solvers.infeasible.reached import missed_by
from uwopt.solvers.infeasible.relaxer import ANY, CHEAPEST, FEW_IMAGERS, hope
from uwopt.solvers.infeasible.trials import BRIGHT, FINEST, Trials
from uwopt.solvers.recommend import Sought

LIGHT_SHARE, REST_SHARE = 0.5, 0.5  # of the time left, for what each loses when dropped
FEW_SHARE, FEW_TURN = 0.4, 3.0  # of the time left, for all among a few imagers, and of a fair part of that for each
LEAST_FEW_S, FEW_S = 0.3, 1.2  # in less no search among a few imagers has its answer; in this most have
LONGEST_FEW = 0.35  # of the time left for these, for one that comes early
MORE = 8  # times as many, where nothing helps among a few
HELPED = 0.7  # of their shares is what the others get where something is known to help
LONG_TURN = 0.5  # of the time left, for the question whether all would fit at central prices
ROUNDS = 3  # of the time that is left, as long as nothing helps
HOPE_SHARE, HOPE_TURN = 0.5, 0.6  # of the time left, for what is likely to help, and of that for each
IMAGER_S = 1e-5  # that a search takes at least for an imager that another requirement let through
QUICK_TURN = 0.5  # of the time left, for one of all imagers where that is soon known
FEW = 3  # requirements that are as well dropped one by one
SUSPECT_TURN, LAST_SUSPECT = 0.45, 0.7  # of the time left, for one that likely stands in the way
DRAW_SHARE = 0.5  # of the time left, for how little of these does
GIVE_SHARE = 0.6  # of the time left, for requirements that give together, where none is known to help alone


@dataclass
class Singles:
    """Single requirements; those that help, and those of which that is not known yet."""

    trials: Trials
    helpful: list[LeastLimit] = field(default_factory=list)
    left: dict[str, float] = field(default_factory=dict)
    suspects: Sequence[str] = ()  # without all of which something fits
    hopes: dict[str, float] = field(default_factory=dict)  # of those dropped among a few imagers, as `relaxer.hope`
    useless: dict[str, tuple[str, ...]] = field(default_factory=dict)  # known not to help: `freed_rules.in_the_way`
    in_part: dict[str, int] = field(default_factory=dict)  # how many systems were looked at in vain, not all
    dear: set[str] = field(default_factory=set)  # limits of cost that central prices do not keep either
    in_vain: dict[str, int] = field(default_factory=dict)  # among how many imagers, all of them looked at
    together: tuple[list[str], Sought] | None = None  # that give together, and a design without them
    unmet: list[str] = field(default_factory=list)  # which nothing meets where no other is asked: each has to give

    def __post_init__(self) -> None:
        relaxer, names = self.trials.relaxer, self.trials.limits
        self.useless |= relaxer.useless_alone(names)
        self.unmet += dict.fromkeys(rule for name in names for rule in relaxer.never_without(name))

    def ask_suspects(self) -> None:
        """First of all drop those that likely stand in the way.

        Where bounds tell soon, all others are dropped at once before: where nothing fits even so none of them helps,
        and that one has to give. Where they do not, the first that helps leaves the time to all else.
        """
        trials, like = self.trials, self.trials.relaxer.like
        waiting = [] if like is None else suspects_of(of_lamps(like.outcome), trials.limits)
        asked = list[str]()
        while waiting and len(asked) < MOST_SUSPECTS and not trials.over:
            name = waiting.pop(0)
            asked.append(name)
            trials.say(0.0, f"why nothing fits: without {name}")
            if trials.relaxer.are_too_many or trials.relaxer.is_soon_known():
                self._ask_all_but(name)
            if name in self._open(trials.limits):
                self._ask_suspect(name, SUSPECT_TURN if waiting else LAST_SUSPECT)
            if self.helpful and not trials.relaxer.is_soon_known():
                return
            then = asked_by(self.useless.get(name, ()), trials.limits)
            waiting += [other for other in then if other not in (*asked, *waiting)]

    def _ask_suspect(self, name: str, share: float) -> None:
        """Drop one that likely stands in the way, in a share of the time left: among a few, then where it may be soon
        known among all.

        Else the time is kept for what else may help.
        """
        trials = self.trials
        with trials.until_interrupted():
            if name in MAY_PASS:
                self._try_among(name, FEW_IMAGERS, trials.deadline.part(share))
            is_asked = name in self.hopes and not trials.relaxer.is_soon_known()  # else there may be hardly more
            if name in self._open(trials.limits) and not (is_asked or trials.interrupted):
                self._is_known(name, trials.deadline.part(share))

    def _ask_all_but(self, name: str) -> None:
        """Drop all others at once, or those that leave the imagers as they are where else there are many to look at."""
        trials, relaxer = self.trials, self.trials.relaxer
        every = [other for other in trials.limits if other in MAY_PASS and other != name]
        if trials.relaxer.is_never_sharp:  # what else is dropped helps nothing
            return
        all_soon = relaxer.are_too_many or relaxer.is_soon_known(every)
        others = every if all_soon else [other for other in every if not MAY_PASS[other]]
        found = trials.seek_without(others, few_first=not relaxer.are_too_many) if others else None
        if found is None:
            return
        if found.outcome.best:
            self._take_the_only_miss(found, others)
            return
        left = self._open(dict.fromkeys(others, 0.0))
        self.useless |= {other: trials.relaxer.why_not(found, other) for other in left}
        if len(others) == len(every):
            self.unmet.append(name)

    def try_hardware(self, known: Sought, phase: Deadline, names: Collection[str] | None = None) -> None:
        """Drop each, or these, and see whether some hardware fits then, which takes no search: where not, all is open.

        What keeps a limit of cost at likeliest prices shows that these would do.
        """
        trials = self.trials
        for name in self._open(trials.limits):
            if phase.passed() or trials.interrupted:
                return
            if name == DEEP or (names is not None and name not in names):
                continue
            central = self._may_keep_central(name)
            relaxed = with_central_prices(trials.mission) if central else without(trials.mission, name)
            if relaxed is None:
                continue
            found = same_hardware(known, relaxed)
            if found.outcome.best:
                self._helps(name, relaxed, found, at_central_prices=central)

    def try_few(self, number: int = FEW_IMAGERS) -> None:
        """Drop each and look among a few imagers.

        What the mission states itself comes before good practice, and the SNR last, as the brightest are looked for
        then, which takes longest.
        """
        trials = self.trials
        _ = trials.relaxer.broken  # takes longer than a turn, and all share it
        phase = trials.deadline.part(self.share(FEW_SHARE))
        names = sorted(
            self._hopeful_of_light(number, phase),
            key=lambda name: (not trials.is_own(name), name not in OF_LIGHT, name == "min_snr"),
        )
        for place, name in enumerate(names):
            if trials.interrupted or phase.left_s < LEAST_FEW_S:
                break
            trials.say(0.0, f"why nothing fits: without {name}")
            fair_s = phase.left_s / (len(names) - place)
            self._try_among(name, number, phase.at_most(max(FEW_TURN * fair_s, LONGEST_FEW * phase.left_s, FEW_S)))

    def try_more(self) -> None:
        """The same among more, where no rule lets any of the few through."""
        if not self.helpful and not any(self.hopes.values()):
            self.try_few(MORE * FEW_IMAGERS)

    def _hopeful_of_light(self, number: int, phase: Deadline) -> list[str]:
        """Without those that no imager's rule knows, where none of a few imagers fits without all of these."""
        trials = self.trials
        alike = [name for name in self._open(trials.limits) if name in OF_LIGHT and name != "min_snr"]
        others = [name for name in self._open(trials.limits) if name not in alike]
        turn = phase.at_most(max(LONGEST_FEW * phase.left_s, FEW_S))
        found = None if len(alike) < FEW else trials.few_without(alike, turn, number)
        if found is None or not (found.outcome.best or found.outcome.complete):
            return [*alike, *others]
        if not found.outcome.best:
            self.hopes |= dict.fromkeys(alike, 0.0)
            return others
        self._take_the_only_miss(found, alike)
        return [*self._open(dict.fromkeys(alike, 0.0)), *others]

    def give_together(self) -> None:
        """Requirements that give together, of which a few imagers show that they do; if it is one, that helps alone."""
        trials = self.trials
        with trials.within(trials.deadline.part(GIVE_SHARE)):
            self.together = few_that_give(trials)
        if self.together is None or len(self.together[0]) != 1:
            return
        (name,), found = self.together
        self.take_for_helpful(name, found)

    def take_for_helpful(self, name: str, found: Sought) -> None:
        """A design that misses this alone is known: the requirement helps."""
        relaxed = without(self.trials.mission, name)
        if relaxed is not None:
            self._helps(name, relaxed, found)

    def _helps(self, name: str, relaxed: Mission, found: Sought, *, at_central_prices: bool = False) -> None:
        """A requirement helps: something fits in the mission without it."""
        self.helpful.append(LeastLimit(self.trials, name, self.trials.limits[name], relaxed, found, at_central_prices))

    def drop_hopeful(self) -> None:
        """Drop those without which rules let some of the few imagers through, those that let most through first."""
        deadline = self.trials.deadline
        names = sorted((name for name in self.hopes if self.hopes[name] > 0.0), key=lambda name: -self.hopes[name])
        self.left = self._open({name: self.trials.limits[name] for name in names})
        self._drop_each(deadline.part(self.share(HOPE_SHARE)), HOPE_TURN)

    def _try_among(self, name: str, number: int, turn: Deadline) -> None:
        """Drop one and look among so many imagers."""
        trials = self.trials
        relaxed = without(trials.mission, name)
        if relaxed is None or self.in_vain.get(name, 0) >= number:
            return
        found = trials.among_few(relaxed, goal_without(name), {name}, turn, number)
        if found is None:
            return
        self.hopes[name] = hope(found)
        if found.outcome.best:
            self._take(name, relaxed, found)
        elif found.outcome.complete:
            self.in_vain[name] = number

    def share(self, share: float) -> float:
        """Of the time left, for what else may help: less where something does, or several have to give together."""
        return share * (HELPED if self.helpful or len(self.unmet) > 1 else 1.0)

    def _may_keep_central(self, name: str) -> bool:
        """Whether a limit is of cost at high prices, which central ones might keep, as far as is known."""
        return name == "cost" and self.trials.mission.limits.cost_basis == "high" and name not in self.dear

    def _open(self, limits: Mapping[str, float]) -> dict[str, float]:
        """Those of which it is not known whether they help."""
        known = {one.name for one in self.helpful} | self.useless.keys()
        return {name: limit for name, limit in limits.items() if name not in known}

    def drop_light(self) -> None:
        """Drop every requirement that no imager's rule knows."""
        trials = self.trials
        self.left = self._open({name: trials.limits[name] for name in trials.limits if name in OF_LIGHT})
        self._drop_at_once([name for name in self.left if name != "min_snr"])
        suspects = self.suspects
        self.left = {name: self.left[name] for name in sorted(self.left, key=lambda name: name not in suspects)}
        self._drop_each(trials.deadline.part(self.share(LIGHT_SHARE)))

    def drop_rest(self) -> None:
        """Drop the others, those that take least first."""
        trials, light = self.trials, self.left
        others = trials.by_effort()
        self.left = self._open({name: others[name] for name in others if name not in OF_LIGHT})
        relaxer = trials.relaxer
        if relaxer.is_soon_known():
            self._drop_at_once([
                name for name in self.left
                if name != DEEP and relaxer.is_soon_known({name})
            ])  # fmt: skip
        self._drop_each(trials.deadline.part(self.share(REST_SHARE)))
        self.left = {**light, **self.left}

    def drop_left(self) -> None:
        """Once more those that took too long."""
        self.left = self._open(self.left)
        self._drop_each(self.trials.deadline)

    def drop_others(self) -> None:
        """Once more those that took too long, with more time for each."""
        for _ in range(ROUNDS):
            if not self.left or self.helpful or self.trials.over:
                break
            self._drop_each(self.trials.deadline)

    def tell_open(self) -> None:
        """Note what is not known."""
        self.trials.deadline.left_out.extend(f"whether it could be met without {name}" for name in self.left)

    def _drop_at_once(self, names: Sequence[str]) -> None:
        """Drop what is left of these all at once: where nothing fits even so, none of them helps."""
        self.useless |= self._useless(names)
        self.left = self._open(self.left)

    def _useless(self, names: Sequence[str]) -> dict[str, tuple[str, ...]]:
        """Those of which none helps, as nothing fits without all of them, and why: by halves where something does."""
        if len(names) < FEW:
            return {}
        found = self.trials.seek_without(names)
        if found is None:
            return {}
        if not found.outcome.best:
            return {name: self.trials.relaxer.why_not(found, name) for name in names}
        self._take_the_only_miss(found, names)
        self.suspects = names
        middle = len(names) // 2
        return self._useless(names[:middle]) | self._useless(names[middle:])

    def _take_the_only_miss(self, found: Sought, names: Sequence[str]) -> None:
        """Where a design without several requirements misses only one of them, that one alone helps."""
        missed = missed_by(self.trials.judged(found), names)
        if len(missed) != 1 or not self._open(dict.fromkeys(missed, 0.0)):
            return
        (name,) = missed
        if self._may_keep_central(name):  # by how much is to be asked first
            return
        self.take_for_helpful(name, found)

    def _drop_each(self, phase: Deadline, turn: float | None = None) -> None:
        """Drop what is left one by one; `turn`: the share of the time left that each may take, if not the usual."""
        known, trials = [], self.trials
        share = turn or (QUICK_TURN if trials.relaxer.is_soon_known() else None)
        for number, name in enumerate(self.left):
            if phase.passed() or trials.interrupted:
                break
            trials.say(0.5 * number / len(self.left), f"why nothing fits: without {name}")
            with trials.until_interrupted():
                one = phase.part(share) if share else phase.at_most(trials.turn().left_s)
                if one.left_s < IMAGER_S * self._imagers_without(name):
                    if self._helps_among_few(name, one):  # all its imagers alone would take longer
                        known.append(name)
                    continue
                if self._is_known(name, one):
                    known.append(name)
        self.left = {name: limit for name, limit in self.left.items() if name not in known}

    def _helps_among_few(self, name: str, turn: Deadline) -> bool:
        """Whether one that rules let through among a few imagers helps by them, given more time than at first."""
        if self.hopes.get(name):
            self._try_among(name, FEW_IMAGERS, turn)
        return any(one.name == name for one in self.helpful)

    def _imagers_without(self, name: str) -> float:
        """How many imagers are to be looked at first without a requirement; none where that is not known."""
        effort = 0.0 if name in OF_LIGHT else self.trials.relaxer.effort({name})
        return effort if math.isfinite(effort) else 0.0

    def _take(self, name: str, relaxed: Mission, found: Sought) -> None:
        """Something fits without a requirement; whether a limit of cost would do at central prices is asked then."""
        if not self._may_keep_central(name) or not self._is_known_at_central_prices(name):
            self._helps(name, relaxed, found)

    def _is_known(self, name: str, turn: Deadline) -> bool:
        """Drop a requirement and see whether something fits then; whether that is known in the time for one."""
        trials, by_depth = self.trials, name == DEEP
        relaxed = trials.mission if by_depth else without(trials.mission, name)
        if relaxed is None:
            self.useless[name] = ()
            return True
        if by_depth:
            found = self._of_any_depth(turn)
        else:
            found = trials.relaxer.seek(
                relaxed, goal_without(name), {name}, deadline=turn, enough=True, few_first=False
            )
        if found.outcome.best:
            self._take(name, relaxed, found)
        elif found.outcome.complete:
            self.useless[name] = trials.relaxer.why_not(found, name)
        elif found.outcome.account.evaluated:
            self.in_part[name] = max(found.outcome.account.evaluated, self.in_part.get(name, 0))
        if found.outcome.interrupted:
            raise KeyboardInterrupt
        return found.outcome.complete or bool(found.outcome.best)

    def _of_any_depth(self, turn: Deadline) -> Sought:
        """A search for a design of parts rated for the depth alone, without its reserve; else for any depth."""
        trials = self.trials
        seek = partial(trials.relaxer.seek, trials.mission, ANY, {DEEP}, deadline=turn, enough=True)
        if trials.mission.depth_factor > 1.0:
            deep = seek(depth_m=trials.mission.asked_depth_m)
            if deep.outcome.best:
                return deep
        return seek(depth_m=0.0)

    def _is_known_at_central_prices(self, name: str) -> bool:
        """Whether a limit of cost is known to do with estimated prices at their middle; asked once."""
        trials = self.trials
        if name in self.dear:
            return False
        central, turn = with_central_prices(trials.mission), trials.deadline.part(LONG_TURN)
        found = trials.relaxer.seek(central, CHEAPEST, {name}, deadline=turn, enough=True)
        if found.outcome.best:
            self._helps(name, central, found, at_central_prices=True)
        elif found.outcome.complete:
            self.dear.add(name)
        return bool(found.outcome.best)

    # ------------------------------------------------------------ the least change

    def draw_in(self) -> None:
        """Draw in those that are known to help, in a share of the time left."""
        trials = self.trials
        with trials.until_interrupted():
            in_rounds(self.helpful, trials.deadline.part(DRAW_SHARE))


def goal_without(name: str) -> Objective:
    """By what designs are looked for without a requirement: of SNR, cost and pixels those first that miss it least."""
    return {"min_snr": BRIGHT, "cost": CHEAPEST, "max_gsd_mm": FINEST}.get(name, ANY)
