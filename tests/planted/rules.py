"""Planted defects of the rules that `solve` and `evaluate` share."""

from __future__ import annotations

from planted.defect import Defect

SCENE_ORDER = "tests/solvers/test_scene_order.py"
ONE_SET = "tests/api/test_one_set_of_rules.py"
FOCUS = "tests/forward/test_focus.py"
EVEN = "tests/forward/test_remembered.py"

DEFECTS: tuple[Defect, ...] = (
    Defect(
        name="few places of the floor stand for the whole of it",
        file="uwopt/forward/floor_light.py",
        old='("even", judged) if whole else',
        new='("even", judged) if False else',
        test=f"{EVEN}::test_few_places_refuse_no_even_floor_and_the_whole_of_it_decides",
    ),
    Defect(
        name="floors are looked at for nothing",
        file="uwopt/forward/floor_light.py",
        old='            spend("floors")\n',
        new="",
        test=f"{EVEN}::test_whole_floors_are_counted_as_work_once_an_image_and_height",
    ),
    Defect(
        name="a floor that may be dark is looked at all the same",
        file="uwopt/forward/floor_light.py",
        old="if wanted <= 0.0:",
        new="if wanted < 0.0:",
        test=f"{EVEN}::test_whole_floors_are_counted_as_work_once_an_image_and_height",
    ),
    Defect(
        name="few places of the floor refuse even ones",
        file="uwopt/forward/floor_light.py",
        old="new, **hardware) >= least",
        new="new, **hardware) >= 1.01 * least",
        test=f"{EVEN}::test_few_places_refuse_no_even_floor_and_the_whole_of_it_decides",
    ),
    Defect(
        name="beams of all scenes bent in the first scene's water",
        file="uwopt/forward/problem.py",
        old="parts.lights, [scene.n_water for scene in self.scenes], end",
        new="parts.lights, [self.scenes[0].n_water for _ in self.scenes], end",
        test=f"{SCENE_ORDER}::test_a_beam_stated_in_air_is_refracted_into_each_scenes_own_water",
    ),
    Defect(
        name="beam of the first scene's water taken in all",
        file="uwopt/forward/problem.py",
        old="return self.optics[optics].beams[scene_index]",
        new="return self.optics[optics].beams[0]",
        test=f"{SCENE_ORDER}::test_a_beam_stated_in_air_is_refracted_into_each_scenes_own_water",
    ),
    Defect(
        name="an image out of focus will do where no depth of field is asked",
        file="uwopt/objectives/requirements.py",
        old="else (scene.nominal, scene.nominal)\n",
        new="else (scene.nominal, scene.nominal)\n    if depth is None:\n        return\n",
        test=f"{ONE_SET}::test_the_nominal_altitude_must_be_sharp_where_no_depth_of_field_is_asked",
    ),
    Defect(
        name="images may lie apart where nothing fixes their rate",
        file="uwopt/objectives/requirements.py",
        old="shared = least_overlap(needs)",
        new="shared = needs.overlap",
        test=f"{ONE_SET}::test_images_must_touch_where_nothing_fixes_their_rate",
    ),
    Defect(
        name="a setting cuts a flash short",
        file="uwopt/objectives/requirements.py",
        old="np.where(led, lights.min_pulse_s, np.minimum(lights.flash_duration_s, open_s))",
        new="np.where(led, lights.min_pulse_s, 0.0 * open_s)",
        test=f"{ONE_SET}::test_no_setting_cuts_a_flash_short",
    ),
    Defect(
        name="a manual lens is set anew between scenes",
        file="uwopt/objectives/requirements.py",
        old="if lenses.motorised.all():",
        new="if len(lenses.motorised):",
        test=f"{ONE_SET}::test_a_manual_lens_cannot_be_set_anew_between_scenes",
    ),
    Defect(
        name="what the vehicle states does not bind",
        file="uwopt/api/evaluating.py",
        old="for departure in elsewhere if departure.binds]",
        new="for departure in elsewhere if departure.rule == 'orientation']",
        test=f"{ONE_SET}::test_what_the_vehicle_states_binds[light count]",
    ),
    Defect(
        name="scenes that ask for no depth of field need not be sharp",
        file="uwopt/solvers/exact/imagers.py",
        old="np.maximum(closed, n_depth)",
        new="closed",
        test=f"{FOCUS}::test_scenes_at_two_altitudes_are_both_sharp_with_the_f_number_of_the_thin_lens",
    ),
    Defect(
        name="the common focus in the middle whatever the circles of confusion",
        file="uwopt/forward/focus.py",
        old="share = coc_near / (coc_near + coc_far)",
        new="share = 0.5",
        test=f"{FOCUS}::test_the_common_focus_needs_the_least_f_number",
    ),
    Defect(
        name="evenness of a lamp that is not there refuses the sun",
        file="uwopt/solvers/exact/design_rows.py",
        old="kept = np.array([self.problem.unlit(one) for one in range(len(self.problem.parts.lights))])[light]",
        new="kept = np.array([False for one in range(len(self.problem.parts.lights))])[light]",
        test="tests/api/test_without_lamps.py::test_lamps_evenness_is_nothing_to_the_sun",
    ),
    Defect(
        name="a lamp is billed where none is used",
        file="uwopt/evaluation/bill.py",
        old="burning = [] if problem.unlit(hw.light) else lamps",
        new="burning = lamps",
        test="tests/api/test_without_lamps.py::test_nothing_is_bought_set_or_judged_of_a_lamp",
    ),
)
