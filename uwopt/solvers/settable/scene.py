"""One scene of one hardware: the best settings among those that can be set, by f-number.

Every setting is tried with the figures and margins of the evaluation itself, all light counted. How far the
worst requirement is missed has no local minima along the time that collects light, so the time is found by
looking at a few, then at a few between the neighbours of the best, down to the microsecond; the light's level
among its marks likewise.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.arrays import Array
from uwopt.deadline import Deadline
from uwopt.evaluation.design_model import DesignModel
from uwopt.evaluation.leaning import LeaningModel
from uwopt.forward.columns import Columns
from uwopt.forward.figures import DesignRows, Figures, SettingRows, figures_of
from uwopt.forward.light_columns import ImageLight
from uwopt.forward.part_columns import FLASH, PULSED
from uwopt.forward.pixels import worst_candidates
from uwopt.mission.reserves import BATTERY_IN_HAND, RECOMMENDED_RESERVE
from uwopt.model.sensor import QUANTISATION_VARIANCE_DN2, light_for_snr
from uwopt.objectives.objective import Objective, Terms
from uwopt.objectives.requirements import LEVEL_TOLERANCE_REL, MarginRows, depth_of_field_margins
from uwopt.solvers.exact.ranking import told_apart
from uwopt.solvers.settable.steps import EDGE, GAIN_STEP_DB, TIME_STEP_S, light_levels, time_steps
from uwopt.solvers.settings.few_pixels import with_those_between
from uwopt.tolerances import SATISFIED_REL
from uwopt.units import db_to_ratio, ratio_to_db

Index = NDArray[np.intp]

TIMES = 12  # looked at a row, before the search goes on between two of them
LEVELS = 9
ROUNDS = 12  # 11 ** 12 is more than there are microseconds in any exposure
HIGHLIGHTS = "saturation_fraction"
PIXELS_ASKED = "min_snr_db"  # the requirement that pixels decide
SHARP_LAST = 1e-6  # weight of a sharpness that is missed: first all else must hold
WORST = 1e290  # stands for an objective that is infinite
MOST_PIXELS = 4_000_000  # figures at pixels that are held at a time
ENOUGH_SNR = float(db_to_ratio(RECOMMENDED_RESERVE["snr_db"])) - 1.0
ENOUGH_BLUR, ENOUGH_DOF = RECOMMENDED_RESERVE["blur"], RECOMMENDED_RESERVE["dof"]
ENOUGH_ELSE = 0.1  # of what good practice knows no reserve for
#: Requirements on images and power that settings may crowd, and how much in hand is enough of each, as a share of what
#: is asked: what good practice keeps in reserve. The ends of what can be set are no room in hand.
ENOUGH = {
    "max_blur_px": ENOUGH_BLUR, "max_skew_px": ENOUGH_BLUR, "dof_near_m": ENOUGH_DOF, "dof_far_m": ENOUGH_DOF,
    "min_dof_m": ENOUGH_DOF, "min_snr_db": ENOUGH_SNR, "min_snr_mean_db": ENOUGH_SNR, "min_snr_red_db": ENOUGH_SNR,
    "min_contrast": ENOUGH_ELSE, "min_mtf_half_nyquist": ENOUGH_ELSE, "resolve_mm": ENOUGH_ELSE,
    "max_airy_px": ENOUGH_ELSE, "power_w": ENOUGH_ELSE, "peak_power_w": ENOUGH_ELSE, "energy_wh": BATTERY_IN_HAND,
    HIGHLIGHTS: ENOUGH_ELSE,
}  # fmt: skip
ROOMY = tuple(ENOUGH)
HIGHLIGHT_STEPS = -float(ratio_to_db(1.0 - ENOUGH[HIGHLIGHTS])) / GAIN_STEP_DB  # of gain that leave so much
PLENTY = 0.5  # of a limit: what is in hand beyond it decides nothing
FULL = 1.0 + PLENTY  # of what is in hand as it is noted: that it is enough counts 1
SNR_DIGITS = 1  # of decibels, where nothing else tells settings apart
ROOM_DIGITS = 6  # of a share of a limit: what differs by rounding alone decides nothing
ROOM_STEP = 0.005  # of a limit: what is in hand alike to a two-hundredth decides nothing
POWER_STEP = 0.01  # of power likewise: a shutter that closes sooner saves nothing worth dim images
EVERY = slice(None)
BALANCES = 13  # of lamps against sun, at which the worst pixels are looked for
OPEN_LONGER = (0.0, 0.5, 1.0)  # of the optimum's open shutter beyond the pulse, under the sun


@dataclass(frozen=True)
class Near:
    """The goal of settings that stay as near to the optimum's own as can be set: in power, and in figures of images."""

    figures: tuple[str, ...] = ("snr_db",)  # of snr_db, contrast and information

    def away(self, tried: Tried, exact: Tried) -> Array:
        """How far settings are from the optimum in all of these, the sum of their ratios as e-folds, (n,)."""
        ratios = [tried.power_w / exact.power_w]
        for name in self.figures:
            there, here = getattr(tried, name), getattr(exact, name)
            ratios.append(db_to_ratio(there - here) if name == "snr_db" else there / here)
        return np.sum([np.abs(np.nan_to_num(np.log(ratio))) for ratio in ratios], axis=0)


@dataclass(frozen=True)
class Tried(Columns):
    """Settings and what the evaluation says of them."""

    settings: SettingRows
    shortfall: Array  # of the requirement that is missed most, as a share of its size; 0: all hold
    value: Array  # less is better; inf where a requirement is missed
    in_hand: Array  # of each requirement that settings may crowd, as `note_room` has it, the least first (n, k)
    away: Array  # of time and f-number from the optimum's, in e-folds of light
    power_w: Array
    snr_db: Array
    contrast: Array
    information: Array

    def best_of_each(self, group: Index) -> Index:
        """The best row of each group, in the groups' order: least missed, best; of equals one with enough in hand of
        each limit or as near that as can be, then of least power, then farthest from its limits, then of the most
        signal to noise, then nearest the optimum: gain stands in for no light that the sun gives for nothing."""
        value = told_apart(np.minimum(self.value, WORST))
        alike = np.round(self.in_hand / ROOM_STEP)
        enough, crowded = (tuple(-seen.T[::-1]) for seen in (np.minimum(alike, 1.0 / ROOM_STEP), alike))
        noise = -np.round(self.snr_db, SNR_DIGITS)
        power = np.round(np.log(np.maximum(self.power_w, 1.0 / WORST)) / POWER_STEP)
        finer = tuple(-self.in_hand.T[::-1])
        order = np.lexsort((self.away, noise, *finer, *crowded, power, *enough, value, self.shortfall, group))
        return np.asarray(order[np.unique(group[order], return_index=True)[1]])


class SettableScene:
    """What can be set in one scene, tried by the thousand."""

    def __init__(
        self, model: DesignModel, index: int, exact: SettingRows, objective: Objective | Near, *,
        rate_hz: float, dioptre_per_m: float, leaner: Sequence[DesignModel], deadline: Deadline,
    ):  # fmt: skip
        """Trying raises OutOfTimeError past the deadline."""
        self.deadline = deadline
        self.model, self.index, self.exact, self.objective = few_pixels(model, index), index, exact, objective
        self.rate_hz, self.dioptre_per_m = rate_hz, dioptre_per_m
        self.kind = int(model.lights.kind[0])
        self.levels = light_levels(model.lights)
        self.needs = model.problem.scenes[index].view.requirements
        least, most = model.problem.gains(index, model.cameras.max_gain)
        n_gains = max(int(_db(most[0] / least) / GAIN_STEP_DB + EDGE), 0) + 1
        self.gains = least * db_to_ratio(np.arange(n_gains) * GAIN_STEP_DB)
        self.at_exact = self._figures(exact)
        self.models = [self.model, *(few_pixels(lean, index) for lean in leaner)]
        self.rows = self.model.rows[index]
        self.means = [means_alone(one.rows_at(index, dioptre_per_m)) for one in self.models]

    # ------------------------------------------------------------ what there is to try

    def keep_depth(self, stops: Array) -> NDArray[np.bool_]:
        """Which f-numbers keep the wanted depth sharp and the lens as far closed as asked; no light changes that."""
        tried = self._settings(stops, np.ones(len(stops)), np.ones(len(stops)), np.zeros(len(stops)))
        scene = self.model.problem.scenes[self.index]
        margins = depth_of_field_margins(scene, figures_of(scene, self.means[0], tried))
        widest = float(self.model.lenses.f_number_from(self.needs.lens_stop_down)[0])
        return np.logical_and.reduce([m.satisfied for m in margins], axis=0) & (stops >= widest * (1 - EDGE))

    def best_by_stop(self, stops: Array) -> Tried:
        """The best settings at each of these f-numbers."""
        each = np.arange(len(stops))
        tried = [self._first_levels(float(stop)) for stop in stops]
        best = self._over_levels(stops, tried)
        while True:
            at = [int(np.abs(self.levels - level).argmin()) for level in best.settings.level]
            more = [self._between(seen, middle) for seen, middle in zip(tried, at, strict=True)]
            if not any(len(m) for m in more):
                return best
            found = self._over_levels(stops, more)
            place = np.concatenate([each, np.flatnonzero([len(m) > 0 for m in more])])
            both = Tried.joined([best, found])
            best = both.take(both.best_of_each(place))
            tried = [np.union1d(seen, new) for seen, new in zip(tried, more, strict=True)]

    def _first_levels(self, f_number: float) -> Index:
        """Marks around the level that gives the optimum's light at this f-number, and some over the whole range."""
        top = len(self.levels) - 1
        alike = float(self.exact.level[0]) * (f_number / float(self.exact.f_number[0])) ** 2
        near = int(np.searchsorted(self.levels, alike * (1 - EDGE)))
        spread = np.unique(np.round(np.geomspace(1, top + 1, min(LEVELS, top + 1))).astype(int) - 1)
        return np.union1d(np.clip(np.arange(near - 1, near + 2), 0, top), spread)

    def _between(self, tried: Index, middle: int) -> Index:
        """Marks not tried yet between the neighbours of one that was."""
        place = int(np.searchsorted(tried, middle))
        low, high = tried[max(place - 1, 0)], tried[min(place + 1, len(tried) - 1)]
        open_marks = np.setdiff1d(np.arange(low, high + 1), tried)
        few = np.linspace(0, len(open_marks) - 1, min(LEVELS, len(open_marks))).astype(int)
        return np.asarray(open_marks[np.unique(few)])

    def _over_levels(self, stops: Array, marks: list[Index]) -> Tried:
        """The best at each stop that has marks to try, in the order of the stops."""
        longer = self._open_longer_s()
        stop = np.repeat(np.arange(len(stops)), [len(m) * len(longer) for m in marks])
        levels = np.concatenate([np.repeat(self.levels[m], len(longer)) for m in marks])
        extra = np.tile(longer, sum(len(m) for m in marks))
        tried = self._best_times(stops[stop], levels, extra)
        return tried.take(tried.best_of_each(stop))

    def _open_longer_s(self) -> Array:
        """Times that the shutter may stay open beyond a pulse: more than none only where the sun adds light."""
        if self.kind != PULSED or self.rows.sun is None:
            return np.zeros(1)
        shut = float(self.exact.pulse_s[0] + self.model.cameras.readout_s[0])
        return np.unique(max(float(self.exact.exposure_s[0]) - shut, 0.0) * np.array(OPEN_LONGER))

    def _step_range(self) -> tuple[float, float]:
        """Fewest and most microseconds of the time that is varied: the pulse of an LED, else the exposure."""
        cam, lights = self.model.cameras, self.model.lights
        limit = self.model.problem.mission.limits.max_exposure_ms * 1e-3
        longest = min(float(cam.max_exposure_s[0]), limit, 1.0 / self.rate_hz if self.rate_hz > 0 else np.inf)
        shortest, readout = float(cam.min_exposure_s[0]), float(cam.readout_s[0])
        if self.kind == PULSED:
            duty = float(lights.max_duty[0]) / self.rate_hz if self.rate_hz > 0 else np.inf
            shortest, longest = (
                float(lights.min_pulse_s[0]),
                min(float(lights.max_pulse_s[0]), duty, longest - readout),
            )
        elif self.kind == FLASH and readout > 0:
            shortest = max(shortest, float(lights.flash_duration_s[0]) + readout)
        low = max(np.ceil(shortest / TIME_STEP_S * (1 - EDGE)), 1.0)
        return float(low), float(max(np.floor(longest / TIME_STEP_S * (1 + EDGE)), low))

    # ------------------------------------------------------------ trying it

    def _best_times(self, f_number: Array, level: Array, extra_s: Array) -> Tried:
        """The best time of each row, with its gain."""
        count = len(f_number)
        low, high = (np.full(count, end) for end in self._step_range())
        best: Tried | None = None
        for _ in range(ROUNDS):
            self.deadline.check()
            steps = spread_steps(low, high)
            new = steps if best is None else steps[:, 1:-1]  # the ends were not the best of the last
            row = np.repeat(np.arange(count), new.shape[1])
            best = self._with_gains(f_number[row], new.ravel(), level[row], extra_s[row], row, best)
            at = np.abs(steps - self._steps_of(best)[:, None]).argmin(axis=1)
            every = np.arange(count)
            if (high - low < TIMES).all():
                break
            low, high = steps[every, np.maximum(at - 1, 0)], steps[every, np.minimum(at + 1, TIMES - 1)]
        assert best is not None
        return best

    def _steps_of(self, tried: Tried) -> Array:
        """Microseconds of the time that is varied."""
        time = tried.settings.pulse_s if self.kind == PULSED else tried.settings.exposure_s
        return np.asarray(np.round(time / TIME_STEP_S))

    def _with_gains(
        self, f_number: Array, steps: Array, level: Array, extra_s: Array, row: Index, known: Tried | None
    ) -> Tried:
        """The best of these rows for each group, at the gains that suit them, and of what was known of it."""
        settings = self._settings(f_number, steps, level, extra_s)
        gains = self._gains(settings)
        every = np.tile(np.arange(len(row)), len(gains))
        tried, group = self._judged(replace(settings.take(every), gain=np.concatenate(gains))), row[every]
        if known is not None:
            tried, group = Tried.joined([known, tried]), np.concatenate([np.unique(row), group])
        return tried.take(tried.best_of_each(group))

    def _settings(self, f_number: Array, steps: Array, level: Array, extra_s: Array) -> SettingRows:
        """Settings at unit gain."""
        cam, one = self.model.cameras, np.ones(len(steps))
        time = steps * TIME_STEP_S
        exposure, pulse = time, np.inf * one
        if self.kind == FLASH:
            pulse = float(self.model.lights.flash_duration_s[0]) * one
        if self.kind == PULSED:
            open_s = np.maximum(time + float(cam.readout_s[0]) + extra_s, float(cam.min_exposure_s[0]))
            exposure = time_steps(np.ceil(open_s / TIME_STEP_S - 1e-6), up=True) * TIME_STEP_S
            pulse = time
        rate, dioptre = self.rate_hz * one, self.dioptre_per_m * one
        return SettingRows(f_number, exposure, pulse, one, level, rate, dioptre)

    def _gains(self, settings: SettingRows) -> list[Array]:
        """The highest gain that does not saturate, and that leaves highlights enough in hand.

        Of a wanted mean level the steps on either side, nearest first.
        """
        cam, scene = self.model.cameras, self.model.problem.scenes[self.index]
        full, black = float(2.0 ** cam.bits[0] - 1.0), float(cam.black_level_dn[0])
        wanted = self.needs.mean_level
        figures = [figures_of(scene, rows, settings) for rows in self.means]
        seen = [(one.bright_level if wanted is None else one.mean_level) * full - black for one in figures]
        reached = np.max(seen, axis=(0, 2)) if wanted is None else seen[0][:, scene.nominal]
        target = (full / self.needs.highlight_ratio if wanted is None else wanted * full) - black
        with np.errstate(divide="ignore", invalid="ignore"):
            steps = np.nan_to_num(_db(target / reached / self.gains[0]) / GAIN_STEP_DB, nan=0.0)
        top = len(self.gains) - 1
        lower = np.clip(np.floor(steps + EDGE), 0, top)
        nearest = np.clip(np.round(steps), 0, top)
        other = np.where(nearest > lower, lower, np.minimum(lower + 1, top))
        roomy = np.clip(np.floor(steps - HIGHLIGHT_STEPS + EDGE), 0, top)
        picks = [lower, roomy] if wanted is None else [nearest, other]
        return [self.gains[pick.astype(int)] for pick in picks]

    def _judged(self, settings: SettingRows) -> Tried:
        """Figures and margins; what is dear only of settings where all else holds: each pixel, then sharpness."""
        scene, asks_sharpness = self.model.problem.scenes[self.index], self.needs.asks_sharpness
        figures = [figures_of(scene, rows, settings) for rows in self.means]
        of_pixels = self.rows.light.worst_e is not None
        rooms = np.full((len(settings.f_number), len(ROOMY)), FULL)
        shortfall = self._shortfall(settings, figures, rooms=rooms, without=PIXELS_ASKED if of_pixels else "")
        if of_pixels:
            self._add_pixels(settings, shortfall, rooms)
        if asks_sharpness and not scene.paper and (rest := np.nonzero(shortfall == 0.0)[0]).size:
            few = settings.take(rest)
            sharp = [model.figures(self.index, few) for model in self.models]
            shortfall[rest] = SHARP_LAST * self._shortfall(few, sharp, rooms=rooms, at=rest)
        terms = self._terms(settings, figures[0], shortfall == 0.0)
        made = replace(terms, in_hand=least_first(rooms))
        return replace(made, shortfall=shortfall, value=np.where(shortfall == 0.0, self._value(made), np.inf))

    def _add_pixels(self, settings: SettingRows, shortfall: Array, rooms: Array) -> None:
        """Fill in how far pixels miss their SNR where nothing else is missed, some thousand rows at a time."""
        scene, worst = self.model.problem.scenes[self.index], self.rows.light.worst_e
        assert worst is not None
        rest, each = np.nonzero(shortfall == 0.0)[0], max(MOST_PIXELS // worst.size, 1)
        for first in range(0, len(rest), each):  # none where all miss something else
            some = rest[first : first + each]
            few = settings.take(some)
            seen = [figures_of(scene, model.rows_at(self.index, self.dioptre_per_m), few) for model in self.models]
            shortfall[some] = self._shortfall(few, seen, rooms=rooms, at=some)

    def _shortfall(
        self, settings: SettingRows, by_model: Sequence[Figures], *, rooms: Array, without: str = "",
        at: Index | slice = EVERY,
    ) -> Array:  # fmt: skip
        """How far the requirement that is missed most is missed, in any of the models; one may be left out.

        What is left of each of `ROOMY`, in the model that leaves least, is noted in `rooms`, of rows `at` these places.
        """
        worst = np.zeros(len(settings.f_number))
        left = np.full((len(worst), len(ROOMY)), FULL)
        for model, figures in zip(self.models, by_model, strict=True):
            for margin in model.margins(
                self.index, settings, figures, level_tolerance_rel=LEVEL_TOLERANCE_REL
            ):
                if margin.requirement == without:
                    continue
                note_room(left, margin)
                if not margin.is_clear:
                    worst = np.maximum(worst, margin.shortfall)
        rooms[at] = left
        return worst

    def _figures(self, settings: SettingRows) -> Tried:
        """The figures that objectives are made of."""
        every = np.ones(len(settings.f_number), bool)
        return self._terms(settings, self.model.figures(self.index, settings), every)

    def _terms(self, settings: SettingRows, figures: Figures, feasible_so_far: NDArray[np.bool_]) -> Tried:
        """Figures of the objective; information, which is dear, only where it matters."""
        count, nominal = len(settings.f_number), self.model.problem.scenes[self.index].nominal
        information = np.zeros(count)
        if counts(self.objective, "information") and feasible_so_far.any():
            some = self.model.figures(
                self.index, settings.take(np.nonzero(feasible_so_far)[0]), information=True
            )
            assert some.information_bit_per_m2 is not None
            information[feasible_so_far] = some.information_bit_per_m2
        power = np.broadcast_to(self.model.totals(figures)["power_w"], (count,))
        snr_db = np.asarray(ratio_to_db(np.maximum(figures.snr[:, nominal], 1e-300)))
        none, away, unknown = np.zeros(count), self._away(settings), np.full((count, len(ROOMY)), FULL)
        contrast = figures.contrast[:, nominal]
        return Tried(settings, none, none, unknown, away, power, snr_db, contrast, information)

    def _away(self, settings: SettingRows) -> Array:
        """How far time and f-number are from the optimum's: among equals the nearest is no surprise."""
        time = np.abs(np.log(settings.exposure_s / self.exact.exposure_s))
        return np.asarray(time + 2.0 * np.abs(np.log(settings.f_number / self.exact.f_number)))

    def _value(self, tried: Tried) -> Array:
        """The objective, or how far settings are from the optimum's."""
        if isinstance(self.objective, Near):
            with np.errstate(divide="ignore", invalid="ignore"):
                return self.objective.away(tried, self.at_exact)
        return self.objective.cost_to_minimise(terms_of([tried]))


def counts(goal: Objective | Near, name: str) -> bool:
    """Whether a figure of images decides what settings are taken."""
    return name in goal.figures if isinstance(goal, Near) else bool(goal.weight(name))


def note_room(left: Array, margin: MarginRows) -> None:
    """Note what is left of one of `ROOMY` as a share of its limit, (n, len(ROOMY)); of decibels as a ratio.

    No more than `PLENTY`, and 1 more where it is enough: where what is left, with the reserve that the limit keeps
    already, is as great a share of what is asked as `ENOUGH`. Highlights need no more than that: a step of gain that is
    lost or won decides nothing else.
    """
    name = margin.requirement.partition(" (")[0]
    if name not in ROOMY or margin.sense not in ("<=", ">="):
        return
    share = share_left(margin, margin.margin, margin.limit)
    asked = margin.limit + margin.reserve if margin.sense == "<=" else margin.limit - margin.reserve
    enough = share_left(margin, margin.margin + margin.reserve, asked) >= ENOUGH[name] - SATISFIED_REL
    if name == HIGHLIGHTS:
        share = np.where(enough, PLENTY, share)
    column = ROOMY.index(name)
    left[:, column] = np.minimum(left[:, column], np.minimum(share, PLENTY) + enough)


def share_left(margin: MarginRows, room: Array, limit: Array) -> Array:
    """Room to a limit as a share of it, (n,); of decibels as a ratio, and all there can be where nothing is asked."""
    if margin.unit == "dB":
        return np.asarray(np.where(np.isfinite(room), db_to_ratio(room) - 1.0, np.where(room < 0.0, 0.0, PLENTY)))
    size = np.maximum(np.abs(limit), 1e-300)
    return np.asarray(np.where(np.isfinite(room) & np.isfinite(size), room / size, np.where(room < 0.0, 0.0, PLENTY)))


def least_first(rooms: Array) -> Array:
    """What is in hand of each row's requirements, the least first, (n, len(ROOMY)).

    Compared one after the other the least is made greatest, and where settings do not change that the next.
    """
    return np.sort(np.clip(rooms, 0.0, FULL).round(ROOM_DIGITS), axis=1)


def few_pixels(model: DesignModel, index: int) -> DesignModel:
    """The model with the pixels alone that may decide: by lamps alone, or by some balance of lamps and sun.

    What is found with them is evaluated with all.
    """
    rows = model.rows[index]
    lamp, sun = rows.light, rows.sun
    if lamp.worst_e is None:
        return model
    if sun is None or sun.worst_e_s is None or not sun.worst_e_s.mean() > 0:
        light = deciding_light(model, index, lamp, lamp.worst_e)
        return model if light is lamp else with_rows(model, index, replace(rows, light=light))
    if lamp.may_miss:  # then the darkest ones do not tell
        return model
    with np.errstate(divide="ignore"):
        share = np.nan_to_num(sun.worst_e_s.mean() / lamp.worst_e.mean(), posinf=1.0)
    keep = np.unique(np.concatenate([
        worst_candidates(
            lamp.worst_e * share * balance + sun.worst_e_s,
            None if sun.worst_veil_e_s is None else
            (0.0 if lamp.worst_veil_e is None else lamp.worst_veil_e * share * balance) + sun.worst_veil_e_s,
        )
        for balance in (0.0, *np.geomspace(1e-3, 1e3, BALANCES))
    ]))  # fmt: skip
    return with_rows(model, index, replace(rows, light=only_pixels(lamp, keep), sun=only_pixels(sun, keep)))


def with_rows(model: DesignModel, index: int, rows: DesignRows) -> DesignModel:
    """The model with other rows of one scene."""
    made = copy(model)
    made.rows = list(model.rows)
    made.rows[index] = rows
    return made


def deciding_light(model: DesignModel, index: int, lamp: ImageLight, worst_e: Array) -> ImageLight:
    """Lamps' light with those pixels alone of which one decides whether the SNR holds, at any settings.

    What a pixel asks for grows with the noise that comes without light, least of all without quantisation and dark
    current, most of all at the lowest gain and the longest exposure: see `few_pixels.may_decide`.
    """
    scene, cam = model.problem.scenes[index], model.cameras
    needs = scene.view.asked if isinstance(model, LeaningModel) else scene.view.requirements
    wanted = needs.min_snr_there
    if not wanted or worst_e.shape[2] == 1 or needs.resolve_mm is not None:  # bars must arrive at other pixels
        return lamp
    longest_s = min(float(cam.max_exposure_s[0]), model.problem.mission.limits.max_exposure_ms * 1e-3)
    always = float(cam.read_noise_e[0]) ** 2
    dark_e = float(cam.dark_current_e_s[0]) * longest_s
    most = always + QUANTISATION_VARIANCE_DN2 / float(cam.gain_dn_per_e[0]) ** 2 + dark_e
    veil = 0.0 if lamp.worst_veil_e is None else lamp.worst_veil_e
    asked = [
        np.asarray(light_for_snr(
            wanted, signal_per_light_e=worst_e, total_per_light_e=worst_e + veil, read_noise_e=noise_e2**0.5,
            prnu_frac=float(cam.prnu_frac[0]),
        ))
        for noise_e2 in (always, most)
    ]  # fmt: skip
    return with_those_between(lamp, *asked)


def means_alone(rows: DesignRows) -> DesignRows:
    """The rows without pixels."""
    return replace(rows, light=replace(rows.light, worst_e=None, worst_veil_e=None))


def only_pixels(light: Any, keep: Index) -> Any:
    """Light of lamps or sun with some of its pixels."""
    columns = {f.name: getattr(light, f.name) for f in fields(light)}
    of_pixels = {k: c for k, c in columns.items() if isinstance(c, np.ndarray) and k.startswith("worst")}
    return replace(light, **{k: c[:, :, keep] for k, c in of_pixels.items()})


def terms_of(scenes: list[Tried]) -> Terms:
    """Terms of the objective over scenes, the worst of each; what hardware alone decides is left at 0."""
    none = np.zeros(len(scenes[0].power_w))
    return Terms(
        power=np.max([s.power_w for s in scenes], axis=0), cost=none, mass=none,
        snr_db=np.min([s.snr_db for s in scenes], axis=0), gsd_mm=none,
        contrast=np.min([s.contrast for s in scenes], axis=0),
        information=np.min([s.information for s in scenes], axis=0),
    )  # fmt: skip


def spread_steps(low: Array, high: Array) -> Array:
    """Whole numbers from low to high, (n, TIMES): all of them where there are few, else at equal ratios."""
    share = np.linspace(0.0, 1.0, TIMES)
    ratio = np.exp(np.log(low)[:, None] * (1 - share) + np.log(high)[:, None] * share)
    all_of_them = np.minimum(low[:, None] + np.arange(TIMES), high[:, None])
    steps = np.where(
        (high - low < TIMES)[:, None], all_of_them, np.clip(np.round(ratio), low[:, None], high[:, None])
    )
    return time_steps(steps)


def _db(ratio: Array | float) -> Array:
    return np.asarray(ratio_to_db(ratio))
