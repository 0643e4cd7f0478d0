"""How much each effect matters to one design, and what physics `auto` would leave out."""

from __future__ import annotations

import numpy as np

from uwopt.evaluation.design_model import DesignModel
from uwopt.forward import effects as influence
from uwopt.forward.batch import Batch
from uwopt.forward.designs import Designs, Hardware, SceneSettings
from uwopt.forward.problem import Problem
from uwopt.model.effects import Effects


def influences_of(problem: Problem, hardware: Hardware, given: list[SceneSettings]) -> list[influence.Influence]:
    """How much each effect matters to one design, and what physics `auto` would leave out.

    What makes its image soft is kept where it is there: the result tells sharpness whether it is asked for or not.
    """
    if problem.paper:
        return []
    plain = DesignModel(problem.with_effects(Effects.none()), hardware)
    settings = [plain.settings(index, one) for index, one in enumerate(given)]
    one = np.array([0])
    designs = Designs(
        one + hardware.camera, one + hardware.lens, one + hardware.port, np.array([hardware.landscape]),
        one + hardware.light, one + hardware.count, hardware.mount,
    )  # fmt: skip
    batch = Batch(problem, designs)
    return batch.influences(problem.mission.tolerance, settings, information=True)
