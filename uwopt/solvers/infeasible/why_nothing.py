"""Why nothing fits: the cascade of rules, what a single change of a requirement or key would do, and several together.

Every requirement is dropped in turn (`singles`) and keys that a person would move are moved far (`moves`); of those
that help the least change is sought. Then changes that help together (`joint_changes`). What there was no time for is
noted. At last requirements that contradict each other, an irreducible set, by leaving out several at once, then one
after another: nothing fits where the set alone is asked (beside what no mission can leave out: parts that go together,
focus, physics), and something fits once any one of it is left out. A requirement whose loss alone lets something
through is in every such set.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

from uwopt.mission.weakened import DEEP, without
from uwopt.results.basis import Excluded, Moved, NoHelp, Relaxed, WhyNothing
from uwopt.results.design import Design
from uwopt.results.result import Certificate
from uwopt.solvers.exact.node_bounds import NODE_RULES
from uwopt.solvers.infeasible.freed_rules import BATTERY, MAY_PASS, OF_LARGER
from uwopt.solvers.infeasible.joint_changes import CommonFit, CommonShare, Giving, least_set
from uwopt.solvers.infeasible.least_change import Stepwise, in_rounds
from uwopt.solvers.infeasible.least_limit import Relaxation
from uwopt.solvers.infeasible.moves import SHARE, Mover
from uwopt.solvers.infeasible.nearest_fit import nearest_fit
from uwopt.solvers.infeasible.none_left import none_left, stays_empty
from uwopt.solvers.infeasible.relaxer import ANY
from uwopt.solvers.infeasible.singles import Singles
from uwopt.solvers.infeasible.trials import Trials

HARDWARE_SHARE = 0.5  # of the time left, for what the hardware that came nearest does with other changes
DRAWN_SHARE = 0.4  # of the time left, for that, kept from what is asked once more
HARDWARE_S = 1.0  # of the processor, for how near to what is asked the hardware of a change reaches
FIRST_DRAWN_SHARE = 0.6  # of the time left, for the least of what came late, before others are asked again
LEAST_SHARE = 0.9  # of the time left, for the least of each change that helps
QUICK_SHARE = 0.2  # of the time left, likewise, where single changes are soon known
KEPT_SHARE = 0.35  # of the time left, for changes together where none is known to help alone
ONLY_SHARE = 0.75  # of what is left then, for these
SOON_SHARE = 0.5  # of the time left, for a design that fits with changes together, where none is known to help alone
LEAST_TOGETHER = 2  # changes: one is told as that which helps alone
TOGETHER_SHARE = 0.6  # of the time left, for changes together; the rest is for what contradicts each other


def why_nothing(trials: Trials, certificate: Certificate) -> WhyNothing:
    """The part of a result."""
    counted = [item for item in certificate.discarded if item.count]
    excluded = [Excluded(item.rule, item.count, item.rule in NODE_RULES) for item in counted]
    lacking = [*none_left(trials.mission, trials.relaxer.selection)]
    if stays_empty(lacking):
        return WhyNothing(excluded, [], None, none_left=lacking)
    by_size = any(item.rule.startswith("housing") and item.count for item in certificate.discarded)
    singles, mover = Singles(trials), Mover(trials)
    singles.ask_suspects()
    is_quick = trials.relaxer.is_soon_known()
    if singles.helpful and is_quick and not trials.over:
        singles.draw_in()
    try_hardware(singles, mover)
    soon = first_that_help(trials, singles, mover, is_quick=is_quick)
    draw_by_hardware(singles, mover)
    none_helps = not singles.helpful and not mover.helpful  # it may be that no single change does
    with trials.within(trials.deadline.but_for(KEPT_SHARE) if none_helps else trials.deadline):
        if not is_quick:
            singles.drop_hopeful()
            drop_light_and_move(singles, mover)
            singles.drop_rest()
        fit = nearest_fit(trials.relaxer) if by_size and not trials.interrupted else None
        if not mover.helpful:
            singles.drop_others()
    if soon is None and singles.together is None and not singles.helpful and not mover.helpful:
        trials.go_on()
        mover.try_all(one_is_enough=True)
        if not mover.helpful:
            singles.drop_others()
        draw_in(singles, mover, FIRST_DRAWN_SHARE)
    if singles.helpful or mover.helpful:
        ask_budget(singles, mover)
        ask_open(singles, mover)
    every, moves = least_changes(singles, mover)
    singles.tell_open()
    mover.tell_open()
    relaxations = [one for one in every if one.is_of_use]
    together, nearest = changes_together(trials, relaxations, bool(moves), singles.together, soon)
    alone = {one.name for one in every}.issuperset(one.name for one in together) and len(together) < LEAST_TOGETHER
    if not relaxations and not moves and alone:  # a limit that is out of reach by far: better told than nothing
        relaxations, together = every, []
        nearest = design_of(trials, every)
    clash = clash_of(trials, relaxations, singles.unmet)
    return WhyNothing(
        excluded,
        [Relaxed(r.name, r.limit, r.needed, r.miss_rel, r.fits_at_central_prices, r.is_least) for r in relaxations],
        nearest,
        together,
        fit,
        moves=moves,
        contradiction=list(clash.names),
        contradiction_is_least=clash.is_least,
        none_left=lacking,
        no_help=[NoHelp(name, [*rules]) for name, rules in (singles.useless | mover.useless).items()],
        not_known=[*singles.left, *(one.key.name for one in mover.left)],
        in_part={name: singles.in_part[name] for name in singles.left if name in singles.in_part},
        unmet=[*singles.unmet],
    )


def try_hardware(singles: Singles, mover: Mover) -> None:
    """With the hardware of each change that helps, ask of all others: what it does then needs no search to be known."""
    trials = singles.trials
    phase = trials.deadline.part(HARDWARE_SHARE)
    for found in [one.found for one in (*singles.helpful, *mover.helpful)]:
        trials.say(0.0, "what the hardware of a change does beside")
        with trials.until_interrupted():
            mover.try_hardware(found, phase)
            singles.try_hardware(found, phase)


def ask_budget(singles: Singles, mover: Mover) -> None:
    """Of hardware that fits with another battery, whether a larger budget of money or mass lets it fit with its own."""
    trials = singles.trials
    for one in [one for one in mover.helpful if one.name == BATTERY]:
        with trials.until_interrupted():
            singles.try_hardware(one.found, trials.deadline.at_most(HARDWARE_S), OF_LARGER)


def first_that_help(trials: Trials, singles: Singles, mover: Mover, *, is_quick: bool) -> CommonFit | None:
    """What soon shows what helps: single changes of all imagers or of a few, else several together, which are told.

    is_quick : whether bounds tell of all imagers as soon as of a few
    """
    soon = None
    mover.try_lamps()
    if "light" in trials.short_of and "min_snr" in singles.useless:  # nearer, slower and less asked at once will help
        soon = together_soon(trials, singles, mover)
    if is_quick:
        soonest = trials.deadline.but_for(QUICK_SHARE)
        with trials.within(soonest):
            drop_light_and_move(singles, mover)
        with trials.within(trials.deadline if mover.helpful else soonest):
            singles.drop_rest()
    else:
        mover.try_few()
        draw_by_hardware(singles, mover)
        singles.try_few()
    if soon is None and not singles.helpful and not mover.helps_in_this_water and not trials.over:
        soon = together_soon(trials, singles, mover)
    if not mover.helpful and not is_quick:
        singles.try_more()
    if soon is None and not singles.helpful and not mover.helpful and not trials.over:
        singles.give_together()
    return soon


def drop_light_and_move(singles: Singles, mover: Mover) -> None:
    """Drop what no imager's rule knows, and move each key: both leave the imagers, so that they take least."""
    singles.drop_light()
    if not singles.trials.interrupted:
        mover.try_all(singles.share(SHARE))


def together_soon(trials: Trials, singles: Singles, mover: Mover) -> CommonFit | None:
    """Changes that help together, found among a few imagers; of one alone a single that helps is made."""
    trials.say(0.0, "changes that help together")
    fit = CommonShare(trials, trials.deadline.part(SOON_SHARE), few=True).of_all()
    if fit is None or len(fit.changes) != 1:
        return fit
    (one,) = fit.changes
    if one.name in trials.limits:
        singles.take_for_helpful(one.name, fit.found)
    else:
        mover.take_for_far(one.name, one.needed, fit.found)
    return None


def least_changes(singles: Singles, mover: Mover) -> tuple[list[Relaxation], list[Moved]]:
    """Of each single requirement and key that helps the least change, by turns; of requirements far ones last, else the
    smallest first.
    """
    draw_in(singles, mover)
    if singles.left or mover.left:
        ask_open(singles, mover)
        draw_in(singles, mover)
    told = sorted((one.told() for one in singles.helpful), key=lambda one: (one.is_far, one.miss_rel))
    return told, [move.told() for move in mover.helpful]


def draw_by_hardware(singles: Singles, mover: Mover) -> None:
    """Draw in what helps as far as its own hardware reaches, which takes no search: far values are of little use."""
    trials = singles.trials
    with trials.until_interrupted():
        for change in changes_of(singles, mover):
            if change.gap >= 1.0 and not trials.over:
                change.step(trials.deadline.at_most(HARDWARE_S))


def draw_in(singles: Singles, mover: Mover, share: float = LEAST_SHARE) -> None:
    """Draw in what helps, by turns, in a share of the time left."""
    trials = singles.trials
    if trials.interrupted:
        return
    with trials.until_interrupted():
        in_rounds(changes_of(singles, mover), trials.deadline.part(share))


def changes_of(singles: Singles, mover: Mover) -> list[Stepwise]:
    """All that help and may be drawn in, requirements first."""
    return [*singles.helpful, *(move.drawn for move in mover.helpful if move.drawn is not None)]


def ask_open(singles: Singles, mover: Mover) -> None:
    """Ask once more what there was no time to know, before what helps is drawn in any further."""
    trials = singles.trials
    with trials.within(trials.deadline.but_for(DRAWN_SHARE)):
        singles.drop_left()
        if not trials.interrupted:
            mover.try_all(1.0)


def design_of(trials: Trials, relaxations: list[Relaxation]) -> Design | None:
    """What the smallest change lets through, judged by the mission as it stands."""
    return trials.judged(relaxations[0].found) if relaxations else None


def clash_of(trials: Trials, relaxations: list[Relaxation], unmet: Sequence[str] = ()) -> Contradiction:
    """Requirements that contradict each other, none too many if there is time to know.

    unmet : those that nothing meets where no other is asked
    """
    if unmet and {one.name for one in relaxations}.issuperset(unmet):
        return Contradiction(tuple(unmet), is_least=True)
    if trials.over or len(unmet) > 1:
        return Contradiction()
    trials.say(0.95, "which requirements contradict each other")
    names = [name for name in trials.by_effort() if name in MAY_PASS]
    of_light = [name for name in names if not MAY_PASS[name]]
    found = contradiction(names, {r.name for r in relaxations}, trials.fits_without, of_light)
    if found.is_least and not found.names and "min_snr" in names and fits_without_light(trials, names):
        found = Contradiction(("min_snr",), is_least=True)
    if found.names and any(one.name == DEEP for one in relaxations):  # which no search leaves out
        found = Contradiction((DEEP, *found.names), found.is_least)
    if not found.is_least and not trials.interrupted:
        trials.deadline.left_out.append("whether fewer requirements contradict each other")
    return found


def fits_without_light(trials: Trials, names: list[str]) -> bool:
    """Whether something fits where nothing is asked, not even the SNR at which something is seen."""
    dark = without(trials.without(names), "min_snr")
    return dark is not None and bool(
        trials.relaxer.seek(dark, ANY, set(names), deadline=trials.turn(), enough=True).outcome.best
    )


def changes_together(
    trials: Trials, relaxations: list[Relaxation], moved: bool, known: Giving | None, soon: CommonFit | None
) -> tuple[list[Relaxed], Design | None]:
    """Changes that help together, and the design that comes nearest.

    known : requirements that give together
    soon : changes that help together, where none but clearer water is known to help alone
    """
    nearest = design_of(trials, relaxations)
    if soon is not None and not relaxations and not moved:
        return soon.changes, trials.judged(soon.found)
    if trials.over:
        late = None if relaxations else soon
        return ([], nearest) if late is None else (late.changes, trials.judged(late.found))
    trials.say(0.9, "smaller changes together")
    share = TOGETHER_SHARE if relaxations or moved else ONLY_SHARE
    together = CommonShare(trials, trials.deadline.part(share))
    if relaxations:
        return together.smaller_than(relaxations[0].miss_rel), nearest
    fit = together.of_all() or soon
    if fit is not None and fit.changes:
        return fit.changes, trials.judged(fit.found)
    made, design = ([], None) if moved else least_set(trials, known)
    return made, design


# ---------------------------------------------------------------- an irreducible set


Fits = Callable[[Collection[str]], bool | None]  # without these requirements; None: not known


@dataclass(frozen=True)
class Contradiction:
    """Requirements with which alone nothing fits; without a name where that is not known of any but all."""

    names: tuple[str, ...] = ()
    is_least: bool = False  # whether something fits once any one of them is left out


def contradiction(
    names: Sequence[str], in_every_set: Collection[str], fits: Fits, at_once: Collection[str] = ()
) -> Contradiction:
    """A set of requirements that contradict each other, irreducible where every question finds its answer.

    Parameters
    ----------
    names : of all requirements, those first that are best left out first
    in_every_set : those whose loss alone lets something through
    fits : whether something fits without some
    at_once : those of which it takes as little to leave out all as to leave out one
    """
    needed = [name for name in names if name in in_every_set]
    left_out, kept, sure = list[str](), list[str](), True
    others = [name for name in names if name not in in_every_set]
    waiting = [[name] for name in others if name not in at_once][::-1]
    waiting.append([name for name in others if name in at_once])  # first
    while waiting:
        some = waiting.pop()
        known = fits([*left_out, *some]) if some else None
        if known is False:  # the others contradict each other without these
            left_out += some
        elif len(some) > 1:
            middle = len(some) // 2
            waiting += [some[middle:], some[:middle]]
        elif some:
            kept, sure = [*kept, *some], sure and known is True
    told = tuple(name for name in names if name in needed or name in kept)
    if not left_out and not sure:
        return Contradiction()
    return Contradiction(told, sure)
