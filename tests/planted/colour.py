"""Planted defects of what colours and moving subjects ask for."""

from __future__ import annotations

from planted.defect import Defect

MOTION = "tests/forward/test_motion.py"
SHORT = "tests/report/test_short.py"
RISKS = "tests/api/test_risks.py"

DEFECTS: tuple[Defect, ...] = (
    Defect(
        name="a subject swims with the vehicle",
        file="uwopt/forward/motion.py",
        old="speed_m_s=vehicle.speed_m_s + subject_m_s(scene),",
        new="speed_m_s=max(vehicle.speed_m_s, subject_m_s(scene)),",
        test=f"{MOTION}::test_it_may_swim_against_the_vehicle",
    ),
    Defect(
        name="a subject never swims across",
        file="uwopt/forward/motion.py",
        old="return dict(speed_m_s=subject_m_s(scene), rotation",
        new="return dict(speed_m_s=0.0, rotation",
        test=f"{MOTION}::test_it_may_swim_across_while_the_vehicle_rolls",
    ),
    Defect(
        name="a subject brings the next image sooner",
        file="uwopt/forward/figures.py",
        old="    speed = scene.view.vehicle.speed_m_s\n    if speed == 0.0:",
        new="    speed = scene.view.vehicle.speed_m_s + subject_m_s(scene)\n    if speed == 0.0:",
        test=f"{MOTION}::test_overlap_and_frame_rate_are_the_vehicles_alone",
    ),
    Defect(
        name="a subject is told to decide where blur has room",
        file="uwopt/report/text/short.py",
        old='m.requirement == "max_blur_px" and m.binding for m',
        new='m.requirement == "max_blur_px" for m',
        test=f"{SHORT}::test_subject_that_decides_the_exposure_is_told",
    ),
    Defect(
        name="smear is told though a limit of blur is asked",
        file="uwopt/api/risks.py",
        old='if not swim or any(margin.requirement == "max_blur_px" for margin in margins(design)):',
        new="if not swim:",
        test=f"{RISKS}::test_smeared_subjects_are_told_where_no_limit_of_blur_is_asked",
    ),
    Defect(
        name="nobody tells what sensor was chosen",
        file="uwopt/report/text/short.py",
        old="for note in result.warnings if note.code == COLOUR_LEFT_OPEN]",
        new="for note in result.warnings if note.code != COLOUR_LEFT_OPEN]",
        test=f"{SHORT}::test_sensor_that_nobody_asked_for_is_told_on_the_page_and_is_no_risk",
    ),
    Defect(
        name="the chosen sensor is told where it was asked for",
        file="uwopt/solvers/recommend.py",
        old='if any(view.requirements.colour != "any" for view in problem.mission.views):',
        new="if not problem.mission.views:",
        test="tests/solvers/test_colour.py::test_the_sensor_is_told_where_the_mission_leaves_it_open",
    ),
)
