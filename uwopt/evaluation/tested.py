"""Where a mission leaves the range in which light scattered more than once was tested."""

from __future__ import annotations

import numpy as np

from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.scene import DESIGN_WAVELENGTH_NM
from uwopt.model.beam import half_power_angle_rad
from uwopt.model.multiple import TESTED_FROM, TESTED_LOBES_DEG, TESTED_THICKNESS
from uwopt.results.design import Note


def tested_notes(model: DesignModel) -> list[Note]:
    """Warnings of water so thick, or of lobes so narrow or wide, that light of all orders was not tested there."""
    notes, problem = [], model.problem
    narrow, wide = TESTED_LOBES_DEG
    for index, scene in enumerate(problem.scenes):
        thickness = float(scene.range_m[-1]) * float(
            np.interp(DESIGN_WAVELENGTH_NM, scene.wavelength_nm, scene.attenuation_per_m)
        )
        if not scene.counts_orders or scene.paper or thickness <= TESTED_FROM:
            continue
        if thickness > TESTED_THICKNESS:
            text = (
                f"{scene.name}: the target is {thickness:.1f} attenuation lengths away; light scattered more than "
                f"once was tested up to {TESTED_THICKNESS:g}, beyond that signal and veils may be off by 20 % and "
                "more; go closer"
            )
            notes.append(Note("thick_water", "vehicle.altitude_m", text))
        beam = problem.beam(index, model.optics)
        lobe_deg = float(np.rad2deg(half_power_angle_rad(beam)))
        if not problem.unlit(model.hardware.light) and not narrow <= lobe_deg <= wide:
            text = (
                f"{scene.name}: the lamps' lobe is {lobe_deg:.2g} deg to half power in water; light scattered more "
                f"than once was tested under lobes of {narrow:g} to {wide:g} deg"
            )
            notes.append(Note("untested_lobe", "light.beam_half_angle_deg", text))
    return notes
