"""Section 2: the founding paper's figures 3, 4, 5, 7, 8 and 9, made again from this code."""

from __future__ import annotations

from typing import Any

import numpy as np
import yaml

from . import common, tank

WINDOW = common.ROOT / "problems" / "paper-tool-window.yaml"
WINDOW_SYSTEM = common.ROOT / "problems" / "paper-tool-window.system.yaml"
FLAT = {"geometry": "flat", "thickness_mm": 10, "refractive_index": 1.5}
SPEEDS_M_S, RANGES_M = np.array([0.2, 0.5, 1.0, 1.5, 2.0, 3.0]), np.linspace(0.5, 3.0, 11)
F_NUMBERS, DOF_RANGES_M = (1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0), np.linspace(0.5, 2.0, 21)
WATERS = ("I", "II", "III", "1C", "3C", "5C", "7C", "9C")


def figures(altitude_m: float, speed_m_s: float = 1.0, f_number: float = 4.0, **parts: Any) -> dict[str, Any]:
    """The tool's opening window at another altitude, speed and f-number, physics `paper`."""
    mission, system = (yaml.safe_load(path.read_text()) for path in (WINDOW, WINDOW_SYSTEM))
    mission["vehicle"] |= {"altitude_m": float(altitude_m), "speed_m_s": float(speed_m_s)}
    system["settings"]["f_number"] = f_number
    return common.figures(mission | {"physics": "paper"}, system | parts)


# ---------------------------------------------------------------- figures


def operation() -> tuple[str, float]:
    """Figure 3: frame rate and longest exposure over speed and altitude; largest error against (8), (10), (11)."""
    figure, (left, right) = common.canvas(2)
    error = 0.0
    per_pixel = 3.45e-6 / (8e-3 * 1.33)
    for speed in SPEEDS_M_S:
        seen = [figures(d, speed, port=FLAT) for d in RANGES_M]
        rate = np.array([s["frame_rate_min_hz"] for s in seen])
        longest = np.array([s["exposure_max_ms"] for s in seen])
        left.plot(RANGES_M, rate, label=f"{speed:g} m/s")
        right.plot(RANGES_M, longest, label=f"{speed:g} m/s")
        by_hand = speed / (RANGES_M * 2448 * per_pixel * 0.75), 1e3 * RANGES_M * per_pixel / speed
        error = max(error, *(np.abs(a / b - 1).max() for a, b in zip((rate, longest), by_hand, strict=True)))
    left.set(xlabel="altitude [m]", ylabel="least frame rate [Hz]", yscale="log")
    right.set(xlabel="altitude [m]", ylabel="longest exposure [ms]", yscale="log")
    left.legend(fontsize=7)
    return common.save(figure, "paper-3", "Frame rate and longest exposure over altitude and speed"), error


def depth_of_field() -> tuple[str, float]:
    """Figure 4: depth of field over aperture and distance; largest error against the thin lens (9)."""
    figure, (left, right) = common.canvas(2)
    error, f, c = 0.0, 8.0 * 1.33, np.hypot(2448, 2048) * 3.45e-3 / 1500
    for n in F_NUMBERS:
        seen = [figures(d, f_number=n, port=FLAT) for d in DOF_RANGES_M]
        near = np.array([s["dof_near_m"] for s in seen])
        far = np.array([np.inf if s["dof_far_m"] is None else s["dof_far_m"] for s in seen])
        s_mm, h = 1e3 * DOF_RANGES_M, f * f / (n * c) + f
        by_hand = s_mm * (h - f) / (h + s_mm - 2 * f), np.where(h > s_mm, s_mm * (h - f) / (h - s_mm), np.inf)
        finite = np.isfinite(by_hand[1])
        error = max(error, np.abs(1e3 * near / by_hand[0] - 1).max())
        error = max(error, np.abs(1e3 * far[finite] / by_hand[1][finite] - 1).max(initial=0.0))
        line = left.plot(DOF_RANGES_M, np.where(finite, far - near, np.nan), label=f"F{n:g}")[0]
        right.plot(DOF_RANGES_M, near, color=line.get_color())
        right.plot(DOF_RANGES_M, np.where(finite, far, np.nan), "--", color=line.get_color())
    left.set(xlabel="focus distance [m]", ylabel="depth of field [m]", yscale="log")
    right.set(xlabel="focus distance [m]", ylabel="near (full), far (dashed) [m]", ylim=(0, 8))
    left.legend(fontsize=7, ncols=2)
    return common.save(figure, "paper-4", "Depth of field over aperture and distance"), error


def spectrum_stages() -> tuple[dict[str, Any], float, float]:
    """The light of the tool's window, stage by stage, by the model's functions; electrons, and of `evaluate`."""
    from uwopt.model import lens, light, seafloor, sensor, spectrum, water

    nm = common.WAVES_NM
    a, b, _ = common.jerlov("I", continued=False)
    loss = np.exp(-2.0 * water.beam_attenuation_per_m(a, b))
    flux = light.spectral_flux_w_nm(
        20_000.0,
        relative_spectrum=spectrum.two_gaussian_led(nm),
        wavelength_nm=nm,
        photopic=common.photopic(),
    )
    floor = flux / (np.pi * 4.0) * loss  # half-angle 45 deg, 2 m
    radiance = seafloor.lambertian_radiance(floor, reflectance=0.2)
    image = lens.image_irradiance(radiance * loss, transmission=0.9, working_f_number=4.0)
    qe = common.efficiency("seed-imx250m")
    rate = sensor.electron_rate_per_m2_s_nm(image, wavelength_nm=nm, quantum_efficiency=qe)
    per_nm = rate * (3.45e-6) ** 2 * 0.86e-3
    stages = {
        "lamp [W/nm]": flux, "floor [W/m²/nm]": floor, "before the port [W/m²/sr/nm]": radiance * loss,
        "on the sensor [W/m²/nm]": image, "electrons per nm": per_nm,
    }  # fmt: skip
    return stages, float((per_nm * common.STEPS_NM).sum()), float(figures(2.0)["electrons_signal"])


def spectrum_figure() -> tuple[str, float]:
    """Figure 5: from lamp to sensor; relative difference of its integral from `evaluate`."""
    figure, (left, right) = common.canvas(2)
    stages, electrons, told = spectrum_stages()
    for name, curve in stages.items():
        left.plot(common.WAVES_NM, curve / curve.max(), label=f"{name}, peak {curve.max():.3g}")
    for water in WATERS:
        a, b, _ = common.jerlov(water, continued=False)
        arriving = common.led() * np.exp(-4.0 * (a + b))
        right.plot(common.WAVES_NM, arriving / common.led().max(), label=water)
    left.set(xlabel="wavelength [nm]", ylabel="over its peak", ylim=(0, 1.9))
    left.legend(fontsize=6.5, loc="upper right")
    right.set(xlabel="wavelength [nm]", ylabel="left after 2 m + 2 m", yscale="log", ylim=(1e-10, 2))
    right.legend(fontsize=7, ncols=4, title="Jerlov type", title_fontsize=7)
    return common.save(figure, "paper-5", "Spectrum from lamp to sensor"), electrons / told - 1.0


def tank_figure(name: str, chosen: tuple[str, ...]) -> tuple[str, float]:
    """Figures 7 to 9: measured and predicted numbers by exposure; largest error of fitted points."""
    figure, (left, right) = common.canvas(2)
    factor = tank.fits()["all"].factor
    worst = 0.0
    for color, series in zip(("C0", "C3"), chosen, strict=False):
        mine = [p for p in tank.points() if p.name == series]
        wrong = tank.errors(mine, factor)
        worst = max(
            [worst, *(abs(e) for e, p in zip(wrong, mine, strict=True) if p.fitted or tank.BARE in p.name)]
        )
        t = [p.exposure_us for p in mine]
        left.plot(t, [p.measured_dn for p in mine], "o", color=color, label=f"{series}, measured")
        left.plot(t, [factor * p.full_dn for p in mine], "-", color=color, label="predicted, one scalar")
        right.plot(t, [100 * e for e in wrong], "o-", color=color, label=series)
    left.set(xlabel="exposure [µs]", ylabel="mean number, 16 bit")
    right.set(xlabel="exposure [µs]", ylabel="error [%]")
    left.legend(fontsize=7)
    return common.save(figure, name, f"Tank: {' and '.join(chosen)}"), worst


def section() -> str:
    """The text."""
    three, three_error = operation()
    four, four_error = depth_of_field()
    five, five_error = spectrum_figure()
    seven, seven_worst = tank_figure("paper-7", ("ICX285, 30 mm F2.0", "IMX250, 30 mm F2.0"))
    eight, eight_worst = tank_figure("paper-8", ("IMX250, 30 mm F2.0", "IMX250, 12 mm F4.0"))
    nine, nine_worst = tank_figure("paper-9", ("IMX250, no lens",))
    return f"""\
**In short:** six figures made again; what 3, 7, 8 and 9 show in the paper could not be established.

The paper's own figures could not be seen here; no page that was found reproduces them. That figure 4 is depth of field
over aperture and distance and figure 5 the spectrum from lamp to sensor is known to this project at second hand. For 3,
7, 8 and 9 not even the subject is established: shown are the paper's remaining computed quantities (its tool plots
frame rate and longest exposure over speed and distance) and its three tank comparisons, numbered by us. Curves are not
compared with the paper's, which give no numbers to compare with.

Assumed throughout: the tool's opening window (IMX250, 8 mm, F4, overlap 0.25, blur 1 px, portrait, 20 000 lm,
45°, floor 0.2, water I), physics `paper`; for 3 and 4 a flat port in place of the dome, since (3) is about one.

**Figure 3** (subject assumed): least frame rate and longest exposure, over the tool's ranges of speed and distance.
Largest difference from (8), (10), (11) by hand: {common.small(three_error)}.

{three}

**Figure 4**: depth of field over the tool's ranges of aperture (F1 to F12) and distance; circle of confusion
diagonal/1500. A curve ends where the far limit is infinite. Largest difference from the thin lens (9) by hand:
{common.small(four_error)}.

{four}

**Figure 5**: the light of the window at each stage, over its peak; right, what each Jerlov type (table of Solonenko and
Mobley) leaves of the lamp over 2 m and back, on the lamp's peak. The electrons under the last curve differ from
`uwopt evaluate` by {common.percent(five_error, 3)}.

{five}

**Figure 7** (subject assumed): two sensors behind the same lens. Largest error of a fitted point
{100 * seven_worst:.1f} %.

{seven}

**Figure 8** (subject assumed): one sensor behind two lenses. Largest error {100 * eight_worst:.1f} %.

{eight}

**Figure 9** (subject assumed): the bare sensor, with the scalar of the lens sets. Largest error
{100 * nine_worst:.0f} %; see section 1.

{nine}
"""
