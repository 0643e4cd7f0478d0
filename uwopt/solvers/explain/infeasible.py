"""Why nothing fits: the cascade of rules, what each single requirement costs, and the nearest miss.

Each requirement is dropped in turn and searched without until a first design fits (`relaxed`): where one does, its
figure is made as good as the others allow, or its limit drawn in as far as something still fits (`least_change`): the
smallest relaxation that makes the mission feasible.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

from uwopt.catalog.catalogue import Catalog
from uwopt.deadline import NEVER, Deadline
from uwopt.evaluation.design import evaluate_design
from uwopt.forward.assembly import Generic
from uwopt.forward.designs import Hardware
from uwopt.mission.mission import Mission
from uwopt.mission.reserves import REFUSED, asked_when_held
from uwopt.objectives.objective import Objective
from uwopt.results.basis import Excluded, Moved, Relaxed, WhyNothing
from uwopt.results.design import Design
from uwopt.results.result import Certificate
from uwopt.solvers.explain.contradiction import contradiction
from uwopt.solvers.explain.least_change import (
    Change,
    least_change,
    rounded_away,
    same_hardware,
    with_its_hardware,
)
from uwopt.solvers.explain.moves import Mover
from uwopt.solvers.explain.nearest_fit import nearest_fit
from uwopt.solvers.explain.one_hardware import problem_of
from uwopt.solvers.explain.relaxed import MAY_PASS, Relaxer
from uwopt.solvers.recommend import Progress, Sought, seek
from uwopt.solvers.settable.rounding import given_of
from uwopt.units import ratio_to_db

# Requirement -> (section, key, objective that makes its figure best, or None when none does)
RELAXABLE: dict[str, tuple[str, str, str | None]] = {
    "min_snr": ("requirements", "min_snr_db", "snr_db"),
    "min_snr_red_db": ("requirements", "min_snr_red_db", None),
    "max_white_balance": ("requirements", "max_white_balance", None),
    "max_gsd_mm": ("requirements", "max_gsd_mm", "gsd_mm"),
    "min_swath_m": ("requirements", "min_swath_m", None),
    "min_common_swath_m": ("requirements", "min_common_swath_m", None),
    "max_depth_error_mm": ("requirements", "max_depth_error_mm", None),
    "min_dof_m": ("requirements", "min_dof_m", None),
    "max_blur_px": ("requirements", "max_blur_px", None),
    "max_skew_px": ("requirements", "max_skew_px", None),
    "max_airy_px": ("requirements", "max_airy_px", None),
    "max_gain_db": ("requirements", "max_gain_db", None),
    "lens_stop_down": ("requirements", "lens_stop_down", None),
    "overlap": ("requirements", "overlap", None),
    "mean_level": ("requirements", "mean_level", None),
    "min_contrast": ("requirements", "min_contrast", "contrast"),
    "min_uniformity": ("requirements", "min_uniformity", None),
    "min_mtf_half_nyquist": ("requirements", "min_mtf_half_nyquist", None),
    "resolve_mm": ("requirements", "resolve_mm", None),
    "cost": ("limits", "cost", "cost"),
    "power_w": ("limits", "power_w", "power"),
    "peak_power_w": ("limits", "peak_power_w", None),
    "mass_kg": ("limits", "mass_kg", "mass"),
    "data_rate_mb_s": ("limits", "data_rate_mb_s", None),
    "energy_wh": ("limits", "energy_wh", None),
    "storage_gb": ("limits", "storage_gb", None),
    "depth_rating_m": ("limits", "depth_rating_m", None),
}


@dataclass(frozen=True)
class Relaxation:
    """A requirement whose loss alone makes the mission feasible."""

    name: str
    limit: float | None
    needed: float | None
    miss_rel: float
    design: Design
    fits_at_central_prices: bool = False


@dataclass(frozen=True)
class Without:
    """The mission without one requirement, and a design that meets the rest."""

    name: str
    limit: float  # as asked
    mission: Mission
    found: Sought
    at_central_prices: bool = False  # the limit of cost is kept, but for estimated prices at their high ends


ANY = Objective.of("power")  # where any design that fits will do: by no other objective takes a search less
BRIGHT = Objective.of("snr_db")  # but without an SNR to ask for, where least power would try what is too dark first
BOUNDED = ("light", "max_white_balance", "bound", "power_w", "energy_wh", "cost", "mass_kg")
LEAST_SNR_DB = 0.0  # below which noise is more than signal, and no image is of use
TURN = 0.25  # of the time left: what one requirement may take of it
MOVES_SHARE = 0.35  # of the time, for speed, water and altitude
UNKNOWN = 1e9  # how far a limit is missed, where that cannot be said
KEPT = frozenset({"mean_level", "lens_stop_down"})  # neither more nor less of these is weaker by a share
SHARES = 5  # by which all limits together are tried to give
ROUNDS = 4  # of the time that is left, as long as nothing helps
LONG_TURN = 0.5  # the same of the question whether all would fit at central prices


@dataclass
class Explanation:
    """What would help a mission that nothing meets; what is known when time ends, or when a person interrupts, stays.

    First every requirement is dropped, then the limits of those that help are drawn in. `like` is the search
    that found nothing, whose light is known.
    """

    mission: Mission
    catalog: Catalog
    objective: Objective
    generic: Generic
    deadline: Deadline = NEVER
    progress: Progress | None = None
    like: Sought | None = None
    interrupted: bool = False

    @cached_property
    def relaxer(self) -> Relaxer:
        """What the searches share."""
        return Relaxer(self.mission, self.catalog, self.generic, self.like)

    def told(self, certificate: Certificate) -> WhyNothing:
        """The part of a result."""
        moves = self._moves()
        relaxations = sorted(self.relaxations(), key=lambda r: r.miss_rel)
        requirements = [
            Excluded(item.rule, item.count, item.rule in BOUNDED)
            for item in certificate.discarded
            if item.count
        ]
        helpful = [Relaxed(r.name, r.limit, r.needed, r.miss_rel, r.fits_at_central_prices) for r in relaxations]
        by_size = any(item.rule.startswith("housing") and item.count for item in certificate.discarded)
        fit = nearest_fit(self.relaxer) if by_size and not self.interrupted else None
        if relaxations or self.interrupted:
            together, nearest = list[Relaxed](), relaxations[0].design if relaxations else None
        else:
            together, nearest = self._together()
        clash = self._contradiction({r.name for r in relaxations})
        if relaxations:
            together = self._smaller_together(relaxations[0].miss_rel)
        return WhyNothing(requirements, helpful, nearest, together, fit, moves, clash)

    def _moves(self) -> list[Moved]:
        """Keys that are no requirements, of which one moved alone would help."""
        some = self.deadline.at_most(MOVES_SHARE * self.deadline.left_s)
        self._say(0.0, "another speed, water or altitude")
        try:
            made = Mover(self.mission, self.catalog, self.generic, some, self.relaxer.problem).all()
        except KeyboardInterrupt:
            self.interrupted = True
            return []
        self.deadline.left_out.extend(some.left_out)
        return made

    def _contradiction(self, helpful: Collection[str]) -> list[str]:
        """Requirements that contradict each other, none too many; none where there is no time to know."""
        if self.interrupted or self.deadline.passed():
            return []

        def fits(left_out: Collection[str]) -> bool | None:
            found = self._seek_without(left_out)
            return None if found is None else bool(found.outcome.best)

        self._say(0.95, "which requirements contradict each other")
        return contradiction([name for name in self._asked() if name in MAY_PASS], helpful, fits) or []

    def _together(self) -> tuple[list[Relaxed], Design | None]:
        """Requirements of which all have to give for a system to fit, as far as there is time, and that system."""
        limits = {name: limit for name, limit in self._asked().items() if name in MAY_PASS}
        found = self._first_of_all(limits)
        if found is None:
            return [], None
        given, needed = missed_by(judged_by(self.mission, found, self.objective), limits), set[str]()
        while given - needed:
            name = min(given - needed, key=list(limits).index)
            others = self._seek_without(given - {name})
            if others is None:
                self.deadline.left_out.append("whether fewer changes together would do")
                break
            if others.outcome.best:
                found = others
                given = missed_by(judged_by(self.mission, found, self.objective), limits)
            else:
                needed.add(name)
        return self._drawn_in({name: limits[name] for name in limits if name in given}, found)

    def _smaller_together(self, alone: float) -> list[Relaxed]:
        """Changes that help together, each a smaller share of what is asked than any that helps alone.

        All limits give by the same share, which is halved as long as something fits; of the hardware that is left
        each limit is drawn in as far as it can be. What is told has been solved; nothing where no less than the
        share that helps `alone` is known to do.
        """
        asked = self._asked().items()
        limits = {name: limit for name, limit in asked if name in MAY_PASS and limit and name not in KEPT}
        if self.interrupted or len(limits) < 2 or not math.isfinite(alone) or alone >= UNKNOWN:
            return []
        self._say(0.97, "smaller changes together")
        low, high, found = 0.0, alone, None
        for _ in range(SHARES):
            share, others = 0.5 * (low + high), None
            if not self.deadline.passed():
                others = self._seek_weaker(limits, share)
            if others is None:
                self.deadline.left_out.append("whether smaller changes together would do")
                break
            low, high, found = (low, share, others) if others.outcome.best else (share, high, found)
        if found is None or self.interrupted:
            return []
        made = self._no_more_than(limits, weaker_by(high, limits), found)
        return made if len(made) > 1 and max(one.miss_rel for one in made) < alone else []

    def _no_more_than(self, asked: dict[str, float], weaker: Mapping[str, float], found: Sought) -> list[Relaxed]:
        """What a design's hardware needs of limits that all give by a share: of each in turn as little as will do."""
        kept: dict[str, float | None] = dict(weaker)
        for name, limit in asked.items():
            wanted = partial(self._with_limits, asked, kept, name)
            as_asked = same_hardware(found, wanted(limit))
            if as_asked.outcome.best:
                kept[name], found = limit, as_asked
            else:
                change = with_its_hardware(limit, Change(weaker[name], found), wanted, self.deadline)
                kept[name], found = change.limit, change.found
        return [Relaxed(name, asked[name], kept[name], miss(asked[name], kept[name])) for name in asked
                if kept[name] != asked[name]]  # fmt: skip

    def _seek_weaker(self, limits: dict[str, float], share: float) -> Sought | None:
        """A search with every limit weaker by a share of itself; None where it ends before it knows."""
        (name, value), *_ = weaker = [*weaker_by(share, limits).items()]
        mission = self._with_limits(limits, dict(weaker), name, value)
        found = self.relaxer.seek(mission, ANY, set(limits), deadline=self._turn(), enough=True)
        self.interrupted |= found.outcome.interrupted
        return found if found.outcome.best or found.outcome.complete else None

    def _drawn_in(self, asked: dict[str, float], found: Sought) -> tuple[list[Relaxed], Design]:
        """What a design's hardware can keep of limits that give together: of each in turn as much as can be."""
        design = judged_by(self.mission, found, self.objective)
        kept: dict[str, float | None] = dict.fromkeys(asked)
        for name, limit in asked.items():
            key = RELAXABLE[name][1]
            reached = reached_value(design, key)
            if reached is not None:
                far = rounded_away(asked_when_held(self.mission.reserve, key, reached), limit)
                wanted = partial(self._with_limits, asked, kept, name)
                change = with_its_hardware(limit, Change(far, found), wanted, self.deadline)
                kept[name], found = change.limit, change.found
        told = [Relaxed(name, limit, kept[name], miss(limit, kept[name])) for name, limit in asked.items()]
        return told, judged_by(self.mission, found, self.objective)

    def _with_limits(
        self, asked: Mapping[str, float], kept: Mapping[str, float | None], name: str, value: float
    ) -> Mission:
        """The mission with other limits, one of them this; those that are not known yet are left out."""
        mission = self.mission
        for one, limit in ({**kept, name: value}).items():
            section, key, _ = RELAXABLE[one]
            weaker = without(mission, section, key) if limit is None else None
            if limit is not None:
                weaker = with_limit(mission, section, key, asked[one], limit)
            mission = weaker or mission
        return mission

    def _first_of_all(self, names: Collection[str]) -> Sought | None:
        """A design that fits where many requirements are dropped: of imagers that fit if there are any, else of all."""
        few = [name for name in names if not MAY_PASS[name]]
        for some in (few, [*names]):
            found = self._seek_without(set(some)) if some else None
            if found is not None and found.outcome.best:
                return found
        return None

    def _seek_without(self, names: Collection[str]) -> Sought | None:
        """A search without all of these; None where it ends before it knows."""
        mission = self.mission
        for name in names:
            mission = without(mission, *RELAXABLE[name][:2]) or mission
        if self.deadline.passed():
            return None
        found = self.relaxer.seek(mission, ANY, set(names), deadline=self._turn(), enough=True)
        if found.outcome.interrupted:
            self.interrupted = True
            return None
        return found if found.outcome.best or found.outcome.complete else None

    def relaxations(self) -> list[Relaxation]:
        """The requirements whose loss makes the mission feasible, with the least change of each."""
        helpful: list[Without] = []
        try:
            self._drop_all(helpful)
        except KeyboardInterrupt:
            self.interrupted = True
        made = []
        for number, one in enumerate(helpful):
            self._say(0.5 + 0.5 * number / len(helpful), f"the least change of {one.name}")
            made.append(self._relaxation(one))
        return made

    def _say(self, share: float, what: str) -> None:
        if self.progress is not None:
            self.progress(share, what)

    def _turn(self) -> Deadline:
        """The time for one search among others."""
        return self.deadline.at_most(TURN * self.deadline.left_s)

    def _asked(self) -> dict[str, float]:
        """What the mission asks for and can do without, with its limits: first what takes least to try."""
        asked = {name: asked_value(self.mission, *RELAXABLE[name][:2]) for name in RELAXABLE}
        limits = {name: limit for name, limit in asked.items() if limit is not None}
        if not limits or self.deadline.passed():
            return limits
        return {name: limits[name] for name in sorted(limits, key=lambda name: self.relaxer.effort({name}))}

    def _drop_all(self, helpful: list[Without]) -> None:
        """Drop every requirement in turn; those that take long get more time where no other helps."""
        left = self._asked()
        for _ in range(ROUNDS):
            known = []
            for number, name in enumerate(left):
                if self.deadline.passed():
                    break
                self._say(0.5 * number / len(left), f"why nothing fits: without {name}")
                if self._is_known(name, left[name], helpful):
                    known.append(name)
            left = {name: limit for name, limit in left.items() if name not in known}
            if helpful or not left:
                break
        self.deadline.left_out.extend(f"whether it could be met without {name}" for name in left)

    def _is_known(self, name: str, limit: float, helpful: list[Without]) -> bool:
        """Drop a requirement and see whether something fits then; whether that is known in the time for one."""
        section, key, _ = RELAXABLE[name]
        by_depth = key == "depth_rating_m"
        relaxed = self.mission if by_depth else without(self.mission, section, key)
        if relaxed is None:
            return True
        seek_one = partial(self.relaxer.seek, goal=BRIGHT if name == "min_snr" else ANY, freed={name}, enough=True)
        if name == "cost" and self.mission.limits.cost_basis == "high":
            central, turn = with_central_prices(self.mission), self.deadline.at_most(LONG_TURN * self.deadline.left_s)
            found = seek_one(central, deadline=turn)
            if found.outcome.best:
                helpful.append(Without(name, limit, central, found, at_central_prices=True))
                return True
        found = self._without_ratings() if by_depth else seek_one(relaxed, deadline=self._turn())
        if found.outcome.best:
            helpful.append(Without(name, limit, relaxed, found))
        if found.outcome.interrupted:
            raise KeyboardInterrupt
        return found.outcome.complete or bool(found.outcome.best)

    def _without_ratings(self) -> Sought:
        """A search over parts of any depth rating."""
        return seek(
            self.mission, self.catalog, ANY, generic=self.generic, top=1, depth_m=0.0, deadline=self._turn(),
            like=self.relaxer.problem, enough=True,
        )  # fmt: skip

    def _relaxation(self, one: Without) -> Relaxation:
        """The least change of a requirement that helps, or that of the design at hand."""
        _, key, best = RELAXABLE[one.name]
        found, by_depth, turn = one.found, key == "depth_rating_m", self._turn()
        by_figure = best is not None and not one.at_central_prices
        if by_depth and not self.interrupted:
            found = deepest(
                found, one.mission, self.catalog, ANY, generic=self.generic, deadline=self.deadline
            )
        if by_figure and not self.interrupted:
            found = self._best_without(one, Objective.of(best or ""), turn)
        design = judged_by(self.mission, found, self.objective)
        needed = rated_depth(found) if by_depth else reached_value(design, key)
        if needed is not None:
            kept = self.mission.depth_factor
            needed = needed / kept if by_depth else asked_when_held(self.mission.reserve, key, needed)
        if not by_figure and not by_depth and needed is not None and not self.interrupted:
            try:
                change = self._least_change(one, needed, turn)
                needed, design = change.limit, judged_by(self.mission, change.found, self.objective)
            except KeyboardInterrupt:
                self.interrupted = True
            self.deadline.left_out.extend(turn.left_out)
        return Relaxation(one.name, one.limit, needed, miss(one.limit, needed), design, one.at_central_prices)

    def _best_without(self, one: Without, goal: Objective, turn: Deadline) -> Sought:
        """The design whose figure is best without its limit; the first that was found where there is no time."""
        first = judged_by(one.mission, one.found, goal).objective_value
        ceiling = math.inf if first is None else goal.minimised(first)
        better = self.relaxer.seek(one.mission, goal, {one.name}, deadline=turn, ceiling=ceiling)
        self.interrupted |= better.outcome.interrupted
        if not better.outcome.complete:
            self.deadline.left_out.append(f"whether less than that change of {one.name} would do")
        return better if better.outcome.best else one.found

    def _least_change(self, one: Without, needed: float, turn: Deadline) -> Change:
        """The limit nearest to what is asked with which something fits."""
        section, key, _ = RELAXABLE[one.name]

        def search(wanted: Mission) -> Sought:
            found = self.relaxer.seek(wanted, ANY, {one.name}, deadline=turn, enough=True)
            if found.outcome.interrupted:
                raise KeyboardInterrupt
            return found

        return least_change(
            one.limit, rounded_away(needed, one.limit), one.found, search=search, deadline=turn, name=one.name,
            relaxed=partial(with_limit, self.mission, section, key, one.limit),
        )  # fmt: skip


def deepest(
    found: Sought,
    mission: Mission,
    catalog: Catalog,
    goal: Objective,
    *,
    generic: Generic,
    deadline: Deadline,
) -> Sought:
    """Of designs whose parts are not rated deep enough, one whose are rated deepest."""
    while (rated := rated_depth(found)) is not None and not deadline.passed():
        deeper = seek(
            mission, catalog, goal, generic=generic, top=1, depth_m=rated * (1 + 1e-6), deadline=deadline,
            like=found.problem,
        )  # fmt: skip
        if not deeper.outcome.best or (rated_depth(deeper) or 0.0) <= rated:
            break
        found = deeper
    return found


def judged_by(mission: Mission, found: Sought, objective: Objective) -> Design:
    """The best design of a relaxed search, judged by the mission as it stands: what it misses shows."""
    best = found.outcome.best[0]
    problem = problem_of(found.problem, best, mission=mission)
    hardware = Hardware(0, 0, 0, best.landscape, 0, best.count, best.lighting.mount)
    given = given_of(problem, hardware, best.settings)
    return evaluate_design(problem, hardware, given, objective)


def missed_by(design: Design, names: Collection[str]) -> set[str]:
    """Those requirements that a design does not meet."""
    missed = {margin.requirement for scene in design.scenes for margin in scene.margins if not margin.satisfied}
    return {name for name in names if RELAXABLE[name][1] in missed or name in missed}


def asked_value(mission: Mission, section: str, key: str) -> float | None:
    """What the mission asks for without its reserve, in any scene the first that does; None when none does."""
    if key == "depth_rating_m":
        return mission.asked_depth_m or None
    if section == "limits":
        value = getattr(mission.limits, key)
        return None if value is None else float(value)
    for view in mission.views:
        if key == "min_snr_db":
            ratio = view.asked.min_snr
            value = None if ratio is None else float(ratio_to_db(ratio))
        else:
            value = getattr(view.asked, key)
        if value is not None and (value or key != "lens_stop_down"):
            return float(value)
    return None


def without(mission: Mission, section: str, key: str) -> Mission | None:
    """The mission without one requirement, in all scenes; None when it cannot be dropped.

    Of the SNR so much is left that something is seen.
    """
    data = mission.to_dict()
    for own in (data[section], *(scene.get(section) or {} for scene in data["scenes"])):
        if key == "min_snr_db":
            leave_little_snr(own)
        else:
            own.pop(key, None)
        if own.get("refuse"):
            own["refuse"] = [word for word in own["refuse"] if word not in words_of(key)]
    if key == "overlap" and mission.requirements.frame_interval_s is None and mission.vehicle.speed_m_s == 0:
        return None
    return mission.with_changes(**{name: data[name] for name in ("requirements", "limits", "scenes")})


def leave_little_snr(asked: dict[str, Any]) -> None:
    """In place of an SNR that is asked for, the least that shows anything; none where no more was asked for."""
    ratio, value_db = asked.pop("min_snr", None), asked.pop("min_snr_db", None)
    if ratio is not None and value_db is None:
        value_db = float(ratio_to_db(ratio))
    if value_db is not None and value_db > LEAST_SNR_DB:
        asked["min_snr_db"] = LEAST_SNR_DB


def with_central_prices(mission: Mission) -> Mission:
    """The mission whose limit of cost holds estimated prices at their middle."""
    return mission.with_changes(limits=mission.to_dict()["limits"] | {"cost_basis": "central"})


def words_of(key: str) -> list[str]:
    """The refusals that stand for a key."""
    return [word for word, (held, _) in REFUSED.items() if held == key]


def weaker_by(share: float, limits: Mapping[str, float]) -> dict[str, float]:
    """Limits that ask for less, each by a share of itself."""
    made = {}
    for name, limit in limits.items():
        section, key, _ = RELAXABLE[name]
        from_above = section == "limits" or key.startswith("max_") or key == "resolve_mm"
        made[name] = rounded_away(limit + share * abs(limit) * (1.0 if from_above else -1.0), limit)
    return made


def with_limit(mission: Mission, section: str, key: str, asked: float, value: float) -> Mission:
    """The mission with another limit in all scenes; one that already asks for less stays as it is."""
    data = mission.to_dict()

    def weaker(old: float) -> float:
        if key == "mean_level":
            return value if old == asked else old
        return max(old, value) if value > asked else min(old, value)

    for place in (data, *data["scenes"]):
        own = place.get(section) or {}
        if own.get(key) is not None:
            own[key] = weaker(float(own[key]))
        elif set(own.get("refuse") or ()).intersection(words_of(key)):
            own[key] = weaker(asked)
    return mission.with_changes(**{name: data[name] for name in ("requirements", "limits", "scenes")})


def rated_depth(found: Sought) -> float | None:
    """Depth that the relaxed design's parts are rated for; None where it is unknown."""
    best, parts = found.outcome.best[0], found.problem.parts
    port = parts.ports[best.port]
    ratings = [port.depth_rating_m, parts.lights[best.light].depth_rating_m]
    ratings += [] if port.housing is None else [port.housing.depth_rating_m]
    known = [rating for rating in ratings if rating is not None]
    return min(known) if len(known) == len(ratings) else None


def reached_value(design: Design, key: str) -> float | None:
    """What the design reaches of a requirement, at its worst over altitudes and scenes."""
    found = [
        (margin.sense, margin.value)
        for scene in design.scenes
        for margin in scene.margins
        if margin.requirement == key and margin.value is not None
    ]
    values = [value for _, value in found]
    if not found:
        return None
    return min(values) if found[0][0] == ">=" else max(values)


def miss(limit: float | None, needed: float | None) -> float:
    """How far a limit is missed, relative; large when it cannot be said."""
    if limit is None or needed is None:
        return UNKNOWN
    return abs(needed - limit) / max(abs(limit), 1e-12)
