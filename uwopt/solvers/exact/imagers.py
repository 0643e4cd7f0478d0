"""All imagers that a mission allows: camera x lens x port x orientation, and the account of the rest.

What is geometric belongs to the imager alone: view, ground sample, frame rate, longest exposure, the
f-numbers that keep the wanted depth sharp. One vectorised pass per port and orientation; each rule
counts what it discards first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from uwopt.arrays import Array
from uwopt.catalog.compatibility import (
    IMAGE_CIRCLE_TOLERANCE_FRAC,
    image_circle_ok,
    mount_compatible,
    rated_pitch_um,
)
from uwopt.deadline import NEVER, Deadline, spend
from uwopt.forward.columns import Columns
from uwopt.forward.focus import Focused, depth_f_number, working_factor
from uwopt.forward.motion import blur_time_s, required_rate_hz, shutter_skew_px
from uwopt.forward.problem import Problem
from uwopt.forward.sharpness import SharpRows, sharpness_of
from uwopt.forward.views import Views, focus_map, widest_corner
from uwopt.solvers.exact.imager_rules import (
    Behind,
    Sample,
    Tally,
    beaten_housings,
    focus_rules,
    own_rules,
    totals,
    view_rules,
)
from uwopt.solvers.exact.seen import kinds_behind

PAIR_SAMPLES = 256  # discarded pairs of camera and lens remembered per rule, about

IMAGER_RULES = (
    "complete", "mount", "image_circle", "lens_rating", "view", "horizon", "focus", "max_gsd_mm", "min_swath_m",
    "min_common_swath_m", "max_depth_error_mm", "frame_rate", "data_rate_mb_s", "storage_gb", "card_gb",
    "lens_stop_down", "min_dof_m", "max_blur_px", "housing", "size_mm", "diameter_mm",
    "mass_water_kg", "cost", "mass_kg", "power_w", "energy_wh", "better_housing",
)  # fmt: skip


@dataclass(frozen=True)
class SceneImagers(Columns):
    """Columns of all imagers in one scene."""

    view: Views
    focused: Focused

    @property
    def most_area_m2(self) -> Array:
        """No footprint that these rows stand for is larger, (n, 3)."""
        return self.view.area_m2

    @property
    def ends(self) -> tuple[Views, ...]:
        """The smallest and the largest images that these rows stand for."""
        return (self.view,)


@dataclass(frozen=True)
class Imagers(Columns):
    """All imagers that pass the rules without light, as rows of indices with their columns by scene."""

    camera: Array
    lens: Array
    port: Array
    landscape: Array
    cost: Array
    limit_cost: Array  # what counts against the budget
    mass_kg: Array
    camera_power_w: Array
    gsd_mm: Array  # nominal, worst scene
    scenes: list[SceneImagers]
    tally: Tally = field(default_factory=Tally)  # of those that do not pass

    def __len__(self) -> int:
        return len(self.camera)

    def take(self, index: Array | slice) -> Imagers:
        """These rows only, without the account of what was discarded."""
        return replace(super().take(index), tally=Tally())

    def sharpness(self, problem: Problem, scene_index: int, rows: Array, optics: int) -> SharpRows:
        """What the sharpness of some of them in one scene depends on, under the light of a lamp's optics."""
        seen = self.scenes[scene_index]
        return sharpness_of(
            problem, scene_index, seen.view.take(rows), camera=self.camera[rows], lens=self.lens[rows],
            port=self.port[rows], optics=optics, dioptre_per_m=seen.focused.dioptre_per_m[rows],
        )  # fmt: skip

    def sample(self, row: int, lighting: int | None) -> Sample:
        """One imager under one lighting, or any, for an audit."""
        own = int(self.camera[row]), int(self.lens[row]), int(self.port[row])
        return *own, bool(self.landscape[row]), lighting


def enumerate_imagers(
    problem: Problem, *, cameras: Array | None = None, deadline: Deadline = NEVER
) -> Imagers:
    """Every imager of the problem's parts; see the module's docstring.

    `cameras` marks those worth a look; the others are counted under the rule `bound`. Raises OutOfTimeError.
    """
    pairs = fitting_pairs(problem, cameras=cameras)
    return imagers_in(problem, (
        Behind(pairs.camera, pairs.lens, ports, landscape)
        for ports in problem.port_groups for landscape in landscapes(problem)
    ), pairs.tally, deadline=deadline)  # fmt: skip


def no_tally() -> Tally:
    """Nothing discarded yet by any rule of imagers."""
    return Tally(dict.fromkeys(IMAGER_RULES, 0))


def imagers_in(
    problem: Problem, asked: Iterable[Behind], tally: Tally | None = None, *,
    keep: Callable[[PortBlock], PortBlock] = lambda block: block, deadline: Deadline = NEVER,
) -> Imagers:  # fmt: skip
    """The imagers among some pairs behind ports that pass every rule; the others are counted in the tally.

    keep : of those behind ports of the same optics some. Raises OutOfTimeError.
    """
    tally, blocks = no_tally() if tally is None else tally, []
    for behind in asked:
        deadline.check()
        sharp = sharp_behind(problem, behind, tally)
        if len(sharp.camera) and (block := housed(problem, sharp, behind, tally)) is not None:
            blocks.append(keep(block))
    return joined(problem, blocks, tally)


def landscapes(problem: Problem) -> list[bool]:
    """The orientations that the mission allows."""
    return [o == "landscape" for o in problem.mission.vehicle.orientations]


@dataclass(frozen=True)
class FittingPairs:
    """Cameras with lenses that fit on them, and the imagers that each rule discards with the others."""

    camera: Array
    lens: Array
    tally: Tally


def fitting_pairs(problem: Problem, *, cameras: Array | None = None) -> FittingPairs:
    """All pairs that fit by mount, image circle and, where it counts, the lens's rating."""
    parts = problem.parts
    n_camera, n_lens, n_port = len(parts.cameras), len(parts.lenses), len(parts.ports)
    tally, orientations = no_tally(), landscapes(problem)
    if 0 in (n_camera, n_lens, n_port):
        return FittingPairs(np.empty(0, int), np.empty(0, int), tally)
    fits = mount_compatible([c.mounts for c in parts.cameras], [part.mounts for part in parts.lenses])
    fits = fits.reshape(n_camera, n_lens)
    of_camera, of_lens, _ = problem.ties
    tied = of_camera[:, None] == of_lens[None, :]
    asked = [("complete", tied), ("mount", fits), ("image_circle", circles_ok(problem))]
    if problem.mission.catalog.lens_rating == "limit":
        asked.append(("lens_rating", ratings_ok(problem)))
    if cameras is not None:
        asked.append(("bound", np.broadcast_to(cameras[:, None], fits.shape)))
    alive = np.ones(fits.shape, bool)
    for rule, passes in asked:
        lost = np.flatnonzero(alive & ~passes)
        tally.discarded[rule] = len(lost) * n_port * len(orientations)

        def behind_any(at: int, lost: Array = lost) -> Sample:  # ports and orientations by turns
            turn, pair = at // max(1, len(lost) // PAIR_SAMPLES), divmod(int(lost[at]), n_lens)
            return *pair, turn % n_port, orientations[turn % len(orientations)], None

        tally.remember(rule, len(lost), behind_any, PAIR_SAMPLES)
        alive &= passes
    camera, lens = np.nonzero(alive)
    return FittingPairs(camera, lens, tally)


def circles_ok(problem: Problem) -> Array:
    """Whether each lens's image circle covers each sensor; inline parts are not checked for what they leave out."""
    cameras, lenses = problem.cameras, problem.parts.lenses
    diagonal_mm = np.hypot(cameras.resolution_x_px, cameras.resolution_y_px) * cameras.pixel_pitch_m * 1e3
    circle_mm = np.array([part.image_circle_mm or (np.inf if part.inline else 0.0) for part in lenses], float)
    return np.asarray(image_circle_ok(diagonal_mm[:, None], circle_mm[None, :]))


def ratings_ok(problem: Problem) -> Array:
    """Whether each lens is rated for pixels as small as each sensor's; an unknown rating does not count against it."""
    rated = np.array([rated_pitch_um(part) or 0.0 for part in problem.parts.lenses], float)
    pitch = problem.cameras.pixel_pitch_m * 1e6
    return np.asarray(rated[None, :] <= pitch[:, None] * (1.0 + IMAGE_CIRCLE_TOLERANCE_FRAC))


@dataclass(frozen=True)
class PortBlock(Columns):
    """Imagers behind ports of the same optics in one orientation, which pass every rule."""

    camera: Array
    lens: Array
    port: Array
    landscape: Array
    scenes: list[SceneImagers]


@dataclass(frozen=True)
class SharpPairs(Columns):
    """Cameras with lenses behind a port whose view and focus keep every rule, with what they see by scene."""

    camera: Array
    lens: Array
    spacers_m: Array
    scenes: list[SceneImagers]


def sharp_behind(problem: Problem, behind: Behind, tally: Tally) -> SharpPairs:
    """The pairs that pass the rules that ports of the same optics share; each that does not counts behind them all.

    Behind a complete camera's port goes its own pair, behind all others none of those. What is dear to work out is
    worked out for the pairs that are left by then.
    """
    of_camera, _, of_port = problem.ties
    apart = of_camera[behind.camera] != of_port[behind.ports[0]]
    if apart.any():
        behind = behind.take(tally.passing([("complete", ~apart)], behind))
    camera, lens = behind.camera, behind.lens
    if len(camera) == 0:
        return SharpPairs(camera, lens, np.empty(0), [])
    spend("views")
    port = int(behind.ports[0])
    kinds = kinds_behind(problem, camera, lens, port, behind.landscape)
    spacers_m = kinds.spacers_m(problem, lens)
    left = tally.passing(view_rules(problem, port, kinds.views, spacers_m, kinds.of), behind)
    camera, lens, spacers_m = camera[left], lens[left], spacers_m[left]
    if len(left) == 0:
        return SharpPairs(camera, lens, spacers_m, [])
    behind, dioptre = behind.take(left), kinds.dioptre_per_m[kinds.of[left]]
    seen = kinds.of_pairs(problem, camera, lens, port, left)
    focused = focused_behind(problem, camera, lens, port, seen, stands(problem, camera, lens, dioptre), spacers_m)
    left = tally.passing(focus_rules(problem, camera, lens, focused), behind)
    scenes = [SceneImagers(view, extra) for view, extra in zip(seen, focused, strict=True)]
    made = SharpPairs(camera, lens, spacers_m, scenes)
    return made if len(left) == len(camera) else made.take(left)


def housed(problem: Problem, sharp: SharpPairs, behind: Behind, tally: Tally) -> PortBlock | None:
    """Those of sharp pairs that also keep the rules on housing, cost, mass and power behind these ports, if any."""
    ports, of_sharp = behind.ports, replace(behind, camera=sharp.camera, lens=sharp.lens)
    count = len(sharp.camera)
    alive = np.ones((count, len(ports)), bool)

    def drop(rule: str, passes: Array) -> None:
        lost = np.flatnonzero(alive & ~(passes if passes.ndim == 2 else passes[:, None]))
        if len(lost) == 0:
            return
        tally.count(rule, len(lost), of_sharp, lambda at: divmod(int(lost[at]), len(ports)))
        alive.ravel()[lost] = False

    rates = [scene.focused.rate_hz for scene in sharp.scenes]
    own = problem.cameras.take(sharp.camera), problem.lenses.take(sharp.lens)
    corner = np.zeros(count) if problem.paper else widest_corner([scene.view for scene in sharp.scenes])
    for rule, passes in own_rules(problem, *own, sharp.spacers_m, ports, rates, corner):
        drop(rule, passes)
    if len(ports) > 1:
        drop("better_housing", ~beaten_housings(problem, ports, alive))
    if not alive.any():
        return None
    row, of = np.nonzero(alive)
    kept = [scene.take(row) for scene in sharp.scenes]
    return PortBlock(sharp.camera[row], sharp.lens[row], ports[of], np.full(len(row), behind.landscape), kept)


def stands(problem: Problem, camera: Array, lens: Array, dioptre_per_m: Array) -> Array:
    """Where lenses may stand that are meant to be focused at a dioptre D, (k, n) [1/m]: there, if nothing is in doubt.

    At a share s of the distance meant the lens stands at D' = D / s. Who focuses looks at a target with the iris open,
    and stops where it is sharp: at the ends of what is in doubt no farther off than a blur disc c of so many pixels at
    the widest opening tells, f^2 |D' - D| / (1 - f D') <= N_open c (Conrad 2006, eq. 16 in dioptres).
    """
    if problem.focus_shares is None:
        return dioptre_per_m[None, :]
    doubt = problem.mission.doubt
    cameras, lenses = problem.cameras.take(camera), problem.lenses.take(lens)
    focal_m = lenses.focal_length_m
    open_m = lenses.f_number_min * doubt.focus_px * cameras.pixel_pitch_m / focal_m
    seen = open_m * (1.0 / focal_m - dioptre_per_m)
    near, far = (np.abs(dioptre_per_m / share - dioptre_per_m) for share in doubt.focus)
    with np.errstate(divide="ignore"):
        nearer = np.minimum(seen / (1.0 + open_m) / near, 1.0)
        farther = np.minimum(seen / np.maximum(1.0 - open_m, 1e-9) / far, 1.0)
    off = dioptre_per_m / problem.focus_shares[:, camera] - dioptre_per_m
    return np.asarray(dioptre_per_m + np.where(off > 0.0, nearer, farther) * off)


def focused_behind(
    problem: Problem, camera: Array, lens: Array, port: int, seen: list[Views], stands_per_m: Array, spacers_m: Array
) -> list[Focused]:  # fmt: skip
    """What focus and motion ask of these pairs in every scene.

    stands_per_m : where lenses stand, and where else they may, (k, n): what must be sharp is so at each
    """
    dioptre_per_m = stands_per_m[0]
    cameras, focused = problem.cameras.take(camera), []
    for index, (scene, view) in enumerate(zip(problem.scenes_of(camera), seen, strict=True)):
        requirements, shape = scene.view.requirements, problem.shape(port, index)
        with np.errstate(divide="ignore", invalid="ignore"):
            factor = working_factor(scene, view.focal_length_m, dioptre_per_m)
        closed = problem.lenses.f_number_from(requirements.lens_stop_down)[lens]
        at = focus_map(scene, shape)
        n_depth = np.max([depth_f_number(scene, at, view, one) for one in stands_per_m], axis=0)
        rate = required_rate_hz(requirements, scene.view.vehicle.speed_m_s, view.covered_along_m)
        focused.append(Focused(
            dioptre_per_m=dioptre_per_m, working_factor=factor,
            n_low=np.maximum(np.maximum(closed, n_depth), problem.f_number or 0.0),
            n_high=np.minimum(problem.lenses.f_number_max[lens], problem.f_number or np.inf),
            rate_hz=rate.max(axis=1), blur_time_s=blur_time_s(scene, shape, view), spacer_m=spacers_m,
            skew_px=shutter_skew_px(scene, shape, view, cameras.readout_s), beside_w=np.zeros(len(camera)),
        ))  # fmt: skip
    powers = problem.camera_powers_w(cameras, [extra.rate_hz for extra in focused])
    least = np.min(powers, axis=0)
    return [replace(f, beside_w=power - least) for f, power in zip(focused, powers, strict=True)]


def joined(problem: Problem, blocks: Sequence[PortBlock], tally: Tally) -> Imagers:
    """All blocks as one table."""
    if not blocks:
        part, number = np.empty(0, int), np.empty(0)
        return Imagers(part, part, part, np.empty(0, bool), number, number, number, number, number, [], tally)
    every = PortBlock.joined(blocks)
    cameras, scenes = problem.cameras.take(every.camera), every.scenes
    rates = [s.focused.rate_hz for s in scenes]
    cost, limit_cost, mass = totals(
        problem, cameras, problem.lenses.take(every.lens), scenes[0].focused.spacer_m, every.port,
        problem.disks_gb(cameras, rates),
    )  # fmt: skip
    power = problem.least_camera_power_w(cameras, rates)
    gsd = np.max([s.view.gsd_m[:, 1] for s in scenes], axis=0) * 1e3
    return Imagers(
        every.camera, every.lens, every.port, every.landscape, cost, limit_cost, mass, power, gsd, scenes, tally
    )
