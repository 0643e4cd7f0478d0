"""Planted defects of walls and targets in open water: their keys, and the water behind them."""

from __future__ import annotations

from planted.defect import Defect

KEYS, SEEN = "tests/mission/test_targets.py", "tests/forward/test_targets.py"
SEARCHED = "tests/solvers/test_mid_water.py"
CHECKS = "uwopt/mission/checks.py"

DEFECTS = (
    Defect(
        name="daylight on a wall is refused without a way to an answer",
        file=CHECKS,
        old='        if target != "ceiling":\n            text += (',
        new='        if target == "ceiling":\n            text += (',
        test="tests/mission/test_targets.py::test_daylight_is_reckoned_on_floors_alone",
    ),
    Defect(
        name="a change of a wall is told by a key that its file does not have",
        file="uwopt/report/text/looked_at.py",
        old="        said = keys.get(spoken) or (way if",
        new="        said = (way if",
        test="tests/report/test_looked_at.py::test_a_key_is_told_as_the_missions_file_has_it",
    ),
    Defect(
        name="a comment says what a key is called",
        file="uwopt/report/text/looked_at.py",
        old="^[^#\\n]*\\b{name}",
        new="\\b{name}",
        test="tests/report/test_looked_at.py::test_a_key_is_told_as_the_missions_file_has_it",
    ),
    Defect(
        name="a camera that looks up is drawn above what it sees",
        file="uwopt/report/pictures/drawing.py",
        old="    if not rig.looks_up:\n",
        new="    if True:\n",
        test="tests/report/test_drawing.py"
        "::test_a_camera_that_looks_up_stands_below_what_it_sees_and_its_words_upright",
    ),
    Defect(
        name="words of a drawing are turned over with it",
        file="uwopt/report/pictures/drawing.py",
        old='LABEL.sub(upright_again, "".join(parts))',
        new='"".join(parts)',
        test="tests/report/test_drawing.py"
        "::test_a_camera_that_looks_up_stands_below_what_it_sees_and_its_words_upright",
    ),
    Defect(
        name="a ceiling is drawn as a floor",
        file="uwopt/report/pictures/curves.py",
        old='looks_up=scene.view.scene.target == "ceiling",',
        new="looks_up=False,",
        test="tests/report/test_drawing.py::test_a_ceiling_is_seen_from_below",
    ),
    Defect(
        name="a page changes its scripts with its texts",
        file="uwopt/report/text/looked_at.py",
        old="part if n % 2 else said(part)",
        new="said(part)",
        test="tests/report/test_looked_at.py::test_only_the_texts_of_a_page_change",
    ),
    Defect(
        name="tables of walls are out of line",
        file="uwopt/report/text/looked_at.py",
        old='return said + " " * max(len(found[0]) - len(said), 1) if found[2] else said',
        new='return said + (found[2] or "")',
        test="tests/report/test_looked_at.py::test_columns_of_a_table_stay_in_line",
    ),
    Defect(
        name="a wall's distance is told by the key of an altitude",
        file="uwopt/report/text/looked_at.py",
        old="(s?|_m|_tolerance_m)",
        new="(s?)",
        test="tests/report/test_looked_at.py::test_keys_are_told_by_the_name_that_a_wall_has_for_them",
    ),
    Defect(
        name="a slip in distance_m is held against altitudes alone",
        file="uwopt/documents/validation.py",
        old="known = spelled_keys(here) if here else ()",
        new="known = tuple(keys_of(here)) if here else ()",
        test=f"{KEYS}::test_an_unknown_key_is_held_against_these_names_too",
    ),
    Defect(
        name="of two names of a distance one is dropped in silence",
        file=CHECKS,
        old="if made.get(usual) is not None and value is not None:",
        new="if False:",
        test=f"{KEYS}::test_faults_name_the_key_as_it_was_written",
    ),
    Defect(
        name="a fault of a distance is told of an altitude",
        file=CHECKS,
        old="for named in (path, *others):",
        new="for named in (path,):",
        test=f"{KEYS}::test_faults_name_the_key_as_it_was_written",
    ),
    Defect(
        name="mid-water takes an overlap",
        file=CHECKS,
        old='for key in ("overlap", "min_area_m2_h"):',
        new='for key in ("min_area_m2_h",):',
        test=f"{KEYS}::test_what_has_no_meaning_in_mid_water_is_told",
    ),
    Defect(
        name="mid-water leaves the frame rate open",
        file=CHECKS,
        old='if target == "mid_water" and wanted.get("frame_interval_s") is None:',
        new="if False:",
        test=f"{KEYS}::test_what_has_no_meaning_in_mid_water_is_told",
    ),
    Defect(
        name="the sun shines on a wall as on a floor",
        file=CHECKS,
        old='if target != "floor" and scene.get("sun_lux"):',
        new="if False:",
        test=f"{KEYS}::test_daylight_is_reckoned_on_floors_alone",
    ),
    Defect(
        name="a camera before a wall works above its depth",
        file=CHECKS,
        old='works_at_m, why = (depth_m, "") if level else',
        new='works_at_m, why = (depth_m, "") if False else',
        test=f"{KEYS}::test_a_camera_that_looks_level_works_at_the_depth_of_its_target",
    ),
    Defect(
        name="ice floats above the water",
        file=CHECKS,
        old="if distance_m > depth_m:",
        new="if False:",
        test=f"{KEYS}::test_a_ceiling_is_no_higher_than_the_water",
    ),
    Defect(
        name="a camera that looks up is told of an angle that is too large",
        file="uwopt/mission/keys.py",
        old="if pitch_deg > UP_DEG:",
        new="if False:",
        test=f"{KEYS}::test_a_pitch_told_from_straight_down_is_told_what_it_looks_at",
    ),
    Defect(
        name="lamps of a camera that looks up are aimed ahead",
        file="uwopt/report/text/looked_at.py",
        old='"straight up" if target == "ceiling" else "straight ahead"',
        new='"straight ahead"',
        test="tests/report/test_looked_at.py::test_a_wall_has_a_distance",
    ),
    Defect(
        name="open water ends soon behind its targets",
        file="uwopt/forward/spectra.py",
        old="ENDLESS = 16.0",
        new="ENDLESS = 1.2",
        test=f"{SEEN}::test_open_water_sends_back_the_light_of_the_whole_ray",
    ),
    Defect(
        name="the water behind targets saturates nothing",
        file="uwopt/forward/figures.py",
        old="saturation_fraction=saturation_fraction(scene, cam, bright_level, bright, dark),",
        new="saturation_fraction=saturation_fraction(scene, cam, level, every, dark),",
        test=f"{SEEN}::test_the_brighter_of_target_and_water_is_what_must_not_saturate",
    ),
    Defect(
        name="auto leaves out the backscatter that is brightest in the image",
        file="uwopt/forward/effects.py",
        old="if np.any(behind > signal.max(axis=1)):",
        new="if False:",
        test=f"{SEEN}::test_auto_keeps_backscatter_where_open_water_is_the_brightest",
    ),
    Defect(
        name="the search lets open water saturate",
        file="uwopt/forward/scene_rows.py",
        old="return every if self.background_e is None else",
        new="return every if True else",
        test=f"{SEARCHED}::test_a_wanted_level_of_the_target_leaves_room_for_the_water_behind_it",
    ),
    Defect(
        name="the least gain of settings forgets open water",
        file="uwopt/solvers/settings/windows.py",
        old="    total = rows.bright_e\n    nominal, none",
        new="    total = rows.total_e\n    nominal, none",
        test=f"{SEARCHED}::test_the_well_holds_open_water_and_so_limits_the_signal_of_the_target",
    ),
)
