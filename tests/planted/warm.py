"""Planted defects of searches that use what is known of missions before."""

from __future__ import annotations

from planted.defect import Defect

SEARCHES, KEPT = (f"uwopt/solvers/warm/{name}.py" for name in ("searches", "kept"))
TESTS = "tests/solvers/test_warm.py"
ORDER = f"{TESTS}::test_missions_in_any_order_have_the_optima_of_their_own_searches"

DEFECTS = (
    Defect(
        name="the veil's loss table is that of another attenuation",
        file="uwopt/forward/spectra.py",
        old="legs = (k_lamp_per_m, c_camera_per_m, *(() if k_camera_per_m is None else (k_camera_per_m,)))",
        new="legs = (k_lamp_per_m, c_camera_per_m)",
        test="tests/forward/test_loss_tables.py::test_another_table_is_that_of_what_is_asked[k_camera_per_m]",
    ),
    Defect(
        name="what is found refutes no proof made before",
        file=KEPT,
        old="if any(one.asks.asks_no_more(asks) and is_below",
        new="if any(False and is_below",
        test=f"{TESTS}::test_a_wrong_warm_start_is_caught[a few parts]",
    ),
    Defect(
        name="a proof is held against nothing that was found before",
        file=KEPT,
        old="if asks.asks_no_more(stricter) and is_below(goal, reached, lower_bound):",
        new="if asks == stricter and is_below(goal, reached, lower_bound):",
        test=f"{TESTS}::test_a_wrong_proof_is_caught_by_what_was_shown_before",
    ),
    Defect(
        name="a ceiling that nothing keeps below stays",
        file=SEARCHES,
        old="if not sought.outcome.best and sought.outcome.complete and math.isfinite(ceiling):",
        new="if False:",
        test=f"{TESTS}::test_a_ceiling_that_is_too_low_hides_nothing",
    ),
    Defect(
        name="imagers of another temperature of the water are taken for these",
        file=SEARCHES,
        old="key = apart_from_light(problem.mission), index, selection.indices",
        new="key = selection.indices",
        test=f"{TESTS}::test_other_light_has_the_imagers_of_the_last",
    ),
    Defect(
        name="each search by bounds has tables of light of its own",
        file=SEARCHES,
        old="lights=lights, widest_m=kept.widest_m",
        new="lights=lights",
        test=f"{TESTS}::test_searches_by_bounds_have_the_tables_of_the_first",
    ),
    Defect(
        name="what is found below a guess counts above it too",
        file=SEARCHES,
        old="if sought.outcome.complete and reached > most:",
        new="if sought.outcome.complete and math.isinf(reached):",
        test=f"{ORDER}[2]",
    ),
    Defect(
        name="bounds serve missions that ask for less",
        file="uwopt/mission/strictness.py",
        old="all(mine <= its for mine, its in zip",
        new="any(True for mine, its in zip",
        test=f"{TESTS}::test_bounds_serve_no_mission_that_asks_for_less",
    ),
    Defect(
        name="bounds made anew hold for the mission before",
        file=SEARCHES,
        old="family.keep(stage.asks, kept.with_some(some, made))",
        new="family.keep(Asking(stage.asks.family, tuple(-math.inf for _ in stage.asks.amounts)), "
        "kept.with_some(some, made))",
        test=f"{ORDER}[2]",
    ),
    Defect(
        name="bounds of a mission met are those of the next",
        file=SEARCHES,
        old="search = self._of_nodes(met.mission, kept, kept.node)",
        new="search = self._of_nodes(met.mission, kept, kept.within(met.minimised))",
        test=f"{ORDER}[1]",
    ),
    Defect(
        name="nodes that were not bounded anew are forgotten",
        file=KEPT,
        old="node = np.concatenate([self.node[rest], made.node[new]])\n"
        "        least = np.concatenate([self.least[rest], np.maximum(old, made.least[new])])",
        new="node = made.node[new]\n        least = np.maximum(old, made.least[new])",
        test=f"{TESTS}::test_bounds_made_anew_stand_in_for_those_of_their_nodes_alone",
    ),
    Defect(
        name="all nodes are searched whatever their bound",
        file=KEPT,
        old="for value in (beyond, most))",
        new="for value in (-np.inf, np.inf))",
        test=f"{TESTS}::test_many_missions_look_at_a_fifth_of_the_imagers",
    ),
    Defect(
        name="a housing stands for smaller ones",
        file="uwopt/mission/strictness.py",
        old="if name in OF_HOUSINGS and mission.catalog.housing",
        new="if name in () and mission.catalog.housing",
        test=f"{TESTS}::test_sizes_of_housings_are_not_compared_where_one_stands_for_others",
    ),
    Defect(
        name="fine detail is asked of imagers that there are not",
        file="uwopt/solvers/exact/bounds.py",
        old="if len(left) == 0:",
        new="if len(left) < 0:",
        test=f"{TESTS}::test_where_no_imager_passes_there_are_no_bounds_though_fine_detail_is_asked_for",
    ),
)
