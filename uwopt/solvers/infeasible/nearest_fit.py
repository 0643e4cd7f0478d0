"""Which size stops the fit, and by how much, where no camera with its lens goes into any housing."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from uwopt.catalog.choose import Selection
from uwopt.forward.enclosures import missing_width_mm, sizes_m
from uwopt.forward.problem import Problem
from uwopt.forward.views import widest_corner
from uwopt.results.basis import Lacking, NearestFit
from uwopt.solvers.exact.imagers import landscapes
from uwopt.solvers.exact.seen import seen_behind
from uwopt.solvers.infeasible.relaxed_imagers import Broken
from uwopt.solvers.infeasible.relaxer import Relaxer
from uwopt.tolerances import ROUND

MM = 1e3


def nearest_fit(relaxer: Relaxer) -> NearestFit | None:
    """Camera, lens, port and housing that need least more room than there is, of those that meet all else so far.

    None where one of them fits, so that sizes alone stop nothing; where no imager comes as far; and of catalogues too
    large to look at every imager.
    """
    problem = relaxer.problem
    if not problem.parts.ports:
        return nearest_port(relaxer.selection)
    if relaxer.broken is None:
        return None
    nearest: tuple[float, tuple[int, int, int], dict[str, tuple[float, float]]] | None = None
    for camera, lens, port, short_m, sizes in shortages(problem, relaxer.broken):
        if short_m <= 0.0:
            return None
        if nearest is None or short_m < nearest[0]:
            nearest = short_m, (camera, lens, port), sizes
    if nearest is None:
        return None
    _, (camera, lens, port), sizes = nearest
    parts = problem.parts
    housed = parts.ports[port]
    assert housed.housing is not None, "a bare port has room for everything"
    pieces = {"camera": parts.cameras[camera], "lens": parts.lenses[lens], "port": housed, "housing": housed.housing}
    lacking = [Lacking(name, MM * needed, MM * room) for name, (needed, room) in sizes.items() if needed > room * ROUND]
    lacking.sort(key=lambda one: one.room_mm - one.needed_mm)
    return NearestFit({kind: part.id for kind, part in pieces.items()}, lacking)


def shortages(
    problem: Problem, broken: Broken
) -> Iterator[tuple[int, int, int, float, dict[str, tuple[float, float]]]]:
    """The pair and enclosure that lack least behind each port in each orientation, and every size needed and had [m].

    Of the sizes of one enclosure the one that lacks most counts; 0 and no sizes where some pair fits.
    """
    places = broken.no_more_than((), some=False)
    for ports in problem.port_groups:
        for landscape in landscapes(problem):
            rows = places.get((int(ports[0]), landscape), np.empty(0, int))
            if len(rows) == 0:
                continue
            camera, lens = broken.pairs.camera[rows], broken.pairs.lens[rows]
            seen, _, spacers_m = seen_behind(problem, camera, lens, int(ports[0]), landscape)
            own = problem.cameras.take(camera), problem.lenses.take(lens), spacers_m, problem.ports.take(ports)
            corner = 0.0 if problem.paper else widest_corner(seen)
            short_m, sizes = np.zeros((len(rows), len(ports))), list(sizes_m(*own, corner))
            for _, alike, needed, room in sizes:
                over = needed[:, None] - room
                short_m[:, alike] = np.maximum(short_m[:, alike], np.where(needed[:, None] <= room * ROUND, 0.0, over))
            pair, of = np.unravel_index(int(np.argmin(short_m)), short_m.shape)
            told = {
                name: (float(needed[pair]), float(room[alike.index(int(of))]))
                for name, alike, needed, room in sizes
                if int(of) in alike
            }
            yield int(camera[pair]), int(lens[pair]), int(ports[of]), float(short_m[pair, of]), told


def nearest_port(selection: Selection) -> NearestFit | None:
    """Port and housing that come nearest to each other, where no port goes on any housing.

    Nothing is named where no housing is made for any of the ports; None where there are no ports or no housings.
    """
    pairs = [
        (missing_width_mm(housing, port), port, housing) for port in selection.ports for housing in selection.housings
    ]
    if not pairs:
        return None
    short, port, housing = min(pairs, key=lambda one: one[0])
    if math.isinf(short):
        return NearestFit({}, [])
    assert port.width_mm is not None and housing.outer_diameter_mm is not None, "one of unknown width is not too wide"
    lacking = Lacking("port_width_mm", port.width_mm, housing.outer_diameter_mm.value)
    return NearestFit({"port": port.id, "housing": housing.id}, [lacking])
