"""Planted defects of waters made from a reading: relations, mixtures, their range among the doubts."""

from __future__ import annotations

from planted.defect import Defect

CLARITY = "uwopt/catalog/curves/clarity.py"
TESTS = "tests/catalog/test_clarity.py"
OTHER_WATERS = "tests/solvers/test_other_waters.py"

DEFECTS = (
    Defect(
        name="a Secchi depth forgets the diffuse attenuation",
        file=CLARITY,
        old='"c_kd": self.a_per_m + self.b_per_m + self.kd_per_m,',
        new='"c_kd": self.a_per_m + self.b_per_m,',
        test=f"{TESTS}::test_a_secchi_depth_counts_both_attenuations",
    ),
    Defect(
        name="a visibility is taken as an attenuation",
        file=CLARITY,
        old="return self.factors[end] / value if self.inverse else self.factors[end] * value",
        new="return self.factors[end] * value",
        test=f"{TESTS}::test_a_visibility_of_eight_metres_is_an_attenuation_of_0_6",
    ),
    Defect(
        name="turbidity counts what the water itself scatters",
        file=CLARITY,
        old='"b_p": self.b_per_m - _pure().b_per_m,',
        new='"b_p": self.b_per_m,',
        test=f"{TESTS}::test_two_ntu_are_particles_that_scatter_two_per_metre",
    ),
    Defect(
        name="a mixture takes the wrong part of the murkier type",
        file=CLARITY,
        old="b_per_m=self.b_per_m + share * (other.b_per_m - self.b_per_m),",
        new="b_per_m=other.b_per_m + share * (self.b_per_m - other.b_per_m),",
        test=f"{TESTS}::test_a_quarter_of_the_way_between_types_is_a_quarter_of_the_murkier",
    ),
    Defect(
        name="water itself grows with its particles",
        file=CLARITY,
        old="a_per_m=self.a_per_m + more * np.maximum(self.a_per_m - pure.a_per_m, 0.0),",
        new="a_per_m=self.a_per_m + more * self.a_per_m,",
        test=f"{TESTS}::test_beyond_the_murkiest_type_what_is_not_water_grows",
    ),
    Defect(
        name="a row of types takes the fitted table where the measured one has a type",
        file=CLARITY,
        old='wanted: JerlovTable | None = None if table == "measured" else table',
        new='wanted: JerlovTable | None = table if table != "measured" and table else "solonenko-mobley"',
        test=f"{TESTS}::test_k_d_of_the_row_agrees_with_another_survey",
    ),
    Defect(
        name="the clearest and the murkiest water of a reading are the likely one",
        file="uwopt/solvers/explain/other_waters.py",
        old="in_water(mission, i, scene, water_end=end)",
        new="in_water(mission, i, scene)",
        test=f"{OTHER_WATERS}::test_the_ends_of_a_reading_are_solved_again",
    ),
    Defect(
        name="a water made from a reading is not told",
        file="uwopt/api/common.py",
        old="for scene in problem.scenes if scene.clarity],",
        new="for scene in problem.scenes if not scene.scatters],",
        test=f"{OTHER_WATERS}::test_the_result_names_the_water_given_and_derived",
    ),
    Defect(
        name="two readings of one water pass",
        file="uwopt/mission/checks.py",
        old="    for key in given[1:]:",
        new="    for key in given[2:]:",
        test="tests/mission/test_clarity_keys.py::test_of_two_readings_the_better_known_is_kept",
    ),
    Defect(
        name="the card turns the iris behind a sealed port",
        file="uwopt/solvers/explain/worse_water.py",
        old="    if problem.lenses.motorised[hardware.lens]:",
        new="    if True:",
        test="tests/solvers/test_worse_water.py::test_behind_a_sealed_port_the_iris_stays_as_it_is",
    ),
    Defect(
        name="a swath counts what a lens would see that is focused at infinity",
        file="uwopt/solvers/exact/imager_rules.py",
        old='at_least("min_swath_m", "covered_across_m")',
        new='at_least("min_swath_m", "footprint_across_m")',
        test="tests/evaluation/test_breathing.py::test_a_proven_swath_is_seen_by_a_lens_that_moves_as_a_whole",
    ),
    Defect(
        name="overlap counts what a lens would see that is focused at infinity",
        file="uwopt/forward/breathing.py",
        old="        view, covered_along_m=kept[\"footprint_along_m\"],",
        new="        view,",
        test="tests/evaluation/test_breathing.py::test_images_overlap_through_a_lens_that_moves_as_a_whole",
    ),
    Defect(
        name="pixels do not shrink where the lens moves out",
        file="uwopt/forward/breathing.py",
        old="        pixel_along_m=np.minimum(kept[\"pixel_along_m\"], view.pixel_along_m),",
        new="        pixel_along_m=view.pixel_along_m,",
        test="tests/evaluation/test_design_model.py::test_offset_of_the_sensor_shortens_the_exposure",
    ),
    Defect(
        name="figures are of what the lens sees at infinity",
        file="uwopt/evaluation/design_model.py",
        old="        return replace(self.rows[index], view=self.view_at(index, dioptre_per_m))",
        new="        return self.rows[index]",
        test="tests/evaluation/test_breathing.py::test_swath_and_blur_are_those_of_a_lens_that_moves_as_a_whole",
    ),
)
