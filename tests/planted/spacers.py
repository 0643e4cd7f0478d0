"""Planted defects of spacer rings: the distances they reach, what they cost and take up, and which one is taken."""

from __future__ import annotations

from planted.defect import Defect

LENS = "tests/model/test_extension.py::"
RING = "tests/forward/test_spacers.py::"
LEAST = RING + "test_least_ring_on_which_a_lens_focuses"
SET = RING + "test_a_system_takes_the_ring_that_its_focus_needs_and_tells_what_to_set"
SEARCH = "tests/solvers/test_spacers.py::"

DEFECTS: tuple[Defect, ...] = (
    Defect(
        name="the extension is that of an image at infinity",
        file="uwopt/model/extension.py",
        old="focal_length_m**2 / np.where(reach > 0.0, reach, 1.0)",
        new="focal_length_m**2 / np.where(reach > 0.0, object_distance_m, 1.0)",
        test=LENS + "test_extension_and_distance_are_the_thin_lens_by_hand",
    ),
    Defect(
        name="a lens on a ring bears any magnification",
        file="uwopt/model/extension.py",
        old="np.minimum(own_m + beyond, most_m)",
        new="own_m + beyond",
        test=LENS + "test_a_ring_goes_no_nearer_than_the_lens_bears",
    ),
    Defect(
        name="a ring keeps infinity",
        file="uwopt/forward/spacers.py",
        old=" & (at <= far[lens] * slack)",
        new="",
        test=LEAST + "[0.16-nan]",
    ),
    Defect(
        name="the longest ring that reaches is taken",
        file="uwopt/forward/spacers.py",
        old="left = left[~reached]",
        new="left = left[:]",
        test=LEAST + "[0.26-0.0]",
    ),
    Defect(
        name="rings are for nothing in the search",
        file="uwopt/solvers/exact/imager_rules.py",
        old="{name: (spacers_m > 0.0) * each",
        new="{name: (spacers_m < 0.0) * each",
        test=SEARCH + "test_rings_make_designs_that_cost_and_weigh_more_than_their_parts",
    ),
    Defect(
        name="the scale is set as if there were no ring",
        file="uwopt/forward/spacers.py",
        old="focal_length_m=lenses.focal_length_m) - spacer_m",
        new="focal_length_m=lenses.focal_length_m) - 0.0 * spacer_m",
        test=SET,
    ),
    Defect(
        name="rings are not in the bill",
        file="uwopt/evaluation/bill.py",
        old="    if spacer_m > 0.0:\n",
        new="    if spacer_m < 0.0:\n",
        test=SET,
    ),
    Defect(
        name="a lens on a ring need not reach its focus",
        file="uwopt/objectives/requirements.py",
        old="    if np.any(np.asarray(rows.spacer_m) > 0.0):",
        new="    if np.any(np.asarray(rows.spacer_m) < 0.0):",
        test=RING + "test_a_ring_that_is_written_is_held_against_the_focus[0.6-missed1]",
    ),
    Defect(
        name="groups of ports refuse what stands on a ring",
        file="uwopt/solvers/exact/port_groups.py",
        old="ok &= np.isfinite(needed_spacer_m(lenses, dioptre, slack=COARSE_ROUND))",
        new="ok &= needed_spacer_m(lenses, dioptre, slack=COARSE_ROUND) == 0.0",
        test=SEARCH + "test_rings_make_designs_that_cost_and_weigh_more_than_their_parts",
    ),
    Defect(
        name="a ring takes no length in a housing",
        file="uwopt/forward/enclosures.py",
        old="lenses.length_m + spacers_m, lenses.pupil_m",
        new="lenses.length_m + 0.0 * spacers_m, lenses.pupil_m",
        test=RING + "test_a_ring_makes_lens_and_camera_longer",
    ),
)
