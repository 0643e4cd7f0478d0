"""Planted defects of light scattered more than once: its attenuations, its tables, and the Monte Carlo behind them."""

from __future__ import annotations

from planted.defect import Defect

SPECTRA = "uwopt/forward/spectra.py"
FULL = "tests/evaluation/test_full_physics.py"
TABLES = "tests/forward/test_multiple.py"
MONTE_CARLO = "tests/test_multiple_scattering.py"

DEFECTS = (
    Defect(
        name="K of the lamp's leg forgets how wide the lobe is",
        file="uwopt/model/multiple.py",
        old="return np.deg2rad(LAMP_DEG) + LAMP_BY_LOBE * np.asarray(half_power_angle_rad, dtype=float)",
        new="return np.deg2rad(LAMP_DEG) + 0.0 * np.asarray(half_power_angle_rad, dtype=float)",
        test="tests/model/test_multiple.py::test_wider_lobes_lose_less_of_what_is_scattered",
    ),
    Defect(
        name="the forward veil loses on its way what the lamps' light does",
        file=SPECTRA,
        old='{"near": self.near_leg_per_m(), "wide"',
        new='{"near": self.lamp_leg_per_m(0), "wide"',
        test=f"{FULL}::test_mean_veils_under_smooth_lobes[all orders, dome]",
    ),
    Defect(
        name="the veil from elsewhere on the floor loses only what is absorbed",
        file=SPECTRA,
        old='"wide": self.veil_leg_per_m()}',
        new='"wide": 0.98 * self.veil_leg_per_m()}',
        test=f"{FULL}::test_mean_veils_under_smooth_lobes[all orders, dome]",
    ),
    Defect(
        name="pixels see no veil from elsewhere on the floor",
        file="uwopt/forward/lamp_light.py",
        old="veil = veil + wide_gain(along, across, **seen)",
        new="veil = veil + 0.0 * wide_gain(along, across, **seen)",
        test=f"{FULL}::test_darkest_pixel[all orders, dome]",
    ),
    Defect(
        name="a spot of the floor counts alike from wherever it is seen",
        file="uwopt/model/veil/wide.py",
        old="seen = share * flux[meets] * cosine / np.square(far_m)",
        new="seen = share * flux[meets] / np.square(far_m)",
        test=f"{FULL}::test_mean_veils_under_smooth_lobes[all orders, dome]",
    ),
    Defect(
        name="the bound of the forward veil forgets what comes from elsewhere",
        file="uwopt/forward/effects.py",
        old="most += min(float(np.max(wide / np.maximum(signal, TINY))), MOST_SHARE)",
        new="most += 0.0 * min(float(np.max(wide / np.maximum(signal, TINY))), MOST_SHARE)",
        test="tests/forward/test_effects.py::test_no_effect_changes_more_than_its_bound[(13, 9)]",
    ),
    Defect(
        name="the easiest water sends a veil from elsewhere",
        file="uwopt/solvers/confidence/panels.py",
        old="return self.near_leg_per_m()",
        new="return 0.9 * self.near_leg_per_m()",
        test="tests/solvers/test_confidence_proof.py::"
        "test_the_best_of_waters_is_no_worse_where_light_is_scattered_more_than_once[0.7]",
    ),
    Defect(
        name="daylight's path radiance loses c, as if what is scattered were lost",
        file="uwopt/forward/sun_light.py",
        old="absorption_per_m=scene.absorption_per_m(), backward",
        new="absorption_per_m=scene.attenuation_per_m, backward",
        test=f"{TABLES}::test_daylight_in_murky_water_is_that_of_all_orders",
    ),
    Defect(
        name="daylight from the floor loses what the lamps' light does",
        file="uwopt/forward/sun_light.py",
        old="all_light = scene.sun_leg_per_m() if self.multiple else",
        new="all_light = scene.attenuation_per_m if self.multiple else",
        test="tests/forward/test_oblique.py::test_daylight_from_an_oblique_floor_loses_what_its_way_takes",
    ),
    Defect(
        name="the Monte Carlo of daylight absorbs nothing",
        file="docs/validation/orders/daylight.py",
        old="weight = survivor(rng, weight * water.albedo, LEAST * first)",
        new="weight = survivor(rng, weight, LEAST * first)",
        test=f"{MONTE_CARLO}::test_rows_of_daylight_are_found_again",
    ),
    Defect(
        name="light that leaves out orders is bounded without the sun",
        file="uwopt/forward/effects.py",
        old='found["multiple_scattering"] = (bound + sun + other, saved_s)',
        new='found["multiple_scattering"] = (bound, saved_s)',
        test="tests/forward/test_effects.py::test_orders_of_daylight_are_kept_where_the_sun_shines",
    ),
    Defect(
        name="backscatter that is scattered again on its way to the camera is lost",
        file=SPECTRA,
        old="return both, both",
        new="return both, self.scene.attenuation_per_m",
        test=f"{FULL}::test_mean_veils_under_smooth_lobes[all orders, dome]",
    ),
    Defect(
        name="lamps of one spectrum share a table, whatever their lobes",
        file=SPECTRA,
        old="return (*self._weight_key(spectrum, efficiency, channel), self._lobes_rad[spectrum])",
        new="return self._weight_key(spectrum, efficiency, channel)",
        test=f"{TABLES}::test_lamps_of_unlike_lobes_have_tables_of_their_own",
    ),
    Defect(
        name="single scattering cannot be asked for",
        file="uwopt/forward/scene.py",
        old="return bool(self.scattering) and self.view.scene.multiple_scattering",
        new="return bool(self.scattering)",
        test=f"{TABLES}::test_single_scattering_is_what_the_scene_or_the_model_asks_for",
    ),
    Defect(
        name="nothing is said of water thicker than was tested",
        file="uwopt/evaluation/figures_by_name.py",
        old="thickness > TESTED_THICKNESS:",
        new="thickness > 1e9:",
        test=f"{TABLES}::test_a_result_says_that_it_leaves_the_tested_range[9C-True-True]",
    ),
    Defect(
        name="molecules scatter evenly",
        file="uwopt/model/scattering.py",
        old="(1 + cos + f * (1 + cos**3) / 3)",
        new="(1 + cos + f * (1 + cos) / 3)",
        test="tests/model/test_multiple.py::test_share_beyond_of_molecules_is_the_integral_of_their_function[30.0]",
    ),
    Defect(
        name="the Monte Carlo forgets half of the density of its places",
        file="docs/validation/orders/camera.py",
        old="return t, 0.5 * by_angle + 0.5 * c",
        new="return t, 0.5 * by_angle + 1.0 * c",
        test=f"{MONTE_CARLO}::test_walks_of_one_order_are_the_single_scattering_of_the_quadrature",
    ),
    Defect(
        name="photons in a slab turn by half the angle drawn",
        file="docs/validation/orders/walk.py",
        old="sine = np.sin(psi)\n    s, t, u = sine * np.cos(phi), sine * np.sin(phi), np.cos(psi)",
        new="psi = psi / 2\n    sine = np.sin(psi)\n    s, t, u = sine * np.cos(phi), sine * np.sin(phi), np.cos(psi)",
        test=f"{MONTE_CARLO}::test_an_isotropic_half_space_reflects_what_h_functions_say",
    ),
)
