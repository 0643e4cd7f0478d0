"""How the light in an image changes with the water: worked out at nodes, and interpolated for each scenario.

Signal and veils of one imager are worked out in each table at five degrees of clarity, at five of K on the lamps' way,
and where both are at their ends. Their logarithms are interpolated by parabolas on either side of the central water,
where the spectra have a kink, and by what the ends have beyond the sum. The floor scales the signal, a little more than
in proportion where the water turns its light back to it, and the forward veil, not what the water sends back.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.light_columns import ImageLight
from uwopt.forward.scene import SceneOptics
from uwopt.forward.scene_rows import SceneRows
from uwopt.forward.setting_rows import BALANCE_ROUND, NO_TIME_S
from uwopt.model import sensor
from uwopt.solvers.confidence.waters import Waters, WaterState

NODES = (-1.0, -0.5, 0.0, 0.5, 1.0)
SIDES = (-1.0, 1.0)
TINY = 1e-300
LIT = ("signal_e", "worst_e", "colour_e", "sun_signal_e_s", "worst_sun_signal_e_s", "sun_colour_e_s")
VEILED = (
    "veil_e", "worst_veil_e", "red_veil_e", "sun_veil_e_s", "worst_sun_veil_e_s", "sun_red_veil_e_s",
)  # fmt: skip
UNLIT = ("background_e",)  # open water behind targets knows no floor
OF_LAMPS, OF_SUN = ("worst_e", "worst_veil_e"), ("worst_sun_signal_e_s", "worst_sun_veil_e_s")
AT_PIXELS = {name: both for both in (OF_LAMPS, OF_SUN) for name in both}  # signal and veil at pixels
COLUMNS = (*LIT, *VEILED, *UNLIT)
Reference = Callable[[list[SceneOptics]], list[SceneRows]]  # one imager's rows in these scenes
BRIGHTER = 1.25  # floor at which the share of the veil that it sends is measured


@dataclass(frozen=True)
class TableResponse:
    """Of one light column in one table of waters: logarithms over the water as it is known, along both axes.

    ln f(c, k) = ln f(c, 0) + ln f(0, k) - ln f(0, 0) + |c k| e,   e: what the corner of that side has beyond the sum
    """

    clarity: Array  # (n_nodes, *shape of the column)
    leg: Array
    centre: Array
    corners: dict[tuple[float, float], Array]

    @staticmethod
    def of(nodes: Mapping[tuple[float, float], SceneRows], base: SceneRows, name: str, row: int) -> TableResponse:
        """From the rows at each node, (clarity, leg), and in the water as it is known."""
        lowest = np.maximum(level(base, name, row), TINY)
        logs = {at: np.log(np.maximum(level(rows, name, row), TINY) / lowest) for at, rows in nodes.items()}
        centre = logs[0.0, 0.0]
        beyond = {(c, k): both - logs[c, 0.0] - logs[0.0, k] + centre for (c, k), both in logs.items() if c and k}
        clarity, leg = sorted({c for c, _ in logs}), sorted({k for _, k in logs})
        across, along = (np.array([logs[c, 0.0] for c in clarity]), np.array([logs[0.0, k] for k in leg]))
        return TableResponse(across, along, centre, beyond)

    def at(self, clarity: Array, leg: Array, across: Array, along: Array) -> Array:
        """At these states, (n, *shape)."""
        made = np.einsum("nc,c...->n...", across, self.clarity) + np.einsum("nl,l...->n...", along, self.leg)
        made = made - self.centre
        for (c, k), beyond in self.corners.items():
            mine = (clarity * c > 0.0) & (leg * k > 0.0)
            size = np.abs(clarity * leg)[mine]
            made[mine] += size.reshape(-1, *([1] * (made.ndim - 1))) * beyond
        return made

    def in_band(self, weight: Array) -> TableResponse:
        """At other altitudes of the band, by the weight of each that is known, (n_altitudes, n_known)."""
        clarity, leg = (np.einsum("ak,nk...->na...", weight, nodes) for nodes in (self.clarity, self.leg))
        corners = {side: over_band(weight, beyond) for side, beyond in self.corners.items()}
        return TableResponse(clarity, leg, over_band(weight, self.centre), corners)


@dataclass(frozen=True)
class WaterResponse:
    """How each light column of one imager changes with the state of the water, by scene."""

    clarity: tuple[float, ...]
    leg: tuple[float, ...]
    columns: list[dict[str, dict[bool, TableResponse]]]  # by scene, column and table
    from_floor: list[dict[str, Array]]  # by scene and column: see `floor_shares`

    @staticmethod
    def of_each(
        waters: Waters, states: Sequence[WaterState], reference: Reference, count: int
    ) -> list[WaterResponse]:
        """Of so many imagers: work out the nodes that these states need."""
        clarity, leg, places = nodes_between(states)

        def seen(table: bool, c: float, k: float, floor: float = 1.0) -> list[SceneRows]:
            return reference(waters.kept(WaterState(table, c, k, floor), roughly=True))

        nodes = {
            table: {at: seen(table, *at) for at in places} for table in sorted({state.other_table for state in states})
        }
        known = nodes[False][0.0, 0.0] if False in nodes else seen(False, 0.0, 0.0)
        brighter = seen(False, 0.0, 0.0, BRIGHTER)
        made = []
        for row in range(count):
            columns: list[dict[str, dict[bool, TableResponse]]] = []
            for index, base in enumerate(known):
                columns.append({
                    name: {
                        table: TableResponse.of({at: rows[index] for at, rows in seen_at.items()}, base, name, row)
                        for table, seen_at in nodes.items()
                    }
                    for name in COLUMNS if getattr(base, name) is not None
                })  # fmt: skip
            shares = [floor_shares(base, lit, row) for base, lit in zip(known, brighter, strict=True)]
            made.append(WaterResponse(clarity, leg, columns, shares))
        return made

    def seen_in(self, index: int, rows: SceneRows, states: Sequence[WaterState]) -> SceneRows:
        """Rows of one scene as they are in the water and over the floor of each state."""
        other = np.array([state.other_table for state in states])
        clarity, leg = (np.array([getattr(state, name) for state in states]) for name in ("clarity", "lamp_leg"))
        across, along = weights(self.clarity, clarity), weights(self.leg, leg)
        floor = np.array([state.floor for state in states])
        changes: dict[str, Any] = {}
        for name, tables in self.columns[index].items():
            some = next(iter(tables.values()))
            picked = np.zeros((len(states), *some.centre.shape))
            for table, known in tables.items():
                mine = other == table
                picked[mine] = known.at(clarity[mine], leg[mine], across[mine], along[mine])
            factor = np.exp(picked)
            bright = floor.reshape(-1, *([1] * (factor.ndim - 1)))
            if name in LIT:
                factor = factor * bright
            if name in self.from_floor[index]:
                factor = factor * (1.0 + (bright - 1.0) * self.from_floor[index][name])
            changes[name] = getattr(rows, name) * factor
        return balanced(replace(rows, **changes))

    def in_narrower_band(self, share: float) -> WaterResponse:
        """Where the altitudes are kept within so much of their tolerance; itself where there is but one altitude."""
        columns, from_floor = [], []
        for known, shares in zip(self.columns, self.from_floor, strict=True):
            made, of_floor = {}, {}
            for name, tables in known.items():
                count = len(next(iter(tables.values())).centre)
                weight = through_band(count, share * np.linspace(-1.0, 1.0, count))
                made[name] = {table: one.in_band(weight) for table, one in tables.items()}
                if name in shares:
                    of_floor[name] = np.clip(over_band(weight, shares[name]), 0.0, 1.0)
            columns.append(made)
            from_floor.append(of_floor)
        return WaterResponse(self.clarity, self.leg, columns, from_floor)


def through_band(count: int, at: Array) -> Array:
    """Weights of evenly spaced altitudes of a band, from -1 to 1, at others, (*at.shape, count).

    Of the polynomial through all of them; 1 where there is but one.
    """
    return lagrange(np.linspace(-1.0, 1.0, count) if count > 1 else np.zeros(1), at)


def lagrange(nodes: Array, at: Array) -> Array:
    """Weights of values at nodes, of the polynomial through all of them at other places, (*at.shape, n_nodes)."""
    return np.stack([np.prod([np.ones_like(at), *((at - b) / (a - b) for b in nodes if b != a)], axis=0)
                     for a in nodes], axis=-1)  # fmt: skip


def over_band(weight: Array, values: Array) -> Array:
    """Values by altitude, (n_known, ...), at others."""
    return np.asarray(np.einsum("ak,k...->a...", weight, values))


def in_light(rows: SceneRows, change: Callable[[Array], Array]) -> SceneRows:
    """Rows with all of their light and their veils changed."""
    made: dict[str, Any] = {
        name: change(column) for name in (*LIT, *VEILED) if (column := getattr(rows, name)) is not None
    }
    return replace(rows, **made)


def level(rows: SceneRows, name: str, row: int) -> Array:
    """A light column of one row; of pixels that of the one that decides, by s^2 / (s + v): another in other water."""
    column = np.asarray(getattr(rows, name)[row])
    if name not in AT_PIXELS:
        return column
    signal, over = (getattr(rows, one) for one in AT_PIXELS[name])
    seen = signal[row] ** 2 / np.maximum(signal[row] if over is None else signal[row] + over[row], TINY)
    place = min(rows.may_miss, seen.shape[1] - 1)
    return np.take_along_axis(column, np.argsort(seen, axis=1, kind="stable")[:, place, None], axis=1)


def nodes_between(
    states: Sequence[WaterState],
) -> tuple[tuple[float, ...], tuple[float, ...], list[tuple[float, float]]]:
    """Of clarity, of the lamps' way, and of both: where light is worked out for these states in each table."""
    clarity = nodes_for([state.clarity for state in states])
    leg = nodes_for([state.lamp_leg for state in states])
    corners = list(product(SIDES, SIDES)) if len(clarity) > 1 and len(leg) > 1 else []
    return clarity, leg, list(dict.fromkeys([*product(clarity, (0.0,)), *product((0.0,), leg), *corners]))


def waters_of(states: Sequence[WaterState]) -> int:
    """How many waters the light of an image is worked out in, one over another floor among them."""
    return len(nodes_between(states)[2]) * len({state.other_table for state in states}) + 1


def nodes_for(values: Sequence[float]) -> tuple[float, ...]:
    """The nodes between which these values lie: one where nothing varies."""
    return NODES if any(values) else (0.0,)


def floor_shares(known: SceneRows, brighter: SceneRows, row: int) -> dict[str, Array]:
    """Which share of each veil grows with the floor's reflectance, and of light what grows beyond it in proportion."""
    shares = {}
    for name in (*LIT, *VEILED):
        if getattr(known, name) is not None:
            grown = level(brighter, name, row) / np.maximum(level(known, name, row), TINY)
            grown = grown / BRIGHTER if name in LIT else grown
            shares[name] = np.clip((grown - 1.0) / (BRIGHTER - 1.0), 0.0, 1.0)
    return shares


def weights(nodes: tuple[float, ...], at: Array) -> Array:
    """Of each node at each place, (n_places, n_nodes): parabolas through the three nodes of its side of 0."""
    if len(nodes) == 1:
        return np.ones((len(at), 1))
    made = np.zeros((len(at), len(nodes)))
    for first, side in ((0, at < 0.0), (2, at >= 0.0)):
        made[side, first : first + 3] = lagrange(np.array(nodes[first : first + 3]), at[side])
    return made


def of_deciding_pixels(image: ImageLight) -> ImageLight:
    """Images whose SNR is asked of two pixels, not hundreds: of those that all but the pixels that may miss it reach.

    One by the signal, which decides where the camera's own noise counts, one by s^2 / (s + v), where that of the light
    does; both must reach the SNR. In rows of one image the light of all pixels is the same but for a factor.
    """
    signal, veil = image.worst_e, image.worst_veil_e
    if signal is None or signal.shape[2] <= 2:
        return image
    over = np.zeros_like(signal) if veil is None else np.broadcast_to(veil, signal.shape)
    place = min(image.may_miss, signal.shape[2] - 1)
    by_light = signal**2 / np.maximum(signal + over, TINY)
    picks = np.stack([np.argpartition(key, place, axis=2)[:, :, place] for key in (signal, by_light)], axis=2)
    changes: dict[str, Any] = {"worst_e": np.take_along_axis(signal, picks, axis=2), "may_miss": 0}
    if veil is not None:
        changes["worst_veil_e"] = np.take_along_axis(over, picks, axis=2)
    return replace(image, **changes)


def balanced(rows: SceneRows) -> SceneRows:
    """Rows of which those whose colours are too far apart have no time."""
    far_apart = unbalanced(rows)
    return replace(rows, time_max_s=np.where(far_apart, NO_TIME_S, rows.time_max_s)) if far_apart.any() else rows


def unbalanced(rows: SceneRows) -> Array:
    """Which rows have colours that are too far apart, with no sun to mix."""
    if rows.colour_e is None or rows.sunlit or not np.isfinite(rows.max_white_balance):
        return np.zeros(len(rows.time_max_s), bool)
    ratio = sensor.white_balance(rows.colour_e).max(axis=1)
    return np.asarray(ratio > rows.max_white_balance * BALANCE_ROUND)
