"""The port: what a flat window or a concentric dome does to rays, brightness and focus.

Three things happen between water and lens. Rays bend (Snell), so a pixel sees another spot of floor;
some light is lost (Fresnel, absorption); and the floor appears nearer than it is, so the lens must
focus on a virtual image. The last is one map for every kind of port: with D = 1/s the lens dioptre
(s the object distance the lens sees in air) and q the distance in water from the port's outer face,

    q = scale / (D - infinity_per_m) - setback_m

which is every Moebius map that sends the dioptre of infinity to q = inf and falls from there on.
Functions marked [sym] also take CasADi scalars.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from uwopt.errors import CatalogError

Numeric = Any  # float, array that broadcasts, or (where marked [sym]) a CasADi scalar

_TINY = 1e-300


# ---------------------------------------------------------------- refractive index


def _sellmeier_1(wavelength_um2: Numeric, strength: float, resonance_um: float) -> Numeric:
    return strength * wavelength_um2 / (wavelength_um2 - resonance_um**2)


def _sellmeier_2(wavelength_um2: Numeric, strength: float, resonance_um2: float) -> Numeric:
    return strength * wavelength_um2 / (wavelength_um2 - resonance_um2)


def _polynomial_3(wavelength_um2: Numeric, strength: float, power: float) -> Numeric:
    return strength * wavelength_um2 ** (power / 2.0)


# Formula: (what n^2 starts from besides c0, one term of the sum).
_FORMULAS: dict[str, tuple[float, Callable[[Numeric, float, float], Numeric]]] = {
    "sellmeier_1": (1.0, _sellmeier_1),
    "sellmeier_2": (1.0, _sellmeier_2),
    "polynomial_3": (0.0, _polynomial_3),
}


def refractive_index_dispersion(
    wavelength_nm: Numeric, *, formula: str, coefficients: Sequence[float]
) -> Numeric:
    """Refractive index of a glass from its dispersion formula.

        sellmeier_1    n^2 = 1 + c0 + sum of c[2i-1] L^2 / (L^2 - c[2i]^2)
        sellmeier_2    n^2 = 1 + c0 + sum of c[2i-1] L^2 / (L^2 - c[2i])
        polynomial_3   n^2 = c0 + sum of c[2i-1] L^c[2i]

    Parameters
    ----------
    wavelength_nm : (...,) [nm]; L is the same in micrometres
    formula : one of the three names
    coefficients : c0 followed by pairs, in the units that L in micrometres demands

    Returns
    -------
    (...,) relative to air. The coefficients' range of validity is the caller's to check.

    References
    ----------
    Formulas 1 to 3 of the refractiveindex.info database. Physics page, section 4.
    """
    if formula not in _FORMULAS:
        raise CatalogError(f"dispersion formula {formula!r} is unknown; use one of {', '.join(_FORMULAS)}.")
    if len(coefficients) % 2 != 1:
        count = len(coefficients)
        raise CatalogError(f"dispersion formula {formula} needs c0 and pairs, an odd count, not {count}.")
    start, term = _FORMULAS[formula]
    wavelength_um2 = (np.asarray(wavelength_nm) * 1e-3) ** 2
    index_squared = start + coefficients[0]
    for first, second in zip(coefficients[1::2], coefficients[2::2], strict=True):
        index_squared = index_squared + term(wavelength_um2, first, second)
    return np.sqrt(index_squared)


# ---------------------------------------------------------------- losses


def fresnel_by_polarisation(
    cos_incidence: Numeric, *, n_from: Numeric, n_to: Numeric
) -> tuple[Numeric, Numeric, Numeric]:
    """Shares of s and p light that pass one face, and the cosine behind it.

        T_s = 4 n1 c1 n2 c2 / (n1 c1 + n2 c2)^2,   T_p = 4 n1 c1 n2 c2 / (n1 c2 + n2 c1)^2

    cos_incidence : (...,) cosine of the angle to the normal, before the face, 0..1; n_from, n_to : broadcast,
    refractive index before and behind. Shares and cosine are 0 at total reflection. Bare, clean, lossless face.
    Born and Wolf, Principles of Optics, section 1.5. Physics page, section 4.
    """
    sin2_behind = (n_from / n_to) ** 2 * (1.0 - cos_incidence**2)
    cos_behind = np.sqrt(np.maximum(1.0 - sin2_behind, 0.0))
    product = 4.0 * n_from * n_to * cos_incidence * cos_behind
    s_sum = n_from * cos_incidence + n_to * cos_behind
    p_sum = n_from * cos_behind + n_to * cos_incidence
    return product / np.maximum(s_sum**2, _TINY), product / np.maximum(p_sum**2, _TINY), cos_behind


def normal_port_transmittance(*, n_water: Numeric, n_glass: Numeric) -> Numeric:
    """Share of light that passes a port head on: a dome everywhere, a flat port on its axis.

        T_port = 4 n_w n_g / (n_w + n_g)^2 * 4 n_g / (n_g + 1)^2                                    [sym]

    Arguments broadcast; light reflected twice between the faces (under 0.02 %) is not counted, nor loss in the glass.
    Physics page, section 4.
    """
    water_face = 4.0 * n_water * n_glass / (n_water + n_glass) ** 2
    air_face = 4.0 * n_glass / (n_glass + 1.0) ** 2
    return water_face * air_face


def flat_port_transmittance(tan_air: Numeric, *, n_water: Numeric, n_glass: Numeric) -> Numeric:
    """Share of unpolarised light that passes the faces of a flat port obliquely.

        T_port = (T_s T_s' + T_p T_p') / 2

    Parameters
    ----------
    tan_air : (...,) tangent of the ray's angle in air
    n_water, n_glass : broadcast

    Returns
    -------
    (...,) 0..1, for unpolarised light from the floor; each polarisation is followed through both faces.

    References
    ----------
    Physics page, section 4.
    """
    cos_air = 1.0 / np.sqrt(1.0 + tan_air**2)
    air_s, air_p, cos_glass = fresnel_by_polarisation(cos_air, n_from=1.0, n_to=n_glass)
    water_s, water_p, _ = fresnel_by_polarisation(cos_glass, n_from=n_glass, n_to=n_water)
    return 0.5 * (air_s * water_s + air_p * water_p)


# ---------------------------------------------------------------- rays


def water_tangent(tan_air: Numeric, *, n: Numeric) -> Numeric:
    """Tangent of a ray's angle behind a plane face, from its tangent in air.

        tan w = tan a / sqrt(n^2 + (n^2 - 1) tan^2 a)                                                [sym]

    Snell's law without arctan; n is the index of the medium relative to air (water or glass), whatever
    parallel plates lie between. Arguments broadcast. Physics page, section 4.
    """
    return tan_air / bend(tan_air**2, n=n)


def bend(tan2_air: Numeric, *, n: Numeric) -> Numeric:
    """Tangent of a ray in air over that behind a plane face, sqrt(n^2 + (n^2 - 1) tan^2 a), by tan^2 a        [sym]."""
    n2 = n**2
    return np.sqrt(n2 + (n2 - 1.0) * tan2_air)


def flat_floor_distance_m(
    tan_air: Numeric,
    *,
    gap_m: Numeric,
    thickness_m: Numeric,
    n_glass: Numeric,
    n_water: Numeric,
    range_m: Numeric,
) -> Numeric:
    """Where a ray through a flat port meets the floor, off the axis.

        x = e tan a + t_g tan g + d tan w                                                            [sym]

    Parameters
    ----------
    tan_air : (...,) tangent of the ray's angle in air
    gap_m : broadcast [m], e, from the lens's entrance pupil to the glass
    thickness_m : broadcast [m], t_g
    n_glass, n_water : broadcast
    range_m : broadcast [m], d, from the outer face to the floor

    Returns
    -------
    (...,) [m]. Exact for parallel plates before a floor that is parallel to them.

    References
    ----------
    Physics page, section 4.
    """
    glass_m = thickness_m * water_tangent(tan_air, n=n_glass)
    water_m = range_m * water_tangent(tan_air, n=n_water)
    return gap_m * tan_air + glass_m + water_m


def _tangent_slope(tan_air: Numeric, *, n: Numeric) -> Numeric:
    """Derivative of `water_tangent` by tan_air: n^2 / (n^2 + (n^2 - 1) tan^2 a)^(3/2)."""
    n2 = n**2
    square = n2 + (n2 - 1.0) * tan_air**2
    return n2 / (square * np.sqrt(square))


def flat_floor_derivative(
    tan_air: Numeric,
    *,
    gap_m: Numeric,
    thickness_m: Numeric,
    n_glass: Numeric,
    n_water: Numeric,
    range_m: Numeric,
) -> Numeric:
    """Radial slope of `flat_floor_distance_m`: metres of floor per unit of tan_air.

        dx / d tan a = e + sum over glass and water of t n^2 / (n^2 + (n^2 - 1) tan^2 a)^(3/2)       [sym]

    Arguments, shapes and validity as there; (...,) [m]. Physics page, section 4.
    """
    glass_m = thickness_m * _tangent_slope(tan_air, n=n_glass)
    water_m = range_m * _tangent_slope(tan_air, n=n_water)
    return gap_m + glass_m + water_m


def dome_floor_distance_m(tan_air: Numeric, *, outer_radius_m: Numeric, range_m: Numeric) -> Numeric:
    """Where a ray meets the floor behind a dome, (d + R) tan a; pupil at the centre, no deviation [sym]."""
    return (range_m + outer_radius_m) * tan_air


# ---------------------------------------------------------------- focus


@dataclass(frozen=True, slots=True)
class FocusMap:
    """Map from lens dioptre D [1/m] to distance q [m] in water: q = scale / (D - infinity) - setback.

    Fields may be arrays that broadcast. scale > 0 and infinity_per_m >= 0, so q falls as D rises.
    """

    scale: Numeric  # dimensionless: water seen per metre of air, near infinity
    infinity_per_m: Numeric  # the dioptre at which the lens sees q = infinity
    setback_m: Numeric  # how far behind the port's outer face the dioptres have their origin


def water_distance_m(dioptre_per_m: Numeric, *, focus_map: FocusMap) -> Numeric:
    """Distance in water that a lens focused at a dioptre sees sharply.

        q = scale / (D - infinity) - setback                                                         [sym]

    Parameters
    ----------
    dioptre_per_m : (...,) [1/m], D = 1/s with s the object distance in air as the lens sees it
    focus_map : fields broadcast

    Returns
    -------
    (...,) [m] from the port's outer face or vertex, >= 0: +inf where D is at or beyond the image of
    infinity, 0 where it lies inside the port, in front of all water.

    References
    ----------
    Physics page, sections 4 and 7 (9).
    """
    excess_per_m = np.maximum(dioptre_per_m - focus_map.infinity_per_m, 0.0)
    with np.errstate(divide="ignore", over="ignore"):
        return np.maximum(focus_map.scale / excess_per_m - focus_map.setback_m, 0.0)


def lens_dioptre_per_m(water_distance_m: Numeric, *, focus_map: FocusMap) -> Numeric:
    """Dioptre at which the lens sees a distance in water; the inverse of `water_distance_m`.

        D = infinity + scale / (q + setback)                                                         [sym]

    (...,) [m] gives (...,) [1/m]; q may be inf; q + setback > 0 is the caller's to keep.
    Physics page, section 4.
    """
    return focus_map.infinity_per_m + focus_map.scale / (water_distance_m + focus_map.setback_m)


def field_dioptre_per_m(water_distance_m: Numeric, *, cos_field: Numeric, focus_map: FocusMap) -> Numeric:
    """Axial dioptre of a flat floor's image at a field angle: a dome's image of a plane is curved.

        1/z = infinity / cos theta + scale / (q + setback),   z = cos theta * q'((d + R) / cos theta)  [sym]

    Parameters
    ----------
    water_distance_m : (...,) [m], of the floor on the axis
    cos_field : broadcast, cosine of the field angle
    focus_map : of `dome_focus_map`; for the maps of flat ports the angle drops out

    Returns
    -------
    (...,) [1/m]; on the axis the same as `lens_dioptre_per_m`.

    References
    ----------
    Physics page, section 4 (curved image).
    """
    return focus_map.infinity_per_m / cos_field + focus_map.scale / (water_distance_m + focus_map.setback_m)


def identity_focus_map() -> FocusMap:
    """Nothing between lens and floor, q = 1/D: the paper's flat port, which counts as a longer lens."""
    return FocusMap(scale=1.0, infinity_per_m=0.0, setback_m=0.0)


def flat_focus_map(*, gap_m: Numeric, thickness_m: Numeric, n_glass: Numeric, n_water: Numeric) -> FocusMap:
    """Focus map of a flat port, from s = e + t_g / n_g + q / n_w.

    Paraxial; e is the gap from the entrance pupil to the glass. Fields broadcast over the arguments.
    Physics page, section 5.
    """
    return FocusMap(
        scale=n_water * 1.0,
        infinity_per_m=0.0,
        setback_m=n_water * (gap_m + thickness_m / n_glass),
    )


def _dome_power_per_m(
    *, outer_radius_m: Numeric, thickness_m: Numeric, n_glass: Numeric, n_water: Numeric
) -> Numeric:
    """Vergence that a concentric dome adds, at its centre: (1/n_g - 1/n_w)/R + (1 - 1/n_g)/(R - t_g)."""
    outer_face = (1.0 / n_glass - 1.0 / n_water) / outer_radius_m
    inner_face = (1.0 - 1.0 / n_glass) / (outer_radius_m - thickness_m)
    return outer_face + inner_face


def dome_focus_map(
    *, outer_radius_m: Numeric, thickness_m: Numeric, n_glass: Numeric, n_water: Numeric
) -> FocusMap:
    """Focus map of a concentric dome with the lens's pupil at its centre.

        1/q' = 1/(n_w (q + R)) + P,   P = (1/n_g - 1/n_w)/R + (1 - 1/n_g)/(R - t_g),   s = q'

    so scale = 1/n_w, infinity = P, setback = R. Paraxial on the axis; R outer radius, t_g < R.
    Fields broadcast over the arguments. Physics page, section 4.
    """
    power_per_m = _dome_power_per_m(
        outer_radius_m=outer_radius_m, thickness_m=thickness_m, n_glass=n_glass, n_water=n_water
    )
    return FocusMap(scale=1.0 / n_water, infinity_per_m=power_per_m, setback_m=outer_radius_m)


def paper_dome_focus_map(
    *, outer_radius_m: Numeric, thickness_m: Numeric, n_glass: Numeric, n_water: Numeric
) -> FocusMap:
    """Focus map of a dome as the paper's tool has it: same virtual image, but s = q' - R from the vertex.

    With k = 1 - P R: scale = 1/(n_w k^2), infinity = P/k, setback = R (1 - 1/(n_w k)).
    Physics page, section 7 (9).
    """
    power_per_m = _dome_power_per_m(
        outer_radius_m=outer_radius_m, thickness_m=thickness_m, n_glass=n_glass, n_water=n_water
    )
    k = 1.0 - power_per_m * outer_radius_m
    return FocusMap(
        scale=1.0 / (n_water * k**2),
        infinity_per_m=power_per_m / k,
        setback_m=outer_radius_m * (1.0 - 1.0 / (n_water * k)),
    )


def dome_virtual_image_distance_m(
    range_m: Numeric, *, outer_radius_m: Numeric, thickness_m: Numeric, n_glass: Numeric, n_water: Numeric
) -> Numeric:
    """Distance of a dome's virtual image of the floor from the outer vertex, q' - R [sym].

    range_m : (...,) [m] from the vertex, may be inf; the rest broadcasts. Returns (...,) [m]. Paraxial.
    Physics page, section 4.
    """
    dome = dome_focus_map(
        outer_radius_m=outer_radius_m, thickness_m=thickness_m, n_glass=n_glass, n_water=n_water
    )
    return 1.0 / lens_dioptre_per_m(range_m, focus_map=dome) - outer_radius_m
