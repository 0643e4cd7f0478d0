"""What came of test shots, in words: factors with their intervals, each shot against the fit, what it changes."""

from __future__ import annotations

from collections.abc import Iterator

from uwopt.report.order.answers import again_sentences
from uwopt.report.text import formats, words
from uwopt.report.text.layout import Block, Grid, Line, Text, block, columns, sentence
from uwopt.solvers.calibration.fit import Fitted
from uwopt.solvers.calibration.summary import Calibrated
from uwopt.solvers.explain.solved_again import SolvedAgain
from uwopt.units import counted, format_number

HELD = {"light": "light", "water": "attenuation", "back": "backscatter"}
MOST_ROWS = 60  # of a table of shots


def calibration_blocks(made: Calibrated) -> list[Block]:
    """Factors, shots, what was left out, and what it changes."""
    blocks = [
        block(f"What {counted(len(made.shots), 'shot')} tell of {formats.one_line(made.scene, 60)}",
              [factor_grid(made), *map(sentence, fit_sentences(made))]),
        block("Shots against the fit", [shot_grid(made)]),
    ]  # fmt: skip
    lines: list[Line] = [
        sentence(f"- {formats.one_line(name, 60)}: left out, {why}.", "yellow") for name, why in made.left_out.items()
    ]
    lines += [sentence(f"- {text}.", "yellow") for text in outlier_texts(made)]
    lines += [sentence(f"- {words.capital(text)}.", "yellow") for text in made.notes]
    blocks += [block("To be known", lines)] if lines else []
    if made.before is not None and made.after is not None:
        again = SolvedAgain(before=made.before, after=made.after)
        told = again_sentences(again, lambda was, now: "")
        blocks.append(block("What it changes", [sentence(text) for text in told]))
    return blocks


def factor_grid(made: Calibrated) -> Grid:
    """A row a factor."""
    table = columns(("", "left"), ("as it was", "right"), ("by the shots", "right"), ("95 % interval", "right"))
    for one in made.fit.factors.values():
        name, was, unit = quantity_of(made, one)
        now = format_number(was * one.value, 3) + unit if not one.held else "held"
        ends = ""
        if one.low is not None and one.high is not None:
            ends = f"{format_number(was * one.low, 3)} to {format_number(was * one.high, 3)}{unit}"
        table.add_row(Text(name), Text(format_number(was, 3) + unit), Text(now), Text(ends or "–"))
    return table


def quantity_of(made: Calibrated, one: Fitted) -> tuple[str, float, str]:
    """Name, value before and unit of what a factor is of."""
    if one.name == "water":
        return "attenuation at 530 nm", made.before_per_m, " 1/m"
    if one.name == "back":
        return "backscatter, as a factor", 1.0, ""
    if made.put_to == "floor":
        return "reflectance of the floor", made.reflectance, ""
    return "light of the lamps, as a factor", 1.0, ""


def fit_sentences(made: Calibrated) -> Iterator[str]:
    """How well it fits, what the intervals are, and what is held."""
    fit = made.fit
    yield (
        f"The shots lie {format_number(100.0 * fit.rms_frac, 2)} % about the fit (root mean square), "
        f"{fit.freedom} more of them than factors."
    )
    if any(one.low is not None for one in fit.factors.values()):
        yield (
            "Intervals: 95 %, of least squares in the logarithm, from its Jacobian and the scatter of the residuals "
            "(Student's t); an error that all shots share, such as a wrong f-number, is not in them."
        )
    why: dict[str, list[str]] = {one.held: [] for one in fit.factors.values() if one.held}
    for one in fit.factors.values():
        if one.held:
            why[one.held].append(HELD[one.name])
    for reason, names in why.items():
        yield f"Held as the mission has it, {' and '.join(names)}: {reason}."


def outlier_texts(made: Calibrated) -> Iterator[str]:
    """Shots that do not fit the others."""
    for shot, is_out, off in zip(made.shots, made.fit.outlier, made.fit.residual_frac, strict=True):
        if is_out:
            way = "brighter" if off > 0 else "darker"
            yield (
                f"{formats.one_line(shot.name, 60)}: {format_number(100.0 * abs(off), 2)} % {way} than the others say, "
                "not taken; look at it again"
            )


def shot_grid(made: Calibrated) -> Grid:
    """A row a shot."""
    table = columns(("shot", "left"), ("distance", "right"), ("exposure", "right"), ("gain", "right"),
                    ("above dark", "right"), ("by the fit", "right"), ("off", "right"))  # fmt: skip
    rows = zip(made.shots, made.net_dn, made.fit.predicted_dn, made.fit.residual_frac, made.fit.outlier, strict=True)
    for shot, net, told, off, is_out in list(rows)[:MOST_ROWS]:
        cells = (
            formats.one_line(shot.name, 24), formats.quantity(shot.distance_m, "m"),
            formats.quantity(1e3 * shot.exposure_s, "ms"), format_number(shot.gain, 3), f"{format_number(net, 4)} DN",
            f"{format_number(float(told), 4)} DN", f"{100.0 * off:+.1f} %",
        )  # fmt: skip
        table.add_row(*(Text(cell, "yellow" if is_out else "") for cell in cells))
    if len(made.shots) > MOST_ROWS:
        table.add_row(Text(f"and {len(made.shots) - MOST_ROWS} more"), *(Text("") for _ in range(6)))
    return table
