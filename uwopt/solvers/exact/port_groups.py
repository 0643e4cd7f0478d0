"""Groups of ports of one geometry, level by level, and what lenses bring to them: focus, and how far they close.

Each group stands as the two ports that would favour a design in every respect, as `pair_groups` has cameras and lenses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.focus import held_at_corner, place_focus, sharp_ends_m
from uwopt.forward.part_columns import Ports
from uwopt.forward.problem import Problem
from uwopt.forward.scene import PAPER_N_WATER, SceneOptics
from uwopt.forward.spacers import needed_spacer_m
from uwopt.forward.views import Views, focus_map
from uwopt.model import lens, port
from uwopt.model.port import normal_port_transmittance
from uwopt.solvers.exact.imager_rules import stops_down
from uwopt.solvers.exact.pair_groups import at_best
from uwopt.tolerances import COARSE_ROUND

BRANCHES = 8  # ports, or groups of them, that a group is split into


@dataclass(frozen=True)
class PortGroups:
    """Groups of ports of one geometry, each as the two ports that would favour a design in every respect.

    `start:stop` are places in `order`. No port of a group starts rays nearer to the axis than its `least`, none
    farther than its `most`: radius, gap and glass at one end, the glass's index at the other. `least` costs and weighs
    least, too, and has the most room inside.
    """

    order: Array  # all ports, the same at every level
    start: Array
    stop: Array
    tie_low: Array  # of the complete cameras that its ports belong to; 0 of none
    tie_high: Array
    least: Ports
    most: Ports
    transmission: Array  # the most, by scene: (n_scenes, n)

    @property
    def size(self) -> Array:
        """Number of ports in each group."""
        return self.stop - self.start

    @staticmethod
    def of(problem: Problem, order: Array, start: Array) -> PortGroups:
        """The groups that begin at these places."""
        ports, tie, sizes = problem.ports, problem.ties[2][order], ("outer_radius_m", "gap_m", "thickness_m")
        wanted = (*sizes, "price", "limit_price", "mass_kg"), ("refractive_index", "room_diameter_m", "room_length_m")
        passed = [
            normal_port_transmittance(n_water=scene.n_water, n_glass=ports.refractive_index[order])
            for scene in problem.scenes
        ]
        return PortGroups(
            order, start, np.append(start[1:], len(order)),
            np.minimum.reduceat(tie, start), np.maximum.reduceat(tie, start),
            at_best(ports, order, start, *wanted), at_best(ports, order, start, ("refractive_index",), sizes),
            np.array([np.maximum.reduceat(column, start) for column in passed]),
        )  # fmt: skip


def port_tree(problem: Problem) -> list[PortGroups]:
    """Groups of ports, level by level: each geometry as a whole, then parts of it, at last ports of the same optics.

    The last differ by their housings alone, of which one may beat another: only together can that be seen.
    """
    ports, alike = problem.ports, problem.port_groups
    first = np.array([group[0] for group in alike])
    depth = np.where(
        ports.is_dome, ports.outer_radius_m, ports.gap_m + ports.thickness_m / ports.refractive_index
    )
    kind = 2 * (problem.ties[2] > 0) + ports.is_dome  # ports of complete cameras stand apart from the others
    rank = np.lexsort((depth[first], kind[first]))
    order = np.concatenate([alike[group] for group in rank])
    begin = np.cumsum([0, *(len(alike[group]) for group in rank)])  # of each optics, in ports
    starts = [0, *(np.flatnonzero(np.diff(kind[first][rank])) + 1).tolist()]
    levels = [PortGroups.of(problem, order, begin[starts])]
    while len(starts) < len(rank):
        starts = sorted({
            a + (b - a) * i // BRANCHES for a, b in pairwise([*starts, len(rank)]) for i in range(BRANCHES)
        })  # fmt: skip
        levels.append(PortGroups.of(problem, order, begin[starts]))
    return levels


@dataclass(frozen=True)
class LensFocus:
    """What lenses bring to groups of ports, (n_lenses, n_groups): whether any port of the group lets the lens
    focus, and by scene, (n_scenes, n_lenses, n_groups), the least f-number times circle of confusion that keeps
    sharp what must be, and the least working factor. Behind any port, whether a lens can be closed as far as is
    asked (n_lenses,), and by scene the least f-number that this leaves (n_scenes, n_lenses)."""

    focuses: Array
    cover_m: Array
    factor: Array
    closes: Array
    closed: Array

    def grouped(self, order: Array, start: Array) -> LensFocus:
        """The best of each group of lenses, which are places `start` to the next in `order`."""
        cover, factor, closed = (
            np.minimum.reduceat(each[:, order], start, axis=1) for each in (self.cover_m, self.factor, self.closed)
        )
        focuses, closes = (np.logical_or.reduceat(each[order], start) for each in (self.focuses, self.closes))
        return LensFocus(focuses, cover, factor, closes, closed)


def lens_focus(problem: Problem, groups: PortGroups) -> LensFocus:
    """The best of each group's ports for every lens."""
    known = {int(p): focus_behind(problem, int(p)) for p in np.unique(problem.like_port)}
    by_port = [known[int(problem.like_port[p])] for p in groups.order]
    focuses = np.stack([one[0] for one in by_port], axis=1)
    cover = np.where(focuses, np.stack([one[1] for one in by_port], axis=2), np.inf)
    factor = np.where(focuses, np.stack([one[2] for one in by_port], axis=2), np.inf)
    return LensFocus(
        np.logical_or.reduceat(focuses, groups.start, axis=1),
        np.minimum.reduceat(cover, groups.start, axis=2),
        np.minimum.reduceat(factor, groups.start, axis=2),
        stops_down(problem, problem.lenses),
        np.array([problem.lenses.f_number_from(s.view.requirements.lens_stop_down) for s in problem.scenes]),
    )


def focus_behind(problem: Problem, port_index: int) -> tuple[Array, Array, Array]:
    """Whether each lens focuses behind one port, and by scene the f-number that its depth needs times the circle
    of confusion and the working factor; lower bounds where the place of the focus depends on the camera."""
    lenses, scenes = problem.lenses, problem.scenes
    n = len(lenses.price)
    focal = focal_lengths_m(problem, bool(problem.ports.is_dome[port_index]))
    maps = [focus_map(scene, problem.shape(port_index, i)) for i, scene in enumerate(scenes)]
    relative = [scene.view.requirements.circle_of_confusion_px for scene in scenes]
    mixed = None in relative and len(set(relative)) > 1  # some by the pixel, some by the sensor
    if mixed or any(held_at_corner(scene) for scene in scenes):
        return np.ones(n, bool), own_covers_m(scenes, maps, focal), np.ones((len(scenes), n))
    coc = [np.full(n, wanted or 1.0) for wanted in relative]
    focus = place_focus(scenes, maps, [empty_views(n, coc_m=own, focal_length_m=focal) for own in coc])
    ok, factors = np.ones(n, bool), []
    for scene, dioptre in zip(scenes, focus.dioptre_per_m, strict=True):
        with np.errstate(divide="ignore", invalid="ignore"):
            factor = lens.working_f_number(1.0, focal_length_m=focal, object_distance_m=1.0 / dioptre)
        ok &= np.isfinite(needed_spacer_m(lenses, dioptre, slack=COARSE_ROUND))
        factors.append(np.ones(n) if scene.paper else factor)
    return ok, np.array(focus.n_depth) * np.array(coc), np.array(factors)


def own_covers_m(scenes: Sequence[SceneOptics], maps: Sequence[port.FocusMap], focal_m: Array) -> Array:
    """The f-number times circle of confusion that each scene would need if the focus were its own, on the axis."""
    covers = []
    for scene, at in zip(scenes, maps, strict=True):
        near, far = (float(port.lens_dioptre_per_m(end, focus_map=at)) for end in sharp_ends_m(scene))
        covers.append(
            lens.f_number_to_cover(
                near, far_dioptre_per_m=far, focal_length_m=focal_m, circle_of_confusion_m=1.0
            )
        )
    return np.array(covers)


def focal_lengths_m(problem: Problem, dome: bool) -> Array:
    """Effective focal lengths of all lenses behind a port."""
    longer = PAPER_N_WATER if problem.paper and not dome else 1.0
    return np.asarray(problem.lenses.focal_length_m * longer)


def empty_views(n: int, **columns: Array) -> Views:
    """Views of which only some columns mean something."""
    nothing = dict.fromkeys(Views.__dataclass_fields__, np.zeros(n))
    return Views(**(nothing | columns))
