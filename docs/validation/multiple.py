# ruff: noqa: E501 - a line of the page's text is as long as the expressions in it
"""The section on light scattered more than once: the model against a Monte Carlo of all orders."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache

import numpy as np

from uwopt.model.multiple import TESTED_THICKNESS as THIN

from . import common
from .orders import cases, checks, colours, daylight, detail, forms, low_sun, model, sunlit, ways
from .orders.cases import TALLIES, Case, Light
from .orders.model import Legs

BANDS = ((0.2, 1.0), (1.0, 2.0), (2.0, 4.0), (4.0, 8.0))  # of c d
SHOWN = (*TALLIES, "contrast")
CORNERS = ("near corner", "far corner")
Form = Callable[[Case], Legs]


ALL, ONCE, KEPT = "all orders", "single scattering", "the lamps' own lobes"
DIM = ((0.2, np.inf), (0.05, 0.2), (0.0, 0.05))  # of corners: signal over the image mean's
SEEN = {"ff 0.005": 0.2e-3, "ff 0.0183": 0.2e-3, "ff 0.03": 0.2e-3, "petzold HAOCE 11": 0.5e-3, "petzold NUC 2200": 0.5e-3}
CYCLES_PER_PX = (0.5, 0.25, 0.1)
DOUBT = 0.05  # of what walks say of one sun
FAR_OFF = 0.15  # of corners: the mark
NARROW_DEG = 20.0  # of lobes
FORMS: dict[str, Form] = {ALL: forms.effective, ONCE: model.single}
BESIDE: dict[str, Form] = {KEPT: forms.attenuations}
ASLANT = 29  # a case of light that turns into a hollow phase function, under a narrow lobe that is tilted


@cache
def errors(name: str, places: tuple[str, ...], use: str | None = None) -> tuple[tuple[Light, dict[str, float]], ...]:
    """Rows with the relative errors of a form, at some places, of one half of the table or of all."""
    return tuple(
        (row, forms.errors(row, (FORMS | BESIDE)[name])) for row in cases.read() if row.place in places and use in (None, row.case.use)
    )  # fmt: skip


def within(off: Sequence[float], limit: float) -> str:
    """Share of errors below a limit."""
    return f"{100 * float(np.mean(np.abs(off) <= limit)):.0f} %"


def judged(name: str, places: tuple[str, ...], tally: str, *, thin: bool) -> list[float]:
    """Errors of the held-out half."""
    return [off[tally] for row, off in errors(name, places, "held out") if (row.case.thickness <= THIN) == thin]


def band_rows() -> list[list[str]]:
    """Median and extremes of all image means by c d."""
    rows = []
    for low, high in BANDS:
        for name in FORMS:
            off = [e for row, e in errors(name, ("mean",)) if low <= row.case.thickness < high]
            cells = [np.array([e[tally] for e in off]) for tally in SHOWN]
            rows.append(
                [f"{low:g} to {high:g}", str(len(off)), name]
                + [f"{common.percent(float(np.median(c)))} ({common.percent(float(c.min()), 0)} to {common.percent(float(c.max()), 0)})" for c in cells]
            )
    return rows


def mark_rows() -> list[list[str]]:
    """The held-out half against the marks."""
    rows = []
    for name in FORMS | BESIDE:
        for tally in SHOWN:
            off = judged(name, ("mean",), tally, thin=True)
            corner = judged(name, CORNERS, tally, thin=True)
            thick = judged(name, ("mean",), tally, thin=False)
            rows.append(
                [name, tally, within(off, 0.05), within(off, 0.10), common.percent(common.farthest(off)), within(corner, 0.15), within(thick, 0.20)]
            )
    return rows


def corner_rows() -> list[list[str]]:
    """Held-out corners up to c d = 4 within 15 %, by how dim they are; and under lobes that nothing widens."""
    means = {row.case.number: row.value["signal"] for row in cases.read() if row.place == "mean"}
    rows = []
    for name, form in ((ALL, forms.effective), (KEPT, forms.attenuations)):
        corners = [row for row in forms.rows_of("held out") if "corner" in row.place]
        off = [(row.value["signal"] / means[row.case.number], forms.errors(row, form)) for row in corners]
        for low, high in DIM:
            found = [e for share, e in off if low <= share < high]
            label = f"over {100 * low:g} %" if high == np.inf else f"{100 * low:g} to {100 * high:g} %"
            rows.append([name, label, str(len(found)), *(within([e[tally] for e in found], 0.15) for tally in SHOWN)])
    return rows


def without(form: Form, tally: str, *, albedo: float = 0.0) -> str:
    """By how much image means of the model change beyond c d = 4 where a form leaves something out, least and most."""
    thick = [row.case for row in cases.read() if row.place == "mean" and row.case.thickness > THIN and row.case.albedo >= albedo]
    off = [
        model.uwopt_light(case, "mean", form(case))[tally] / model.uwopt_light(case, "mean", forms.effective(case))[tally] - 1.0
        for case in thick
    ]  # fmt: skip
    return f"{common.percent(min(off))} to {common.percent(max(off))}"


def worst_text() -> str:
    """The image mean of backscatter that is off most up to c d = 4."""
    row, off = max(
        ((row, off) for row, off in errors(ALL, ("mean",)) if row.case.thickness <= THIN),
        key=lambda pair: abs(pair[1]["backscatter"]),
    )
    case, doubt = row.case, row.error["backscatter"] / row.value["backscatter"]
    return f"""\
The image mean of backscatter that is off most up to c d = 4 is that of case {case.number} ({case.use}): {common.percent(off['backscatter'])}, σ {100 * doubt:.1f} %;
{case.phase}, albedo {case.albedo:.2f}, c d {case.thickness:.2f}, a lobe of {case.lobe_half_deg:.0f}°."""


def doubt_of(row: Light, tally: str) -> float:
    """Standard error of a tally over its value, or of contrast."""
    by = {each: row.error[each] / row.value[each] for each in TALLIES}
    if tally in by:
        return by[tally]
    whole = sum(row.value[each] for each in TALLIES)
    share = {each: row.value[each] / whole for each in TALLIES}
    veils = ((share[each] * by[each]) ** 2 for each in TALLIES[1:])
    return float(np.sqrt(((1.0 - share["signal"]) * by["signal"]) ** 2 + sum(veils)))


def far_off() -> list[tuple[Light, str, float, float]]:
    """Corners up to c d = 4 that are off by more than 15 %: what of them, by how much, and its σ."""
    found = [
        (row, tally, off[tally], (1.0 + off[tally]) * doubt_of(row, tally))
        for row, off in errors(ALL, CORNERS) if row.case.thickness <= THIN for tally in SHOWN
    ]  # fmt: skip
    return sorted((one for one in found if abs(one[2]) > FAR_OFF), key=lambda one: (one[0].case.use, one[0].case.number))


def corner_text() -> str:
    """Corners that are off by more than 15 %, and whether the walks' own doubt would explain that."""
    means = {row.case.number: row.value for row in cases.read() if row.place == "mean"}

    def of_mean(row: Light, tally: str) -> str:
        kind = tally if tally in TALLIES else "signal"
        return f"{100 * row.value[kind] / means[row.case.number][kind]:.1f} %"

    rows = [
        [
            f"{row.case.number}, {row.place.split()[0]}", row.case.use, f"{row.case.phase}, {row.case.albedo:.2f}, {row.case.thickness:.2f}",
            f"{row.case.lobe_half_deg:.0f}°, {row.case.tilt_deg:.0f}°", tally, of_mean(row, tally), f"{common.percent(off)} ± {100 * sigma:.1f} %",
            "yes" if abs(off) - FAR_OFF < 2.0 * sigma else "no",
        ]
        for row, tally, off, sigma in far_off()
    ]  # fmt: skip
    again = [row for row in cases.read() if row.walks > cases.WALKS[row.place]]
    return f"""\
Corners up to c d = {THIN:g} that are off by more than {100 * FAR_OFF:g} %, with one σ of the Monte Carlo, and whether two would take them within; beside that the corner's light of this
kind over the image mean's (of contrast: of the signal):

{common.table(["case, corner", "half", "water: phase function, albedo, c d", "lobe, tilt", "what", "of the mean", "off", "within by 2 σ"], rows)}

Such light is rare: a walk finds it by one large turn, and few walks do. Rows up to c d = {THIN:g} that the usual {cases.WALKS[CORNERS[0]]} walks leave in doubt by more than {100 * cases.DOUBT:g} % of a
value were computed afresh by up to {cases.MORE[-1]} times as many ({len(again)} of them, σ of signal, veil and backscatter now at most {', '.join(f"{100 * max(doubt_of(row, tally) for row in again):.1f}" for tally in TALLIES)} %)."""


def ways_text() -> str:
    """Which way from the lamp would widen a lobe: several, fitted on one half and judged on the other."""
    used = (forms.USED.lamp, forms.USED.lamp_by_lobe)
    height = next(iter(ways.WAYS))
    found = {f"{height}, constants in use": ways.judged(height, used)} | {name: ways.judged(name) for name in ways.WAYS}
    rows = []
    for name, one in found.items():
        cells = [name, ", ".join(f"{x:.3g}" for x in one.constants)]
        for use in ("fit", "held out"):
            cells += [common.percent(common.farthest(one.means[use])), f"{100 * float(np.sqrt(np.mean(one.corners[use] ** 2))):.1f} %"]
            cells.append(f"{within(list(one.corners[use]), FAR_OFF)}, {common.percent(common.farthest(one.corners[use]), 0)}")
        rows.append(cells)
    (row,) = [row for row in forms.rows_of("held out") if row.case.number == ASLANT and row.place == CORNERS[0]]
    case = row.case
    corner_m = float(np.sqrt(case.altitude_m**2 * (1.0 + case.tangent**2) + (case.tangent * case.altitude_m - case.baseline_m) ** 2))
    narrow = [abs(one.case.tilt_deg) for one in forms.means("fit") if one.case.lobe_half_deg <= NARROW_DEG]
    steepest = max(narrow)
    heads = [f"{use}: {what}" for use in ("fit", "held out") for what in ("largest mean", "corners, rms", f"within {100 * FAR_OFF:g} %, largest")]
    return f"""\
The signal that is off most in a corner is that of case {case.number}: a lobe of {case.lobe_half_deg:.0f}° tilted by {abs(case.tilt_deg):.0f}° is widened by the lamp's height over
the floor, {case.altitude_m:.2f} m, but its light goes {corner_m:.2f} m to the near corner. Other ways from the lamp, of each place its own, with the two constants of the lamps' way
fitted again for each on signals of the fit half up to c d = {THIN:g} (corners a third of means), and judged on the other half (`docs/validation/orders/ways.py`):

{common.table(["way that widens", "constants", *heads], rows)}

The lamp's height stays: ways between it and the straight one follow the fit half's corners better, by a K near c under narrow lobes, but then lose the image mean of case {case.number},
more tilted than any lobe up to {NARROW_DEG:g}° of the fit half ({steepest:.0f}° at most)."""


def aslant_text() -> str:
    """What the phase function as turned light meets it changes: one case, both halves, and thick water."""

    def straight(case: Case) -> Legs:
        return forms.effective(case)._replace(phase=None)

    def off(rows: Sequence[Light], form: Form) -> list[float]:
        return [forms.error(row, form(row.case), "backscatter") for row in rows]

    (row,) = [row for row in forms.means("held out") if row.case.number == ASLANT]
    case, ways = row.case, (forms.effective, straight)
    one, other = (common.percent(off([row], form)[0]) for form in ways)
    halves = ("fit", "held out")
    thin = {use: [off(forms.means(use), form) for form in ways] for use in halves}
    thick = {use: [common.percent(common.farthest(off(forms.means(use, thin=False), form))) for form in ways] for use in halves}
    told = "; ".join(
        f"{use}, {within(ours, 0.05)} within 5 % and the largest {common.percent(common.farthest(ours))} ({within(plain, 0.05)}, {common.percent(common.farthest(plain))})"
        for use, (ours, plain) in thin.items()
    )
    far = " and ".join(f"{ours} ({use}; {plain})" for use, (ours, plain) in thick.items())
    return f"""\
**Light that comes aslant.** What turned on its way meets the phase function at angles about the one between the straight
ways; where the function is hollow there, more comes back (`uwopt/model/sent_back.py`). In case {case.number} ({case.phase}, albedo {case.albedo:.2f}, c d {case.thickness:.2f}, a lobe of
{case.lobe_half_deg:.0f}° that crosses the image from the side, {abs(case.tilt_deg):.0f}° from the vertical) backscatter is off by {one}, and by {other} with the same constants where
light meets it straight. Image means of backscatter up to c d = 4, and straight in brackets: {told}. The largest from there to
c d = 8: {far}. The last of the constants says how much more than one turn would the function is widened."""


def known_together() -> str:
    """By how much image means of backscatter up to c d = 4 differ at most between constants in use and fitted again."""
    rows = forms.means("fit") + forms.means("held out")
    off = [
        model.uwopt_light(row.case, "mean", forms.effective(row.case, forms.fitted()))["backscatter"]
        / model.uwopt_light(row.case, "mean", forms.effective(row.case))["backscatter"] - 1.0
        for row in rows
    ]  # fmt: skip
    return f"{100 * max(map(abs, off)):.1f} %"


def path_text() -> str:
    """How far daylight's path radiance is off, held-out image means up to c d = 4."""
    held = [row for row in daylight.read() if row.case.use == "held out" and row.place == "mean" and row.case.thickness <= THIN]
    return f"{100 * max(abs(sunlit.errors(row, multiple_scattering=True)['path']) for row in held):.0f} %"


def daylight_rows() -> list[list[str]]:
    """Held-out daylight against its marks."""
    rows = []
    for name, many in ((ALL, True), (ONCE, False)):
        for tally, what in (("veil", "forward veil"), ("path", "path radiance")):
            held = [row for row in daylight.read() if row.case.use == "held out"]
            off = {row: sunlit.errors(row, multiple_scattering=many)[tally] for row in held}
            thin = [e for row, e in off.items() if row.place == "mean" and row.case.thickness <= THIN]
            corner = [e for row, e in off.items() if row.place == "corner" and row.case.thickness <= THIN]
            thick = [e for row, e in off.items() if row.place == "mean" and row.case.thickness > THIN]
            rows.append(
                [name, what, common.percent(float(np.median(thin)), 0), within(thin, 0.05), within(thin, 0.10), common.percent(common.farthest(thin), 0), within(corner, 0.15), within(thick, 0.20)]
            )
    return rows


def low_sun_text() -> str:
    """Path radiance under one sun: what the model makes of where it stands, and of where the camera looks."""
    told = [sun for sun in low_sun.all_suns() if sun.error < DOUBT * sun.mean]
    rows = []
    for low, high in low_sun.RINGS:
        mine = [sun for sun in told if low < sun.cosine < high]
        off = [sun.model / sun.mean - 1.0 for sun in mine]
        before, behind = ([sun.model_corner / sun.corner[at] - 1.0 for sun in mine] for at in (0, -1))
        elevation = float(np.rad2deg(np.arccos(min(low_sun.N_WATER * np.sqrt(1.0 - mine[0].cosine ** 2), 1.0))))
        cells = [f"{common.percent(float(np.median(each)), 0)} ({common.percent(min(each), 0)} to {common.percent(max(each), 0)})" for each in (off, before, behind)]
        rows.append([f"{elevation:.0f}°", str(len(mine)), *cells])
    return f"""\
**A low sun.** The same walks, sorted by where they leave the water, tell what one sun sends in place of an even sky: the held-out
waters up to c d = 4, rings of the cosine in water, the model told the walks' K under that sun. Path radiance of the model over that of the walks, median
and extremes, where the walks' own σ is under {100 * DOUBT:g} %: image mean; the corner that looks towards the sun, where its light turns by least; and the one that looks away (of corners, with a quarter of the walks, σ is about twice that of the mean):

{common.table(["sun over the horizon", "waters", "image mean", "corner towards", "corner away"], rows)}

Nothing of it is fitted to one sun. The model takes the mean over azimuth, because a vehicle turns: its path radiance is even about the vertical, that of a low sun over
clear water is not. Towards a low sun it is too low by as much as the table says; K_d of the walks under one sun is known to a few per cent."""


@cache
def walked() -> tuple[detail.Transfer, ...]:
    """Detail through water, by walks and by the model."""
    return tuple(detail.transfer(*case) for case in detail.CASES)


def walked_rows() -> list[list[str]]:
    """F - 1 by the walks, and by the model in brackets."""
    return [
        [one.phase, f"{one.thickness:g}", f"{one.albedo:g}"]
        + [f"{100 * (f - 1):.1f} ± {100 * e:.1f} % ({100 * (m - 1):.1f})" for f, e, m in zip(one.found, one.error, one.model, strict=True)]
        for one in walked()
    ]  # fmt: skip


def worst_walked() -> tuple[float, float]:
    """Largest relative difference of F, and how many standard errors that is."""
    off = [(m / f - 1.0, (m - f) / e) for one in walked() for f, e, m in zip(one.found, one.error, one.model, strict=True)]
    return max(off, key=lambda pair: abs(pair[0]))


def carried_rows() -> list[list[str]]:
    """What nearly forward scattering adds to the image's contrast for each attenuation length of scattering."""
    return [
        [phase, f"{1e3 * pixel:g} mrad", *(f"{100 * (detail.gain(phase, 1.0, nu / pixel) - 1.0):.1f} %" for nu in CYCLES_PER_PX)]
        for phase, pixel in SEEN.items()
    ]  # fmt: skip


#: Measured once, as times are not made again with a page: seconds with all orders, and with single scattering.
COSTS_S = {
    "loose": (0.96, 0.70), "cost-bound": (0.96, 0.70), "power-bound": (2.00, 1.75), "infeasible": (0.44, 0.34),
    "loose, with `resolve_mm`": (0.98, 0.70),
}  # fmt: skip


def cost_text() -> str:
    """Measured times."""
    return ", ".join(f"{name} {many:.2f} s over {once:.2f} s, {many / once:.2f} times" for name, (many, once) in COSTS_S.items())


def figure() -> str:
    """Errors over c d, image means as dots, corners as crosses."""
    drawn, axes = common.canvas(4, height=3.0, width=12.0)
    for axis, tally in zip(axes, SHOWN, strict=True):
        for color, name in zip(("C0", "0.6"), FORMS, strict=True):
            for places, mark, size in ((CORNERS, "x", 3.0), (("mean",), "o", 3.5)):
                seen = errors(name, places)
                off = np.clip([100 * e[tally] for _, e in seen], -100.0, 100.0)
                label = f"{name}, {'corners' if mark == 'x' else 'mean'}"
                axis.plot(  # as a picture: a thousand marks as lines of a file would outweigh the page
                    [row.case.thickness for row, _ in seen], off, mark, color=color, ms=size, label=label, alpha=0.8, rasterized=True
                )
        axis.axvline(THIN, color="0.5", lw=0.8)
        axis.set(xscale="log", xlabel="c d", title=tally, ylim=(-105, 105))
    axes[0].set_ylabel("model over Monte Carlo − 1 [%]")
    axes[-1].legend(fontsize=6)
    return common.save(drawn, "multiple", "Model against light of all orders, by thickness of the water")


def checked(name: str, found: Sequence[checks.Check]) -> list[str]:
    """A row of the table of checks."""
    worst = max(found, key=lambda check: abs(check.sigma))
    off = worst.found / worst.known - 1.0
    return [name, str(len(found)), common.percent(off, 2), f"{worst.sigma:+.1f}"]


def check_text() -> str:
    """How far the Monte Carlo is trusted."""
    slab, numbers = checks.hulst()
    by_photons, by_walks = checks.heavy_tail()
    rows = [
        checked("plane albedo of an isotropic half-space, Chandrasekhar's H function", checks.half_spaces()),
        checked("slab of van de Hulst (c d 2, albedo 0.9, g 0.75), reflected and transmitted", numbers),
        checked("backscatter of one order, uwopt's quadrature with c on both legs", checks.single_scattering()),
        checked("signal, veil, backscatter by photons from the lamp", [check for check, _ in checks.two_estimators()]),
        checked("backscatter with 25° or 45° in place of 35°, see below", checks.turns()),
    ]  # fmt: skip
    balance = slab.reflected + slab.transmitted + slab.absorbed - 1.0
    return f"""\
**The Monte Carlo** (`docs/validation/orders/`, compiled by numba). Walks begin at the camera; where they meet the floor, or
turn back, they ask for the lamp's light of all orders at that place, and get it from a walk from the lamp that is turned
about the lamp until it ends there. So every angle of the forward peak is drawn from the phase function and none is
evaluated, and no estimate has a heavy tail: of the forward veil in a sea's phase function the largest of 32 batches is
{by_walks:.2f} times the mean, with photons from the lamp and their next events {by_photons:.1f} times.
Backscatter is counted at the last turn of more than {checks.camera.TURN_DEG:g}°; what comes back without one is left out.

{common.table(["checked against", "numbers", "largest difference", "in σ"], rows)}

Reflected, transmitted and absorbed light of the slab add up to 1 {common.percent(balance, 3)}."""


def section() -> str:
    """The text."""
    rows, used, fitted = cases.read(), forms.USED, forms.fitted()
    means = [row for row in rows if row.place == "mean"]
    doubt = {tally: float(np.median([row.error[tally] / row.value[tally] for row in means])) for tally in TALLIES}
    thin = [row for row in means if row.case.thickness <= THIN]
    most = {tally: max(row.error[tally] / row.value[tally] for row in thin) for tally in TALLIES}
    near = [float(np.median([row.within[key] for row in means])) for key in cases.WITHIN]
    marks = {tally: judged(ALL, ("mean",), tally, thin=True) for tally in SHOWN}
    today = judged(ONCE, ("mean",), "contrast", thin=True)
    constants = ", ".join(f"{mine:.3g} ({afresh:.3g})" for mine, afresh in zip(used, fitted, strict=True))
    by_sun = ", ".join(f"{mine:.3g} ({afresh:.3g})" for mine, afresh in zip(sunlit.USED, sunlit.fitted(), strict=True))
    return f"""\
**In short:** {len(means)} cases of c d 0.2 to 8; of the held-out image means up to c d = 4, {within(marks['signal'], 0.05)} (signal), {within(marks['veil'], 0.05)} (forward veil), {within(marks['backscatter'], 0.05)} (backscatter) and {within(marks['contrast'], 0.05)} (contrast) are within 5 % of all orders of scattering; single scattering makes contrast up to {100 * max(today):.0f} % too good.

Independent of: uwopt's integrals, tables and phase functions; shared is nothing but the cases. Homogeneous grey water, a
level Lambertian floor, one lamp in the camera's plane, a pinhole: c d {BANDS[0][0]:g} to {BANDS[-1][1]:g}, albedo 0.3 to 0.95,
baseline 0.1 to 3 m at altitudes of 0.5 to 6 m, lobes of 10° to 70° (half angle at half power) aimed into the image from
their place, fields of 30° to 90°, Fournier–Forand functions of b_b/b 0.005 to 0.03, Henyey–Greenstein, three of
Petzold's, floor 0.02 to 0.5. Image mean, centre and the corners near and far from the lamp:
[multiple_scattering.csv](validation/multiple_scattering.csv), made again by `PYTHONPATH=. python docs/make_multiple_scattering.py`.
Standard errors of the means: {', '.join(f'{tally} {100 * doubt[tally]:.1f} % (at most {100 * most[tally]:.1f} % up to c d = 4)' for tally in TALLIES)}.

{check_text()}

**The model.** `all orders` is physics `full`: effective attenuations K = c - b (1 - s), as `uwopt/model/multiple.py` has them,
lobes that scattering widens on the lamps' way (`uwopt/model/widened.py`, below), the phase function as turned light meets it, and
the part of the forward veil that turns by much taken from all of the lit floor, by kernels about the pixel's ray, one for light
that turned once, twice or more often (`uwopt/model/veil/wide.py`). These kernels (powers of the cosine, and the share of a long tail) were chosen
with corners of both halves in view; fitted on the fit half alone are the two angles that stand beside them, so that the corners of the veil are no
blind test. `the lamps' own lobes` leaves the widening out. `single
scattering` is what a scene with `multiple_scattering: false` counts: K between a + b_b and c from K_d (here Kirk's 1984 formula, since
the cases have no K_d) on the lamp's leg and for the forward veil, c on the way of backscatter to the camera. Seven constants,
fitted on every other case up to c d = 4 and rounded (in brackets as fitted again for this page): {constants}; those of the
veils on corners too, those of the lamps' way under the lamps' own lobes. Those of backscatter are known together only: by either set image means are the same within {known_together()}. They hold for lobes of 10° to 70° aimed into or near the image, albedo up to 0.95 and
phase functions like the sea's; beyond c d = 4 errors grow as the next table says. Errors of all image means, median and
extremes:

{common.table(["c d", "cases", "model", *SHOWN], band_rows())}

{figure()}

The held-out half: image means up to c d = 4 within 5 % and 10 % and the largest error, corners up to c d = 4 within 15 %,
means of c d 4 to 8 within 20 %:

{common.table(["model", "", "within 5 %", "within 10 %", "largest", "corners, 15 %", "c d 4 to 8, 20 %"], mark_rows())}

**Corners** of the held-out half up to c d = 4 that are within 15 %, by their image-forming light over the image mean's:

{common.table(["model", "corner over mean", "corners", *SHOWN], corner_rows())}

**Widened lobes.** Where a narrow lobe leaves a corner in the dark its light is light that the water moved sideways on
its way from the lamp, which an attenuation does not. Order l of the
lobe's Legendre series comes with exp(b r chi_l) beside its unscattered light, chi_l the mean of P_l over the phase function up to
90° along the way, as for detail below but on the lamps' side. Light that goes round goes farther, and that costs it exp(-a r e), e how
much longer its way is: without it image means of c d 4 to 8 would change by {without(forms.no_farther, 'signal')} (signal) and {without(forms.no_farther, 'veil')} (veil). What turns back falls on the floor again
from all about, as two streams of even light have it: without it these signals would change by {without(forms.never_again, 'signal')}. Pixels look
about by scattering on their own way, so that backscatter is widened twice. None of it is fitted but what the table of constants says.
For light on the floor r is its distance along the camera's axis; for
backscatter it is the distance from the lamp of each place on the pixel's ray. One lobe stands for all colours, that of b where the lamps'
light gets through: against lobes of each wavelength {', '.join(f"{100 * off:.1f} % at {angle:g}°" for off, angle in zip(colours.off_by_angle(), colours.ANGLES_DEG, strict=True))} from the axis of a lobe
of {colours.LOBE_DEG:g}° in Jerlov's waters up to c d = 4 where they are clearest.

{aslant_text()}

**Daylight.** {len(daylight.drawn_cases())} cases of the same waters under an even sky (all of Snell's cone), half an attenuation length to five over the
camera, walks back from the camera to floor or sky ([daylight.csv](validation/daylight.csv)). `all orders`: the floor's light
comes with K = a + b S({sunlit.USED.veil_deg:g}°); the path's is what the phase function turns of light that comes as it entered the water, and what is scattered backwards, evenly, of
light that was turned before, of which there is K_d / a less 1 of the other; it is lost by absorption alone (`sunlight.diffuse_path_radiance_w_m2_sr_nm`). The model
is told K_d of the walks between port and floor, a sun at 60°, and that what is turned once comes from all of the sky. Constants, fitted and rounded as above: {by_sun}. Held-out half; means up to c d = 4, corners
up to c d = 4, means of c d 4 to 8:

{common.table(["model", "", "median", "within 5 %", "within 10 %", "largest", "corners, 15 %", "c d 4 to 8, 20 %"], daylight_rows())}

{low_sun_text()}

**Near the straight way.** {100 * near[0]:.0f} % of the forward veil (median) arrives within 0.1° of where it belongs, {100 * near[1]:.0f} % within 0.5°,
{100 * near[2]:.0f} % within 2°: it still carries a coarse image. In the mean, in noise and in `contrast` it is a veil; of detail it shows
what Wells' small-angle transfer says, F = exp(b r chi) beside the image-forming light (`uwopt/model/detail.py`), so that bars
arrive with C F MTF of their contrast. Walks back from the camera over a floor that varies as a wave, all orders and all angles,
{detail.N / 1e6:.0f} million each, against that; F - 1 by cycles per radian of the line of sight:

{common.table(["phase function", "c d", "albedo", *(f"{f:g}" for f in detail.CYCLES_PER_RAD)], walked_rows())}

Largest difference of F {common.percent(worst_walked()[0])}, {worst_walked()[1]:+.1f} σ. With the phase function that Wells put into closed form chi is
(1 - e^-x) / x, x = 2 π θ₀ f, within 0.3 % (a test). What F adds for each attenuation length of scattering, by cycles per pixel:

{common.table(["phase function", "pixel", *(f"{nu:g}" for nu in CYCLES_PER_PX)], carried_rows())}

Bars of 10 mm seen from 2 m are 100 cycles per radian. `resolve_mm` takes F at the bars' own frequency; information takes that of half the
Nyquist frequency for all, which is less than coarser detail has: information stays too low, by 2 to 10 % at an SNR of 30 where b r = 1.
Which phase function it is matters more than all of this: at angles under 0.1° none was measured, and there the numbers are
those of formulas and power laws, which differ by factors. Within 0.0035° the model takes it as even, which is prudent.

**What it costs.** The exact search over 10⁹ combinations of `uwopt/bench/scaling.py` (processor time on one shared machine, the
least of three, with light of all orders over single scattering): {cost_text()}.

**What falls short.** {worst_text()}
{corner_text()}

{ways_text()}

A result says when the water is thicker than c d = 4. Daylight's path radiance is within {path_text()}, not 5 %; under a low sun it depends on where the camera looks, which the model does not know."""
