"""Which rules each imager breaks, whatever it breaks before: found once for all searches without some requirement."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.problem import Problem
from uwopt.solvers.exact.imager_rules import focus_rules, view_rules
from uwopt.solvers.exact.imagers import FittingPairs, fitting_pairs, focused_behind, landscapes
from uwopt.solvers.exact.seen import seen_behind


@dataclass(frozen=True)
class Broken:
    """Which rules that ports of the same optics share each pair of camera and lens breaks behind them."""

    pairs: FittingPairs
    behind: dict[tuple[int, bool], Array]  # by the first of like ports and landscape: bits of `names`, (n_pairs,)
    names: tuple[str, ...]

    @staticmethod
    def of(problem: Problem) -> Broken:
        """Every rule of every pair, whatever it breaks before."""
        pairs, behind, names = fitting_pairs(problem), {}, dict[str, int]()
        of_camera, _, of_port = problem.ties

        def mark(bits: Array, rows: Array, rules: Iterator[tuple[str, Array]]) -> None:
            for rule, passes in rules:
                bits[rows[~passes]] |= 1 << names.setdefault(rule, len(names))

        for ports in problem.port_groups:
            port, bits = int(ports[0]), np.full(len(pairs.camera), -1)  # pieces of others break everything
            own = np.flatnonzero(of_camera[pairs.camera] == of_port[port])
            for landscape in landscapes(problem) if len(own) else []:
                behind[port, landscape] = bits = bits.copy()
                bits[own] = 0
                camera, lens = pairs.camera[own], pairs.lens[own]
                seen, dioptre, spacers_m = seen_behind(problem, camera, lens, port, landscape)
                mark(bits, own, view_rules(problem, port, seen, spacers_m))
                focused = focused_behind(problem, camera, lens, port, seen, dioptre[None, :], spacers_m)
                mark(bits, own, focus_rules(problem, camera, lens, focused))
        return Broken(pairs, behind, tuple(names))

    def no_more_than(self, rules: Collection[str], *, some: bool) -> dict[tuple[int, bool], Array]:
        """Pairs behind like ports that break these rules alone, and one of them at least if that is wanted."""
        forgiven = sum(1 << bit for bit, name in enumerate(self.names) if name in rules)
        return {
            place: np.flatnonzero((bits & ~forgiven == 0) & ((bits != 0) if some else True))
            for place, bits in self.behind.items()
        }
