"""How much each effect matters to one design, and what physics `auto` would leave out."""

from __future__ import annotations

from uwopt.evaluation.design_light import DesignLight
from uwopt.evaluation.design_model import DesignModel
from uwopt.forward import effects as influence
from uwopt.forward.designs import Hardware, SceneSettings
from uwopt.forward.problem import Problem
from uwopt.model.effects import Effects


def influences_of(problem: Problem, hardware: Hardware, given: list[SceneSettings]) -> list[influence.Influence]:
    """How much each effect matters to one design, and what physics `auto` would leave out.

    What makes its image soft is kept where it is there: the result tells sharpness whether it is asked for or not.
    """
    if problem.paper:
        return []
    plain, light = DesignModel(problem.with_effects(Effects.none()), hardware), DesignLight(problem, hardware)
    scenes = [
        influence.InScene(index, light.views[index], hardware, plain.settings(index, one), light.signal_e(index))
        for index, one in enumerate(given)
    ]
    return influence.choose(influence.judge(light.problem, scenes, information=True), problem.mission.tolerance)
