"""Settings that are best for an objective: least power, greatest signal to noise, or a weighing of both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from uwopt.deadline import NEVER, Deadline
from uwopt.forward.scene import SceneOptics
from uwopt.forward.setting_rows import SceneRows
from uwopt.objectives.objective import Objective
from uwopt.solvers.settings import closed_form, dark, windows
from uwopt.solvers.settings.few_pixels import deciding_pixels
from uwopt.solvers.settings.joint import is_bounded, joint_bound
from uwopt.solvers.settings.mean_limit import MeanLimit
from uwopt.units import ratio_to_db

if TYPE_CHECKING:
    from uwopt.solvers.settings.cells import CellResult

Array = NDArray[Any]
DARK_ROUNDS = 25
GAP = 1e-4  # relative, where cells are searched
#: What settings are asked for: motorised, objective, the camera's power, the limit of power, that of mean power.
Given = tuple[Array, Objective, Array, "float | Array", MeanLimit | None]
NO_RELATIVE_GAP = 0.1  # of an objective near 0, which has none
FAINTEST = 1e-6  # of the highest SNR: where a weighing starts when nothing asks for light


@dataclass(frozen=True)
class Best:
    """Best settings of n designs by scene, the worst scene's figures, and what no settings can beat."""

    chosen: list[closed_form.Chosen]
    feasible: Array
    snr_db: Array
    contrast: Array  # image mean at the nominal altitude
    information: Array  # bit/m2; 0 where it does not count
    lower_bound: Array | None = None  # of the minimised objective, constants included; None: the value itself


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


def best_settings(
    rows: list[SceneRows], motorised: Array, objective: Objective, camera_power_w: Array,
    power_limit_w: float | Array, *,
    gap_rel: float = GAP, constant: Array | float = 0.0, cutoff: float | Array = np.inf, hardware: Array | None = None,
    top: int | None = None, mean_limit: MeanLimit | None = None, closed_alone: bool = False,
    near: Array | None = None, deadline: Deadline = NEVER,
) -> Best:  # fmt: skip
    """Settings that are best for an objective; the keywords as in `cells.best_by_cells`, for where it is used.

    `closed_alone`: for a bound, no cells where the closed form is one. Raises OutOfTimeError past the deadline, if
    cells are halved.
    """
    weighs = bool(objective.weight("snr_db") and objective.weight("power"))
    if rows[0].optimistic:
        rows = [replace(r, camera_w=None) for r in rows]  # the least that cameras draw is counted apart
    if weighs and rows[0].optimistic and is_bounded(rows, objective):  # as good as closed forms, and far cheaper
        return best_joint(
            rows, motorised, objective, camera_power_w, power_limit_w, constant=constant, cutoff=cutoff
        )  # fmt: skip
    if not needs_cells(rows, objective):
        return best_in_the_dark(
            rows, motorised, objective, camera_power_w, power_limit_w, gap_rel=gap_rel, constant=constant,
            cutoff=cutoff, hardware=hardware, top=top, mean_limit=mean_limit, deadline=deadline,
        )  # fmt: skip
    if objective.weight("information") or any(r.sunlit or (weighs and r.switched) for r in rows):
        from uwopt.solvers.settings.cells import (
            best_by_cells,  # no closed form needs it
        )

        if is_bounded(rows, objective):
            return best_joint(
                rows, motorised, objective, camera_power_w, power_limit_w, gap_rel=gap_rel, constant=constant,
                cutoff=cutoff, hardware=hardware, top=top, mean_limit=mean_limit, deadline=deadline, near=near,
            )  # fmt: skip
        return _of_cells(best_by_cells(
            rows, motorised, objective, camera_power_w, power_limit_w, gap_rel=gap_rel, constant=constant,
            cutoff=cutoff, hardware=hardware, top=top, mean_limit=mean_limit, deadline=deadline,
        ))  # fmt: skip
    return best_where_sharp(
        rows, motorised, objective, camera_power_w, power_limit_w, gap_rel=gap_rel, constant=constant,
        cutoff=cutoff, hardware=hardware, top=top, mean_limit=mean_limit, deadline=deadline, closed_alone=closed_alone,
    )  # fmt: skip


def best_joint(
    rows: list[SceneRows], motorised: Array, objective: Objective, camera_power_w: Array,
    power_limit_w: float | Array, *,
    constant: Array | float, cutoff: float | Array, **more: Any,
) -> Best:  # fmt: skip
    """Best settings over cells of the designs whose quality and price together may win; bounds of the others.

    Rows for bounds are answered with these bounds alone.
    """
    n = len(motorised)
    bound = joint_bound(rows, objective, np.broadcast_to(power_limit_w - camera_power_w, (n,)), constant)
    nothing = np.full(n, np.nan)
    chosen = [closed_form.Chosen(*(nothing.copy() for _ in range(7))) for _ in rows]
    none = Best(chosen, np.zeros(n, bool), nothing, nothing, np.zeros(n), bound)
    if rows[0].optimistic:
        return none
    return searched_where(
        np.isfinite(bound) & (bound <= cutoff), none, rows, motorised, objective, camera_power_w, power_limit_w,
        constant=constant, cutoff=cutoff, **more,
    )  # fmt: skip


def _of_cells(found: CellResult) -> Best:
    """A search over cells as the best settings."""
    return Best(
        found.chosen, found.feasible, found.snr_db, found.contrast, np.nan_to_num(found.information),
        found.lower_bound,
    )  # fmt: skip


def best_where_sharp(
    rows: list[SceneRows], motorised: Array, objective: Objective, camera_power_w: Array,
    power_limit_w: float | Array, *,
    constant: Array | float, cutoff: float | Array, mean_limit: MeanLimit | None, closed_alone: bool = False,
    **more: Any,
) -> Best:  # fmt: skip
    """Best settings whose image is sharp enough as well.

    Without that requirement the closed form holds and is a bound: where its settings happen to be sharp they
    are best; where it finds none, there are none; where it cannot beat the cutoff, neither can sharp settings.
    """
    easy = best_closed(rows, motorised, objective, camera_power_w, power_limit_w, constant, mean_limit)
    lower = easy.lower_bound
    if lower is None:
        lower = np.where(easy.feasible, value_of(easy, objective, constant), np.inf)
    sharp = np.logical_and.reduce([is_sharp(r, c) for r, c in zip(rows, easy.chosen, strict=True)])
    feasible = easy.feasible & sharp
    if closed_alone:
        return replace(easy, feasible=feasible, lower_bound=lower)
    done = feasible
    if any(r.camera_w is not None for r in rows):
        done = feasible & is_close(easy, lower, objective, constant, more["gap_rel"])
    open_ = np.isfinite(lower) & ~done & (lower <= cutoff)
    return searched_where(
        open_, replace(easy, feasible=feasible, lower_bound=lower), rows, motorised, objective, camera_power_w,
        power_limit_w, constant=constant, cutoff=cutoff, mean_limit=mean_limit, **more,
    )  # fmt: skip


def best_in_the_dark(
    rows: list[SceneRows], motorised: Array, objective: Objective, camera_power_w: Array,
    power_limit_w: float | Array, *,
    gap_rel: float, constant: Array | float, cutoff: float | Array, mean_limit: MeanLimit | None, **more: Any,
) -> Best:  # fmt: skip
    """Best settings in closed form; where dark current leaves more than the gap open, searched over cells."""
    easy = best_closed(rows, motorised, objective, camera_power_w, power_limit_w, constant, mean_limit)
    lower = easy.lower_bound
    if lower is None:
        return easy
    close = is_close(easy, lower, objective, constant, gap_rel)
    return searched_where(
        np.isfinite(lower) & ~close & (lower <= cutoff), easy, rows, motorised, objective, camera_power_w,
        power_limit_w, gap_rel=gap_rel, constant=constant, cutoff=cutoff, mean_limit=mean_limit, **more,
    )  # fmt: skip


def is_close(best: Best, lower: Array, objective: Objective, constant: Array | float, gap_rel: float) -> Array:
    """Whether settings are within a relative gap of what none can beat, (n,)."""
    value = np.where(best.feasible, value_of(best, objective, constant), np.inf)
    known = np.where(np.isfinite(lower), lower, 0.0)
    return np.asarray(value - known <= gap_rel * np.maximum(objective.scale(known), NO_RELATIVE_GAP))


def value_of(best: Best, objective: Objective, constant: Array | float) -> Array:
    """The minimised objective of settings, constants included; no sum that holds information."""
    power = np.max([c.light_power_w for c in best.chosen], axis=0)
    value = constant + objective.weight("power") * power
    for name in ("snr_db", "contrast"):
        if objective.weight(name):
            value = value - objective.weight(name) * getattr(best, name)
    return np.asarray(value)


def searched_where(
    which: Array, easy: Best, rows: list[SceneRows], motorised: Array, objective: Objective, camera_power_w: Array,
    power_limit_w: float | Array, *,
    constant: Array | float, cutoff: float | Array, hardware: Array | None, near: Array | None = None, **more: Any,
) -> Best:  # fmt: skip
    """Some designs searched over cells, the others as they are."""
    open_ = np.nonzero(which)[0]
    if len(open_) == 0:
        return easy
    from uwopt.solvers.settings.cells import best_by_cells

    assert easy.lower_bound is not None
    every = easy.feasible.shape
    found = best_by_cells(
        [r.take(open_) for r in rows], motorised[open_], objective, camera_power_w[open_],
        np.broadcast_to(power_limit_w, every)[open_],
        constant=np.broadcast_to(constant, every)[open_],
        cutoff=np.broadcast_to(cutoff, every)[open_],
        hardware=None if hardware is None else hardware[open_], near=None if near is None else near[open_], **more,
    )  # fmt: skip

    def placed(all_: Array, some: Array) -> Array:
        out = np.array(all_)
        out[open_] = some
        return out

    chosen = []
    for r, old, new in zip(rows, easy.chosen, found.chosen, strict=True):
        old = replace(old, exposure_s=r.exposure_s(old.time_s))
        chosen.append(old.put(open_, new))
    return Best(
        chosen, placed(easy.feasible, found.feasible), placed(easy.snr_db, found.snr_db),
        placed(easy.contrast, found.contrast), placed(easy.information, np.nan_to_num(found.information)),
        placed(easy.lower_bound, found.lower_bound),
    )  # fmt: skip


def is_sharp(rows: SceneRows, chosen: closed_form.Chosen) -> Array:
    """Whether the MTF that is asked for holds at these settings, without sun."""
    if not rows.asks_sharpness or rows.sharp is None:
        return np.ones(len(chosen.f_number), bool)
    known = np.isfinite(chosen.f_number) & np.isfinite(chosen.time_s)
    f_number, time = np.where(known, chosen.f_number, 1.0), np.where(known, chosen.time_s, 0.0)
    return np.asarray(known & rows.sharp_enough(f_number=f_number, blur_s=rows.blur_s(time)))


def best_closed(
    rows: list[SceneRows],
    motorised: Array,
    objective: Objective,
    camera_power_w: Array,
    power_limit_w: float | Array,
    constant: Array | float = 0.0,
    mean_limit: MeanLimit | None = None,
) -> Best:
    """Best settings in closed form.

    Dark current depends on the exposure that is chosen, so the closed form is taken again with the
    exposure of the last round, from the shortest up; dark electrons are few, and two or three rounds
    settle it. Least power is settled with its dark electrons where that need not be the joint optimum; where SNR
    counts too, the bound says what is left. Rows for bounds are answered with a bound at once.
    """
    given = (motorised, objective, camera_power_w, power_limit_w, mean_limit)
    if any(r.camera_w is not None for r in rows):
        return best_of_switched_cameras(rows, given, constant)
    if not any(np.any(r.dark_current_e_s > 0) for r in rows):
        return closed_at(rows, settings_at_dark(rows, *given))
    if rows[0].optimistic:
        rows = [dark.relaxed(r) for r in rows]
        return closed_at(rows, settings_at_dark(rows, *given))
    start = rows = [dark.at_time(deciding_pixels(r), r.time_min_s) for r in rows]
    ever = np.zeros(len(motorised), bool)
    for _ in range(DARK_ROUNDS):
        found = settings_at_dark(rows, *given)
        ever |= found[1]
        updated = [closed_form.with_exposure(r, c) for r, c in zip(rows, found[0], strict=True)]
        settled = np.logical_and.reduce(
            [
                np.isclose(windows.dark_e(a), windows.dark_e(b), rtol=1e-12, atol=1e-10)
                for a, b in zip(rows, updated, strict=True)
            ]
        )
        if settled.all():
            break
        rows = updated
    best = closed_at(rows, found)
    best = replace(best, feasible=best.feasible & settled)
    if not objective.weight("snr_db") and not any(r.switched for r in rows):
        bent = np.logical_or.reduce([dark.outruns_light(r) for r in rows])
        sure = dark.surely_least(rows, best.chosen, motorised) if bent.any() else ~bent
        best = with_joint_optimum(best, rows, motorised, ever, which=~bent)
        if mean_limit is not None:
            best = replace(best, feasible=best.feasible & mean_limit.met_by(best.chosen, camera_power_w))
        if not bent.any():
            return best
        value = np.where(best.feasible, value_of(best, objective, constant), np.inf)
        known = np.where(bent & ~(best.feasible & sure), bound_in_the_dark(start, given, constant), value)
        return replace(best, lower_bound=known)
    return replace(best, lower_bound=bound_in_the_dark(start, given, constant))


def best_of_switched_cameras(rows: list[SceneRows], given: Given, constant: Array | float) -> Best:
    """Settings that are best for the lamps, with what cameras draw for their exposures, and a bound without it.

    Where the highest SNR within a power is wanted, the longest exposure is set aside of that power.
    """
    motorised, objective, camera_power_w, power_limit_w, mean_limit = given
    free = [replace(r, camera_w=None) for r in rows]
    found = best_closed(free, motorised, objective, camera_power_w, power_limit_w, constant, mean_limit)
    bound = found.lower_bound
    if bound is None:
        bound = np.where(found.feasible, value_of(found, objective, constant), np.inf)
    if objective.weight("snr_db"):
        most_w = camera_power_w + np.max([r.exposing_w(r.longest_exposure_s) for r in rows], axis=0)
        found = best_closed(free, motorised, objective, most_w, power_limit_w, constant, mean_limit)
    chosen = [
        replace(c, light_power_w=c.light_power_w + r.exposing_w(r.exposure_s(c.time_s)))
        for r, c in zip(rows, found.chosen, strict=True)
    ]
    feasible = found.feasible
    if mean_limit is not None:
        feasible = feasible & mean_limit.met_by(chosen, camera_power_w)
    return replace(found, chosen=chosen, feasible=feasible, lower_bound=bound)


def bound_in_the_dark(rows: list[SceneRows], given: Given, constant: Array | float) -> Array:
    """What no settings can beat, with dark electrons where they help and none where they harm; inf: there are none."""
    free = [dark.relaxed(r) for r in rows]
    bound = closed_at(free, settings_at_dark(free, *given))
    return np.where(bound.feasible, value_of(bound, given[1], constant), np.inf)


def closed_at(rows: list[SceneRows], found: tuple[list[closed_form.Chosen], Array, Array]) -> Best:
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
    chosen, feasible = dark.least_power(some, motorised[open_])
    some = [closed_form.with_exposure(r, c) for r, c in zip(some, chosen, strict=True)]
    joint = closed_at(some, (chosen, feasible, snr_of(some, chosen)))

    def placed(all_: Array, new: Array) -> Array:
        out = np.array(all_)
        out[open_] = new
        return out

    settings = [
        closed_form.Chosen(**{
            name: placed(getattr(old, name), getattr(new, name))
            for name in old.__dataclass_fields__
            if name != "exposure_s"
        })
        for old, new in zip(best.chosen, chosen, strict=True)
    ]  # fmt: skip
    return replace(
        best,
        chosen=settings,
        feasible=placed(best.feasible, feasible),
        snr_db=placed(best.snr_db, joint.snr_db),
    )


def settings_at_dark(
    rows: list[SceneRows],
    motorised: Array,
    objective: Objective,
    camera_power_w: Array,
    power_limit_w: float | Array,
    mean_limit: MeanLimit | None = None,
) -> tuple[list[closed_form.Chosen], Array, Array]:
    """Best settings with the dark electrons of the rows.

    Without SNR in the objective least power is best for every term. With SNR alone the highest reachable
    is found first, then the least power that reaches it. A weighted sum is convex along the SNR floor.
    """
    weight = objective.weight("snr_db")
    if not weight:
        chosen, feasible = closed_form.least_power(rows, motorised)
    else:
        top = closed_form.greatest_snr(rows, motorised, power_limit_w - camera_power_w)
        goal = np.nan_to_num(top, nan=0.0) * (1 - 1e-12)
        if mean_limit is not None:
            goal = mean_limit.highest_snr(rows, motorised, goal, camera_power_w)
        if objective.single is None and objective.weight("power"):
            goal = weighted_goal(rows, motorised, goal, objective.weight("power"), weight)
        chosen, feasible = closed_form.least_power(rows, motorised, snr_floor=goal)
        feasible &= np.isfinite(top)
    if mean_limit is not None:
        feasible &= mean_limit.met_by(chosen, camera_power_w)
    return chosen, feasible, snr_of(rows, chosen)


def snr_of(rows: list[SceneRows], chosen: list[closed_form.Chosen]) -> Array:
    """SNR of settings at the nominal altitude in dB, worst scene; NaN where there is no light."""
    snr = np.min([closed_form.nominal_snr(r, c.light_x) for r, c in zip(rows, chosen, strict=True)], axis=0)
    with np.errstate(invalid="ignore"):
        return np.asarray(ratio_to_db(np.where(snr > 0, snr, np.nan)))


def weighted_goal(
    rows: list[SceneRows], motorised: Array, top: Array, power_weight: float, snr_weight: float
) -> Array:
    """SNR floor that minimises power_weight * power - snr_weight * SNR in dB, by golden section.

    Between the requirement and the reachable top; power is convex in the SNR in dB for lamps that dim
    freely. Lamps with steps are tried at the top of each step as well.
    """

    def merit(snr: Array) -> Array:
        chosen, feasible = closed_form.least_power(rows, motorised, snr_floor=snr)
        power = np.max([c.light_power_w for c in chosen], axis=0)
        got = np.min(
            [closed_form.nominal_snr(r, c.light_x) for r, c in zip(rows, chosen, strict=True)], axis=0
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            value = power_weight * power - snr_weight * ratio_to_db(got)
        return np.where(feasible, value, np.inf)

    start, _ = closed_form.least_power(rows, motorised)
    low = np.min([closed_form.nominal_snr(r, c.light_x) for r, c in zip(rows, start, strict=True)], axis=0)
    low = np.where(np.isfinite(low), np.clip(low, top * FAINTEST, top), top)
    best, best_value = top.copy(), merit(top)
    low_value = merit(low)
    best, best_value = np.where(low_value < best_value, low, best), np.minimum(best_value, low_value)
    a, b = np.log(np.maximum(low, 1e-300)), np.log(np.maximum(top, 1e-300))
    ratio = (np.sqrt(5.0) - 1.0) / 2.0
    c, d = b - ratio * (b - a), a + ratio * (b - a)
    value_c, value_d = merit(np.exp(c)), merit(np.exp(d))
    for _ in range(60):
        left = value_c < value_d
        b, a = np.where(left, d, b), np.where(left, a, c)
        new_c, new_d = b - ratio * (b - a), a + ratio * (b - a)
        value_c, value_d = merit(np.exp(new_c)), merit(np.exp(new_d))
        c, d = new_c, new_d
    for point, value in ((c, value_c), (d, value_d)):
        best, best_value = np.where(value < best_value, np.exp(point), best), np.minimum(best_value, value)
    for step in step_tops(rows, motorised, top):
        value = merit(step)
        best, best_value = np.where(value < best_value, step, best), np.minimum(best_value, value)
    return best


def step_tops(rows: list[SceneRows], motorised: Array, top: Array) -> list[Array]:
    """SNR reached at the top of each step of each scene's light: where a staircase of power may be best."""
    tops = []
    for scene in rows:
        for column in range(scene.levels.shape[1]):
            level = scene.levels[:, column]
            if np.isnan(level).all():
                continue
            capped = [replace(r, max_level=np.fmin(r.max_level, level)) if r is scene else r for r in rows]
            snr = closed_form.greatest_snr(capped, motorised, np.full(len(top), np.inf))
            tops.append(np.where(np.isfinite(snr), np.minimum(snr, top) * (1 - 1e-12), top))
    return tops
