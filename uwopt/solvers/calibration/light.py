"""What each test shot should read by the forward model, over how murky the water is.

Electrons of light that forms the image, of forward veil, backscatter and sun are worked out at nodes of the water's
attenuation, shot by shot, and their logarithms joined by cubic splines: Beer's law makes them almost straight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from uwopt.arrays import Array
from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.designs import Hardware, SceneSettings
from uwopt.forward.figures import SettingRows
from uwopt.forward.problem import Problem
from uwopt.forward.scene import SceneOptics
from uwopt.mission.shots import Shot

MURKIEST = 4.0  # times the mission's attenuation, and as much clearer
NODES = np.exp(np.linspace(-np.log(MURKIEST), np.log(MURKIEST), 9))
PATCH_PX = 32  # a side of the patch in the middle of an image
TINY = 1e-300
LEAST_SEEN = 0.01  # of the veil: with less of an image the floor that is seen is dark, and a level tells nothing of it


@dataclass(frozen=True)
class ShotLight:
    """Electrons of n shots over the logarithm of the water's factor, and what they make of them, (n,) each."""

    signal: CubicSpline  # logarithm of what forms the image, and of what arrives of it as a veil
    back: CubicSpline  # of backscatter
    sun_e: Array
    dn_per_e: Array
    full_dn: Array  # where the camera ends: of its numbers, or of its well
    has_veil: bool

    def net_dn(self, light: float, water: float = 1.0, back: float = 1.0) -> Array:
        """Numbers above the dark level: light times reflectance, attenuation and backscatter as factors."""
        return self.with_rises(light, water, back)[0]

    def with_rises(self, light: float, water: float = 1.0, back: float = 1.0) -> tuple[Array, dict[str, Array]]:
        """The same, and by how much its logarithm rises with that of each factor, (n,) by name."""
        at = np.log(water)
        seen_e = light * np.exp(self.signal(at))
        back_e = back * np.exp(self.back(at)) if self.has_veil else np.zeros_like(seen_e)
        total_e = seen_e + self.sun_e + back_e
        by_water = seen_e * self.signal(at, 1) + back_e * self.back(at, 1)
        rises = {"light": seen_e / total_e, "water": by_water / total_e, "back": back_e / total_e}
        return np.asarray(self.dn_per_e * total_e), rises

    def take(self, rows: Array) -> ShotLight:
        """The same of some of the shots."""

        def some(spline: CubicSpline) -> CubicSpline:
            return CubicSpline(spline.x, spline(spline.x)[:, rows])

        return ShotLight(
            some(self.signal), some(self.back), self.sun_e[rows], self.dn_per_e[rows], self.full_dn[rows], self.has_veil
        )


def shot_light(
    at_distance: Sequence[tuple[Problem, Hardware, SceneSettings]], shots: Sequence[Shot], *, in_middle: bool
) -> ShotLight:
    """The forward model of shots, at the nodes of the water.

    at_distance : of each shot, the problem of its system looking from its distance, and the system's own settings there
    in_middle : the levels are of a patch in the middle of the image, not of all of it
    """
    made: dict[int, list[DesignModel]] = {}
    middle = len(NODES) // 2
    one_distance = len({shot.distance_m for shot in shots}) == 1  # which tells nothing of the water
    nodes = NODES[middle - 1 : middle + 2] if one_distance else NODES
    signal, back = np.zeros((len(nodes), len(shots))), np.zeros((len(nodes), len(shots)))
    sun, per_e, full = np.zeros(len(shots)), np.zeros(len(shots)), np.zeros(len(shots))
    for n, (shot, (problem, hardware, given)) in enumerate(zip(shots, at_distance, strict=True)):
        if id(problem) not in made:
            base = patched(problem) if in_middle else problem
            made[id(problem)] = [DesignModel(in_water(base, float(factor)), hardware) for factor in nodes]
        for k, model in enumerate(made[id(problem)]):
            settings = settings_of(model, shot, given)
            figures, at = model.figures(0, settings), model.problem.scenes[0].nominal
            image, veil = float(figures.electrons_signal[0, at]), part(figures.electrons_forward, at)
            signal[k, n] = image + veil if image >= LEAST_SEEN * veil else 0.0
            back[k, n] = part(figures.electrons_backscatter, at)
            if k == len(nodes) // 2:  # the sun through the water as the mission has it
                sun[n] = part(figures.electrons_sun, at)
        cameras = made[id(problem)][0].cameras
        per_e[n] = float(cameras.gain_dn_per_e[0]) * shot.gain
        full[n] = min(2.0 ** float(cameras.bits[0]) - 1.0, float(cameras.saturation_e[0]) * per_e[n])
    where = np.log(nodes)
    return ShotLight(
        CubicSpline(where, np.log(np.maximum(signal, TINY))), CubicSpline(where, np.log(np.maximum(back, TINY))),
        sun, per_e, full, bool((back > 0.0).all()),
    )  # fmt: skip


def part(column: Array | None, at: int) -> float:
    """Electrons of one kind at one altitude; 0 where physics leaves them out."""
    return 0.0 if column is None else float(column[0, at])


def settings_of(model: DesignModel, shot: Shot, given: SceneSettings) -> SettingRows:
    """What was set: the shot's own on top of the system's."""
    own = dict(f_number=shot.f_number, pulse_s=shot.pulse_s, level=shot.light_frac)
    wanted = replace(given, **{key: value for key, value in own.items() if value is not None})
    pulse_s = wanted.pulse_s if wanted.pulse_s is None else min(wanted.pulse_s, shot.exposure_s)
    return model.settings(0, replace(wanted, exposure_s=shot.exposure_s, gain=shot.gain, pulse_s=pulse_s))


def patched(problem: Problem) -> Problem:
    """The same with an image that ends at a patch in its middle."""
    camera = replace(problem.parts.cameras[0], resolution_x_px=PATCH_PX, resolution_y_px=PATCH_PX)
    return like(problem, problem.scenes[0], replace(problem.parts, cameras=(camera,)))


def in_water(problem: Problem, factor: float) -> Problem:
    """The same in water that attenuates by so many times as much, in every colour and on every leg."""
    return problem if factor == 1.0 else like(problem, murkier(problem.scenes[0], factor))


def murkier(scene: SceneOptics, factor: float) -> SceneOptics:
    """A scene's water with all of its absorption, scattering and K times a factor."""
    kd = scene.diffuse_attenuation_per_m
    return replace(
        scene, attenuation_per_m=scene.attenuation_per_m * factor,
        lamp_attenuation_per_m=scene.lamp_attenuation_per_m * factor,
        scattering=tuple(replace(one, scattering_per_m=one.scattering_per_m * factor) for one in scene.scattering),
        diffuse_attenuation_per_m=None if kd is None else kd * factor, cache={},
    )  # fmt: skip


def like(problem: Problem, scene: SceneOptics, parts: Any = None) -> Problem:
    """A problem of one system in another scene, or with other parts."""
    return problem.over(parts or problem.parts, scenes=[scene])
