"""Planted defects of plots and of the page that explores: what is drawn, and what the controls say."""

from __future__ import annotations

from planted.defect import Defect

STATES = "tests/explore/test_state.py"
PLOTS = "tests/explore/test_plotting.py"

DEFECTS = (
    Defect(
        name="work of a page that a script started cannot be stopped",
        file="uwopt/explore/jobs.py",
        old="    signal.signal(signal.SIGINT, signal.default_int_handler)",
        new="    pass",
        test="tests/explore/test_state.py::test_a_map_that_is_stopped_keeps_its_points",
    ),
    Defect(
        name="a ceiling is drawn below the lamps",
        file="uwopt/explore/assets/lamps.js",
        old="rig.looks_up ? -1 : 1",
        new="1",
        test="tests/explore/test_page.py::test_a_ceiling_is_drawn_above_the_lamps",
    ),
    Defect(
        name="a rig below a ceiling is told as one above a floor",
        file="uwopt/explore/outcome.py",
        old='.get("target") == "ceiling"',
        new='.get("target") == "roof"',
        test="tests/explore/test_page.py::test_a_rig_below_a_ceiling_is_told_as_one",
    ),
    Defect(
        name="a map's rows are its columns",
        file="uwopt/api/mapping.py",
        old="values[row][column], met[row][column] = found",
        new="values[row][column - 1], met[row][column] = found",
        test=f"{PLOTS}::test_map_holds_what_evaluate_says",
    ),
    Defect(
        name="the lamps' attenuation is drawn as the camera's",
        file="uwopt/report/pictures/passing.py",
        old="camera_leg_per_m=scene.attenuation_per_m,",
        new="camera_leg_per_m=2.0 * scene.attenuation_per_m,",
        test=f"{PLOTS}::test_attenuation_is_that_of_the_table",
    ),
    Defect(
        name="an image is empty",
        file="uwopt/report/pictures/static.py",
        old="for part, picture in zip(parts, pictures, strict=True):",
        new="for part, picture in zip(parts[:0], pictures[:0], strict=True):",
        test=f"{PLOTS}::test_images_are_images_of_every_pane",
    ),
    Defect(
        name="a figure is told of another system",
        file="uwopt/explore/showing.py",
        old="made.append(outcomes.result(state, index))",
        new="made.append(outcomes.result(state, 0 * index))",
        test="tests/explore/test_page.py::test_systems_stand_side_by_side_and_the_address_brings_them_back",
    ),
    Defect(
        name="the height is seen as wide as the width",
        file="uwopt/explore/outcome.py",
        old='math.atan(0.5 * figures[f"fov_{side}_m"] / altitude)',
        new='math.atan(0.5 * figures["fov_x_m"] / altitude)',
        test=f"{STATES}::test_angles_are_those_of_the_footprint",
    ),
    Defect(
        name="a result is kept without its own files",
        file="uwopt/explore/outcome.py",
        old='inputs = [state["mission"], state["systems"][index], state["files"]]',
        new='inputs = [state["mission"], state["systems"][index]]',
        test=f"{STATES}::test_own_water_is_read_and_no_path_is_told",
    ),
    Defect(
        name="files of parts may be any of the server",
        file="uwopt/explore/state.py",
        old="own = {str(name) for name in given if name is not None}",
        new="own = set()",
        test=f"{STATES}::test_files_of_the_server_cannot_be_named[catalog-files-name2]",
    ),
    Defect(
        name="a file names others in folders",
        file="uwopt/explore/state.py",
        old=r"""re.search(r"[/\\]|^~", said)""",
        new=r"""re.search(r"[\\]|^~", said)""",
        test=f"{STATES}::test_files_that_are_unfit_are_refused_with_the_reason",
    ),
    Defect(
        name="another name of this machine is answered",
        file="uwopt/explore/server.py",
        old='if self.hosts is not None and asked.strip("[]") not in self.hosts:',
        new="if self.hosts is not None and not asked:",
        test=f"{STATES}::test_only_this_machine_is_answered",
    ),
    Defect(
        name="an address of all interfaces is taken for one's own",
        file="uwopt/explore/serve.py",
        old="return ipaddress.ip_address(host).is_loopback",
        new="return ipaddress.ip_address(host).is_private",
        test=f"{STATES}::test_command_says_where_it_listens[0.0.0.0-True]",
    ),
    Defect(
        name="a control of one scene turns them all",
        file="uwopt/explore/state.py",
        old='first = mission["scenes"][state["scene"]]',
        new='first = mission["scenes"][0]',
        test=f"{STATES}::test_controls_act_on_the_scene_that_is_shown",
    ),
    Defect(
        name="what is pinned is free",
        file="uwopt/explore/jobs.py",
        old="catalog[PATTERNS[kind]] = [system[kind]]",
        new="catalog[PATTERNS[kind]] = []",
        test=f"{STATES}::test_what_is_pinned_is_the_only_choice",
    ),
    Defect(
        name="a pinned setting is free",
        file="uwopt/explore/jobs.py",
        old="fixed[name] = float(values[0])",
        new="pass",
        test=f"{STATES}::test_settings_are_pinned_as_they_are_set",
    ),
    Defect(
        name="an address unpacks to any size",
        file="uwopt/explore/state.py",
        old="MOST_ADDRESS + 4]), MOST_FILE_BYTES)",
        new="MOST_ADDRESS + 4]))",
        test=f"{STATES}::test_an_address_that_would_fill_the_memory_is_refused",
    ),
    Defect(
        name="lamps return to where they once were moved",
        file="uwopt/explore/state.py",
        old='if not moved or moved.get("move") == state.get("move"):',
        new="if not moved:",
        test=f"{STATES}::test_lamps_that_were_moved_stand_there_once",
    ),
    Defect(
        name="a map that is stopped is lost",
        file="uwopt/api/mapping.py",
        old="    except KeyboardInterrupt:  # what is there is drawn",
        new="    except ZeroDivisionError:  # what is there is drawn",
        test=f"{STATES}::test_a_map_that_is_stopped_keeps_its_points",
    ),
    Defect(
        name="what was found is handed over twice",
        file="uwopt/explore/server.py",
        old="job.is_handed_over = True",
        new="job.is_handed_over = False",
        test=f"{STATES}::test_what_was_found_is_handed_over_once",
    ),
    Defect(
        name="a recommended system forgets its gain",
        file="uwopt/results/design.py",
        old='STATED = ("f_number", "exposure_ms", "pulse_ms", "gain",',
        new='STATED = ("f_number", "exposure_ms", "pulse_ms",',
        test=f"{PLOTS}::test_without_a_system_what_is_recommended_is_drawn",
    ),
)
