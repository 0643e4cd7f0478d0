"""Draws of what is uncertain: the same for all hardware, seeded, and evenly spread over each distribution.

Every uncertain number has a distribution that is triangular over its low, central and high value. Its draws are a
Latin hypercube: of n states each falls into another n-th of the probability, in an order of the number's own. The
order rests on the seed and the number's name alone: a fact of a part is drawn alike in whatever design it stands.
"""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.arrays import Array
from uwopt.catalog.parts.doubts import doubtful, each_with, taken_as
from uwopt.catalog.records import Part, Port

Places = NDArray[np.int64]
PRIMES = (2, 3, 5)


def triangular(probability: Array, low: float, mode: float, high: float) -> Array:
    """Quantiles of a triangular distribution, as the probabilities, in the unit of its ends.

        F(x) = (x - low)^2 / ((high - low) (mode - low))         below the mode
        F(x) = 1 - (high - x)^2 / ((high - low) (high - mode))   above it

    Kotz and van Dorp 2004, Beyond Beta, eq. 1.6. A range of no width gives its value.
    """
    width = high - low
    if width <= 0.0:
        return np.full(np.shape(probability), mode)
    rising = low + np.sqrt(probability * width * (mode - low))
    falling = high - np.sqrt((1.0 - probability) * width * (high - mode))
    return np.where(probability * width < mode - low, rising, falling)


def shuffled(seed: int, name: str, count: int) -> NDArray[np.int64]:
    """The numbers 0 to count - 1 in an order that the seed and a name settle."""
    return np.random.default_rng([seed, zlib.crc32(name.encode())]).permutation(count)


def probabilities(seed: int, name: str, count: int) -> Array:
    """One probability for each of so many states, each within another n-th of (0, 1)."""
    rng = np.random.default_rng([seed, zlib.crc32(name.encode()), 1])
    return (shuffled(seed, name, count) + rng.random(count)) / count


def even_points(seed: int, count: int) -> Array:
    """Points that fill the unit cube evenly, (count, 4): a Hammersley set, shifted at random as on a torus.

        u_k1 = (k + 1/2) / n,   u_kd = the digits of k in the (d - 1)-th prime base, mirrored at the point

    Hammersley 1960, Ann. N. Y. Acad. Sci. 86:844; the shift: Cranley and Patterson 1976.
    """
    columns = [(np.arange(count) + 0.5) / count, *(mirrored(np.arange(count), base) for base in PRIMES)]
    shift = np.random.default_rng([seed, zlib.crc32(b"water"), 2]).random(len(columns))
    return np.asarray((np.stack(columns, axis=1) + shift) % 1.0)


def mirrored(numbers: NDArray[np.int64], base: int) -> Array:
    """Radical inverse: the digits of whole numbers in a base, mirrored at the point."""
    made, rest, scale = np.zeros(len(numbers)), numbers.copy(), 1.0 / base
    while rest.any():
        rest, digit = np.divmod(rest, base)
        made += scale * digit
        scale /= base
    return made


def drawn_facts(part: Part, seed: int, states: int) -> dict[str, Array]:
    """Draws of every uncertain number of a part, (states,) each."""
    return {
        name: triangular(probabilities(seed, f"{part.id} {name}", states), known.low, known.value, known.high)
        for name, known in doubtful(part)
    }


def drawn_numbers(part: Part, seed: int, states: int, places: Places | None = None) -> dict[str, list[Any]]:
    """The same as the part's fields hold them; `places`: of these states alone."""
    known = dict(doubtful(part))
    return {
        name: [taken_as(name, known[name], value) for value in (values if places is None else values[places]).tolist()]
        for name, values in drawn_facts(part, seed, states).items()
    }


def drawn_parts(part: Any, seed: int, states: int, places: Places | None = None) -> list[Any]:
    """A part as it is in each state, or in these; a port with the housing that it is built into."""
    columns = drawn_numbers(part, seed, states, places)
    if isinstance(part, Port) and part.housing is not None:
        columns["housing"] = drawn_parts(part.housing, seed, states, places)
    return each_with(part, columns, states if places is None else len(places))
