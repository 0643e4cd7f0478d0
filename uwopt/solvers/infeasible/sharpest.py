"""The most contrast of fine detail that anything reaches, whatever else is asked: of imagers, and of their parts.

Each is an upper bound, by intervals of f-numbers as in `never_sharp`. Of a camera with a lens it holds in any water and
at any height, behind any port and with any other requirement: defocus, motion, colours and ports only take from it.
"""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.bars import MAY_SHOW, StillBars
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.model import aberration
from uwopt.model.sharpness import HALF_NYQUIST_CYC_PER_PX, diffraction_mtf, lens_mtf, sinc_mtf
from uwopt.solvers.exact.imagers import Imagers
from uwopt.solvers.exact.never_sharp import INTERVALS

SHARP = "min_mtf_half_nyquist"
BLOCK = 4096  # imagers that are asked together


class Sharpest:
    """What the imagers of one search reach at half the Nyquist frequency, each asked once."""

    def __init__(self, problem: Problem, imagers: Imagers):
        self.problem, self.imagers = problem, imagers
        self._known = np.full((len(imagers), len(problem.scenes)), np.nan)

    @cached_property
    def of_parts(self) -> Array:
        """The most that each imager's camera leaves with its lens by scene, (n, n_scenes)."""
        lenses = len(self.problem.parts.lenses)
        each, back = np.unique(self.imagers.camera * lenses + self.imagers.lens, return_inverse=True)
        return most_of_parts(self.problem, each // lenses, each % lenses)[back.reshape(-1)]

    def at_least(self, mission: Mission) -> Array:
        """Rows of those that may be as sharp as a mission asks in every scene."""
        wanted = least_contrast_asked(mission)
        rows = np.flatnonzero((self.of_parts >= wanted).all(axis=1))
        return rows[(self._of(rows) >= wanted).all(axis=1)]

    @cached_property
    def most(self) -> Array:
        """The most that any of them reaches by scene, (n_scenes,)."""
        best = np.zeros(len(self.problem.scenes))
        for index in range(len(best)):
            order = np.argsort(-self.of_parts[:, index], kind="stable")
            for start in range(0, len(order), BLOCK):
                rows = order[start : start + BLOCK]
                if self.of_parts[rows[0], index] <= best[index]:
                    break
                best[index] = max(best[index], float(self._of(rows)[:, index].max()))
        return best

    def first(self, number: int) -> Array:
        """Rows of so many that may be sharpest where they are least sharp, the sharpest first."""
        likely = np.argsort(-self.of_parts.min(axis=1), kind="stable")[: max(BLOCK, number)]
        return likely[np.argsort(-self._of(likely).min(axis=1), kind="stable")][:number]

    def _of(self, rows: Array) -> Array:
        """The most that these reach by scene, (n, n_scenes): worked out for those that are new."""
        new = rows[np.isnan(self._known[rows, 0])]
        for start in range(0, len(new), BLOCK):
            some = new[start : start + BLOCK]
            imagers, scenes = self.imagers.take(some), range(self._known.shape[1])
            self._known[some] = np.stack([most_of_imagers(self.problem, index, imagers) for index in scenes], axis=1)
        return np.asarray(self._known[rows])


def least_contrast_asked(mission: Mission) -> Array:
    """The least that still counts as what a mission asks for, by scene; 0 where nothing is."""
    return np.array([(view.requirements.min_mtf_half_nyquist or 0.0) * MAY_SHOW for view in mission.views])


def most_of_imagers(problem: Problem, index: int, imagers: Imagers) -> Array:
    """The most that each imager leaves in one scene, (n,), nothing moving, at its best f-number and lamp."""
    focused, contraction = imagers.scenes[index].focused, problem.contractions[index]
    every, most = np.arange(len(imagers)), np.zeros(len(imagers))
    low, high = focused.n_low, np.maximum(focused.n_low, focused.n_high)
    lamps = np.unique(problem.lights.optics_index)
    for optics in lamps[np.unique(contraction.spectrum_of[lamps], return_index=True)[1]]:
        sharp = imagers.sharpness(problem, index, every, int(optics))
        bars = StillBars.of(sharp.asked(min_mtf=1.0, resolve_m=0.0)[0], sharp)
        for first, last in pairwise(np.geomspace(low, high, INTERVALS + 1)):
            left = bars.best_between(every, first, last, working_factor=focused.working_factor)
            most = np.maximum(most, np.minimum(*left).min(axis=1))
    return most


def most_of_parts(problem: Problem, camera: Array, lens: Array) -> Array:
    """The most that cameras with lenses leave at half the Nyquist frequency by scene, (n, n_scenes).

        sinc(nu) max over N of D(nu lambda N / p) 0.5^((nu / nu_r(N))^2)

    camera, lens : (n,) places among a problem's parts. lambda is the shortest wavelength of the scene, N any
    f-number that the lens has; of diffraction at the lower end of each interval of N, of the lens's blur at the upper.
    0..1.
    Physics page, section 8.
    """
    cameras, lenses = problem.cameras.take(camera), problem.lenses.take(lens)
    pitch, most = cameras.pixel_pitch_m, np.zeros((len(camera), len(problem.scenes)))
    ends = np.geomspace(lenses.f_number_min, np.maximum(lenses.f_number_min, lenses.f_number_max), INTERVALS + 1)
    for index, scene in enumerate(problem.scenes):
        blur = float(aberration.field_blur(1.0 if scene.view.requirements.dof_at == "corner" else 0.0))
        for first, last in pairwise(ends):
            good_for_px = aberration.lens_pitch(
                lenses.rated_pitch_m / pitch, aberration_f1_px=lenses.aberration_f1_m / pitch, f_number=last,
                exponent=lenses.aberration_exponent, field_blur=blur,
            )  # fmt: skip
            left = lens_mtf(HALF_NYQUIST_CYC_PER_PX, lens_pitch_px=good_for_px) * diffraction_mtf(
                HALF_NYQUIST_CYC_PER_PX, cycle_px=first * float(scene.wavelength_nm.min()) * 1e-9 / pitch
            )
            most[:, index] = np.maximum(most[:, index], left)
    return np.asarray(most * sinc_mtf(HALF_NYQUIST_CYC_PER_PX))
