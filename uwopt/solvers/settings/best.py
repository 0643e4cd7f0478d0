"""Settings that are best for an objective: least power, greatest signal to noise, or a weighing of both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import put_into
from uwopt.forward.scene import SceneOptics
from uwopt.forward.scene_rows import SceneRows
from uwopt.objectives.objective import MAXIMISED, Objective
from uwopt.solvers.settings import closed_form, dark, windows
from uwopt.solvers.settings.few_pixels import deciding_pixels
from uwopt.solvers.settings.joint import is_bounded, joint_bound_of_designs
from uwopt.solvers.settings.question import Best, Question
from uwopt.solvers.settings.switched import bound_with_cameras
from uwopt.units import ratio_to_db

DARK_ROUNDS = 25
SetWithDark = tuple[list[closed_form.Chosen], Array, Array]  # settings, whether there are any, and their SNR [dB]
NO_RELATIVE_GAP = 0.1  # of an objective near 0, which has none
LEAST_POWER = Objective.of("power")
FAINTEST = 1e-6  # of the highest SNR: where a weighing starts when nothing asks for light
SECTIONS, GOLDEN = 61, (np.sqrt(5.0) - 1.0) / 2.0  # of a range in which a weighing is best


def scenes_need_cells(scenes: Sequence[SceneOptics], objective: Objective) -> bool:
    """Whether a mission's settings have no closed form: sun, sharpness or information."""
    asked = any(s.sunlit or s.view.requirements.asks_sharpness for s in scenes)
    return not scenes[0].paper and (asked or bool(objective.weight("information")))


def needs_cells(rows: list[SceneRows], objective: Objective) -> bool:
    """Whether the closed form does not hold.

    Power that falls with the time as well as with the level is not convex along the SNR: no weighing of both.
    """
    weighs = bool(objective.weight("snr_db") and objective.weight("power")) and any(r.switched for r in rows)
    return bool(objective.weight("information")) or weighs or any(r.sunlit or r.asks_sharpness for r in rows)


def best_settings(question: Question, *, closed_alone: bool = False) -> Best:
    """Settings that are best for an objective, with their exposures.

    `closed_alone`: for a bound, no cells where the closed form is one. Raises OutOfTimeError past the deadline, if
    cells are halved.
    """
    best = _best_of_kind(question, closed_alone=closed_alone)
    return replace(best, chosen=[c.exposed(r) for r, c in zip(question.rows, best.chosen, strict=True)])


def _best_of_kind(question: Question, *, closed_alone: bool) -> Best:
    """The same by whichever way holds for such rows and such an objective."""
    rows, objective = question.rows, question.objective
    weighs = bool(objective.weight("snr_db") and objective.weight("power"))
    if rows[0].optimistic and any(r.camera_w is not None for r in rows):  # what cameras draw is counted apart
        return _bounded_with_cameras(question, closed_alone=closed_alone)
    if weighs and rows[0].optimistic and is_bounded(rows, objective):  # as good as closed forms, and far cheaper
        return best_joint(question)
    if not needs_cells(rows, objective):
        return best_in_the_dark(question)
    if objective.weight("information") or any(r.sunlit or (weighs and r.switched) for r in rows):
        from uwopt.solvers.settings.cells import best_by_cells  # no closed form needs it

        if is_bounded(rows, objective):
            return best_joint(question)
        counts = any(objective.weight(name) for name in MAXIMISED)
        unknown = counts and any(r.sunlit for r in rows) and np.isinf(question.cutoff).all()
        return (best_of_what_fits if unknown else best_by_cells)(question)
    return best_where_sharp(question, closed_alone=closed_alone)


def _bounded_with_cameras(question: Question, *, closed_alone: bool) -> Best:
    """Bounds by the lamps alone, raised by what cameras draw; where that is too much, no settings are searched."""
    free = replace(question, rows=[replace(r, camera_w=None) for r in question.rows])
    dear = bound_with_cameras(question, np.full(len(question), -np.inf))
    found = _best_of_kind(replace(free, cutoff=np.where(dear > question.cutoff, -np.inf, question.cutoff)),
                          closed_alone=closed_alone)
    return replace(found, lower_bound=np.maximum(found.bound(free), dear))


def best_joint(question: Question) -> Best:
    """Best settings over cells of the designs whose quality and price together may win; bounds of the others.

    Rows for bounds are answered with these bounds alone.
    """
    rows = question.rows
    bound = joint_bound_of_designs(rows, question.objective, question.light_limit_w, question.constant)
    none = unsettled(question, bound)
    if rows[0].optimistic:
        return none
    return searched_where(np.isfinite(bound) & (bound <= question.cutoff), none, question)


def best_of_what_fits(question: Question) -> Best:
    """Best settings over cells of the designs that have any, which is asked first, without what they show: any do."""
    lower = bound_if_any(question)
    return searched_where(np.isfinite(lower), unsettled(question, lower), question)


def bound_if_any(question: Question) -> Array:
    """What no settings can beat in power, (n,) [W], roughly, cell by cell until a point fits; inf: nothing does."""
    from uwopt.solvers.settings.cells import best_by_cells

    lower = best_by_cells(replace(question, objective=LEAST_POWER, gap_rel=np.inf)).lower_bound
    assert lower is not None
    return lower


def unsettled(question: Question, bound: Array) -> Best:
    """No settings, with bounds."""
    nothing = np.full(len(question), np.nan)
    chosen = [closed_form.Chosen(*(nothing.copy() for _ in range(7))) for _ in question.rows]
    return Best(chosen, np.zeros(len(question), bool), nothing, nothing, np.zeros(len(question)), bound)


def best_where_sharp(question: Question, *, closed_alone: bool) -> Best:
    """Best settings whose image is sharp enough as well.

    Without that requirement the closed form holds and is a bound: where its settings happen to be sharp they
    are best; where it finds none, there are none; where it cannot beat the cutoff, neither can sharp settings.
    """
    easy = best_closed(question)
    lower = easy.bound(question)
    sharp = np.logical_and.reduce([is_sharp(r, c) for r, c in zip(question.rows, easy.chosen, strict=True)])
    feasible = easy.feasible & sharp
    easy = replace(easy, feasible=feasible, lower_bound=lower)
    if closed_alone:
        return easy
    done = feasible
    if any(r.camera_w is not None for r in question.rows):
        done = feasible & is_close(easy, lower, question)
    return searched_where(np.isfinite(lower) & ~done & (lower <= question.cutoff), easy, question)


def best_in_the_dark(question: Question) -> Best:
    """Best settings in closed form; where dark current leaves more than the gap open, searched over cells."""
    easy = best_closed(question)
    lower = easy.lower_bound
    if lower is None:
        return easy
    close = is_close(easy, lower, question)
    return searched_where(np.isfinite(lower) & ~close & (lower <= question.cutoff), easy, question)


def is_close(best: Best, lower: Array, question: Question) -> Array:
    """Whether settings that fit are within a relative gap of what none can beat, (n,)."""
    known = np.where(np.isfinite(lower), lower, 0.0)
    scale = np.maximum(question.objective.scale(known), NO_RELATIVE_GAP)
    return best.feasible & (best.value(question) - known <= question.gap_rel * scale)


def searched_where(which: Array, easy: Best, question: Question) -> Best:
    """Some designs searched over cells, the others as they are."""
    open_ = np.nonzero(which)[0]
    if len(open_) == 0:
        return easy
    from uwopt.solvers.settings.cells import best_by_cells

    chosen = [c.exposed(r) for r, c in zip(question.rows, easy.chosen, strict=True)]
    return replace(easy, chosen=chosen).put(open_, best_by_cells(question.take(open_)))


def is_sharp(rows: SceneRows, chosen: closed_form.Chosen) -> Array:
    """Whether the MTF that is asked for holds at these settings, without sun."""
    if not rows.asks_sharpness or rows.sharp is None:
        return np.ones(len(chosen.f_number), bool)
    known = np.isfinite(chosen.f_number) & np.isfinite(chosen.time_s)
    f_number, time = np.where(known, chosen.f_number, 1.0), np.where(known, chosen.time_s, 0.0)
    return np.asarray(known & rows.sharp_enough(f_number=f_number, blur_s=rows.blur_s(time)))


def best_closed(question: Question) -> Best:
    """Best settings in closed form.

    Dark current depends on the exposure that is chosen, so the closed form is taken again with the
    exposure of the last round, from the shortest up; dark electrons are few, and two or three rounds
    settle it. Least power is settled with its dark electrons where that need not be the joint optimum; where SNR
    counts too, the bound says what is left. Rows for bounds are answered with a bound at once.
    """
    rows, motorised, mean_limit = question.rows, question.motorised, question.mean_limit
    if any(r.camera_w is not None for r in rows):
        return best_of_switched_cameras(question)
    if not any(np.any(r.dark_current_e_s > 0) for r in rows):
        return closed_at(rows, settings_at_dark(rows, question))
    if rows[0].optimistic:
        rows = [dark.relaxed(r) for r in rows]
        return closed_at(rows, settings_at_dark(rows, question))
    start = [dark.at_time(deciding_pixels(r), r.time_min_s) for r in rows]
    rows, found, settled, ever = settled_with_its_dark(start, question)
    best = closed_at(rows, found)
    best = replace(best, feasible=best.feasible & settled)
    if question.objective.weight("snr_db") or any(r.switched for r in rows):
        return replace(best, lower_bound=bound_in_the_dark(start, question))
    bent = np.logical_or.reduce([dark.outruns_light(r) for r in rows])
    sure = dark.surely_least(rows, best.chosen, motorised) if bent.any() else ~bent
    best = with_joint_optimum(best, rows, motorised, ever, which=~bent)
    if mean_limit is not None:
        best = replace(best, feasible=best.feasible & mean_limit.met_by(best.chosen, question.camera_power_w))
    if not bent.any():
        return best
    unsure = bent & ~(best.feasible & sure)
    return replace(best, lower_bound=np.where(unsure, bound_in_the_dark(start, question), best.value(question)))


def settled_with_its_dark(
    start: list[SceneRows], question: Question
) -> tuple[list[SceneRows], SetWithDark, Array, Array]:  # fmt: skip
    """Rows with the dark electrons of their own best settings, these, whether they agree, and if some round had any.

    What has settled is not asked again.
    """
    rows, found = start, settings_at_dark(start, question)
    ever, settled = found[1].copy(), np.zeros(len(question), bool)
    open_, part, now = np.arange(len(question)), rows, found
    for turn in range(DARK_ROUNDS):
        updated = [closed_form.with_exposure(r, c) for r, c in zip(part, now[0], strict=True)]
        settled[open_] = same = np.logical_and.reduce(
            [
                np.isclose(windows.dark_e(a), windows.dark_e(b), rtol=1e-12, atol=1e-10)
                for a, b in zip(part, updated, strict=True)
            ]
        )
        left = np.flatnonzero(~same)
        if len(left) == 0 or turn + 1 == DARK_ROUNDS:
            break
        open_, part, question = open_[left], [r.take(left) for r in updated], question.take(left)
        now = settings_at_dark(part, question)
        ever[open_] |= now[1]
        rows = [
            replace(r, dark_time_s=put_into(r.dark_time_s, open_, own.dark_time_s))
            for r, own in zip(rows, part, strict=True)
        ]
        chosen, feasible, snr_db = (put_into(old, open_, new) for old, new in zip(found, now, strict=True))
        found = chosen, feasible, snr_db
    return rows, found, settled, ever


def best_of_switched_cameras(question: Question) -> Best:
    """Settings that are best for the lamps, with what cameras draw for their exposures, and a bound without it.

    Where the highest SNR within a power is wanted, the longest exposure is set aside of that power.
    """
    rows, mean_limit, camera_power_w = question.rows, question.mean_limit, question.camera_power_w
    free = replace(question, rows=[replace(r, camera_w=None) for r in rows])
    found = best_closed(free)
    bound = bound_with_cameras(question, found.bound(question))
    if question.objective.weight("snr_db"):
        most_w = camera_power_w + np.max([r.exposing_w(r.longest_exposure_s) for r in rows], axis=0)
        found = best_closed(replace(free, camera_power_w=most_w))
    chosen = [
        replace(c, light_power_w=c.light_power_w + r.exposing_w(r.exposure_s(c.time_s)))
        for r, c in zip(rows, found.chosen, strict=True)
    ]
    feasible = found.feasible
    if mean_limit is not None:
        feasible = feasible & mean_limit.met_by(chosen, camera_power_w)
    return replace(found, chosen=chosen, feasible=feasible, lower_bound=bound)


def bound_in_the_dark(rows: list[SceneRows], question: Question) -> Array:
    """What no settings can beat, with dark electrons where they help and none where they harm; inf: there are none."""
    free = [dark.relaxed(r) for r in rows]
    return closed_at(free, settings_at_dark(free, question)).value(question)


def closed_at(rows: list[SceneRows], found: SetWithDark) -> Best:
    """Settings with the figures that they have."""
    chosen, feasible, snr_db = found
    contrast = np.min([windows.nominal_contrast(r) for r in rows], axis=0)
    return Best(chosen, feasible, snr_db, contrast, np.zeros(len(feasible)))


def with_joint_optimum(best: Best, rows: list[SceneRows], motorised: Array, ever: Array, *, which: Array) -> Best:
    """Least power, settled with its dark electrons where a fixed point need not be the optimum.

    rows : with the dark electrons of the settings; ever : whether some round had settings; which : others stay
    """
    sure = dark.surely_least(rows, best.chosen, motorised)
    lost = ~best.feasible & (ever | (rows[0].mean_level is not None))
    if lost.any():
        index = np.nonzero(lost)[0]
        free = [dark.relaxed(r.take(index)) for r in rows]
        lost[index] = closed_form.least_power(free, motorised[index])[1]
    open_ = np.nonzero(np.where(best.feasible, ~sure, lost) & which)[0]
    if len(open_) == 0:
        return best
    some = [r.take(open_) for r in rows]
    chosen, feasible = dark.least_power_in_the_dark(some, motorised[open_])
    some = [closed_form.with_exposure(r, c) for r, c in zip(some, chosen, strict=True)]
    return best.put(open_, closed_at(some, (chosen, feasible, snr_of(some, chosen))))


def settings_at_dark(rows: list[SceneRows], question: Question) -> SetWithDark:
    """Best settings with the dark electrons of these rows, in place of the question's.

    Without SNR in the objective least power is best for every term. With SNR alone the highest reachable
    is found first, then the least power that reaches it. A weighted sum is convex along the SNR floor.
    """
    motorised, objective, mean_limit = question.motorised, question.objective, question.mean_limit
    camera_power_w = question.camera_power_w
    weight, asked = objective.weight("snr_db"), [windows.asked_sides(r) for r in rows]
    if not weight:
        chosen, feasible = closed_form.least_power(rows, motorised, asked=asked)
    else:
        top = closed_form.greatest_snr(rows, motorised, question.light_limit_w, asked=asked)
        goal = np.nan_to_num(top, nan=0.0) * (1 - 1e-12)
        if mean_limit is not None:
            goal = mean_limit.highest_snr(rows, motorised, goal, camera_power_w, asked)
        if objective.single is None and objective.weight("power"):
            goal = weighted_goal(rows, motorised, goal, objective.weight("power"), weight, asked)
        chosen, feasible = closed_form.least_power(rows, motorised, snr_floor=goal, asked=asked)
        feasible &= np.isfinite(top)
    if mean_limit is not None:
        feasible &= mean_limit.met_by(chosen, camera_power_w)
    return chosen, feasible, snr_of(rows, chosen)


def snr_of(rows: list[SceneRows], chosen: list[closed_form.Chosen]) -> Array:
    """SNR of settings at the nominal altitude in dB, worst scene; NaN where there is no light."""
    snr = closed_form.worst_snr(rows, chosen)
    with np.errstate(invalid="ignore"):
        return np.asarray(ratio_to_db(np.where(snr > 0, snr, np.nan)))


def weighted_goal(
    rows: list[SceneRows], motorised: Array, top: Array, power_weight: float, snr_weight: float,
    asked: list[windows.Window],
) -> Array:  # fmt: skip
    """SNR floor that minimises power_weight * power - snr_weight * SNR in dB, by golden section.

    Between the requirement and the reachable top; power is convex in the SNR in dB for lamps that dim
    freely. Lamps with steps are tried at the top of each step as well. `asked` : as in `closed_form.least_power`
    """

    def merit(snr: Array) -> Array:
        chosen, feasible = closed_form.least_power(rows, motorised, snr_floor=snr, asked=asked)
        power = np.max([c.light_power_w for c in chosen], axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            value = power_weight * power - snr_weight * ratio_to_db(closed_form.worst_snr(rows, chosen))
        return np.where(feasible, value, np.inf)

    start, _ = closed_form.least_power(rows, motorised, asked=asked)
    low = closed_form.worst_snr(rows, start)
    low = np.where(np.isfinite(low), np.clip(low, top * FAINTEST, top), top)
    a, b = np.log(np.maximum(low, 1e-300)), np.log(np.maximum(top, 1e-300))
    c, d = b - GOLDEN * (b - a), a + GOLDEN * (b - a)
    value_c, value_d = merit(np.exp(c)), merit(np.exp(d))
    for _ in range(SECTIONS):
        left = value_c < value_d
        a, b = np.where(left, a, c), np.where(left, d, b)
        new = np.where(left, b - GOLDEN * (b - a), a + GOLDEN * (b - a))  # the other is one of the last two
        value = merit(np.exp(new))
        c, d = np.where(left, new, d), np.where(left, c, new)
        value_c, value_d = np.where(left, value, value_d), np.where(left, value_c, value)
    best, best_value = top, merit(top)
    others = [(low, merit(low)), (np.exp(c), value_c), (np.exp(d), value_d)]
    for point, value in others + [(step, merit(step)) for step in step_tops(rows, motorised, top, asked)]:
        best, best_value = np.where(value < best_value, point, best), np.minimum(best_value, value)
    return best


def step_tops(
    rows: list[SceneRows], motorised: Array, top: Array, asked: list[windows.Window]
) -> list[Array]:
    """SNR reached at the top of each step of each scene's light: where a staircase of power may be best.

    asked : as in `closed_form.least_power`; a lower top level changes none of them
    """
    tops = []
    for scene in rows:
        for column in range(scene.levels.shape[1]):
            level = scene.levels[:, column]
            if np.isnan(level).all():
                continue
            capped = [replace(r, max_level=np.fmin(r.max_level, level)) if r is scene else r for r in rows]
            snr = closed_form.greatest_snr(capped, motorised, np.full(len(top), np.inf), asked=asked)
            tops.append(np.where(np.isfinite(snr), np.minimum(snr, top) * (1 - 1e-12), top))
    return tops
