"""Light that is worked out once an image, and the bounds that few places of it give."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from random_cases import case

from uwopt.deadline import COSTS_S, effort_s
from uwopt.forward.floor_light import even_enough, most_uniformities, uniformity
from uwopt.forward.lamp_light import image_light
from uwopt.forward.pixels import decisive_pixels
from uwopt.forward.remembered import RememberedSunField, once_an_image
from uwopt.forward.sun_light import SunField
from uwopt.model.image_mean import FRAME_MAY_MISS, reached_by_most
from uwopt.model.sensor import light_for_snr

SEEDS = (1, 4, 7)


def test_images_that_are_alike_are_made_once() -> None:
    asked = []

    def view(along: list[float], across: list[float]) -> Any:
        columns = np.array(along), np.array(across)
        made = SimpleNamespace(tan_along=columns[0], tan_across=columns[1])
        made.take = lambda index: view(list(columns[0][index]), list(columns[1][index]))
        return made

    def product(new: Any) -> Any:
        asked.append(len(new.tan_along))
        return new.tan_along * new.tan_across

    known: dict[Any, Any] = {}
    first = once_an_image(known, view([2.0, 3.0, 2.0, 2.0], [5.0, 5.0, 5.0, 7.0]), product)
    assert first.tolist() == [10.0, 15.0, 10.0, 14.0]
    assert once_an_image(known, view([3.0, 11.0], [5.0, 2.0]), product).tolist() == [15.0, 22.0]
    assert asked == [3, 1]


def searches() -> list[Any]:
    made = []
    for seed in SEEDS:
        search = case(seed, over_frame=True).searcher()
        if len(search.prepare()) and not search.problem.paper:
            made.append(search)
    assert len(made) > 1
    return made


def plain_light(search: Any, row: int, lighting: Any, count: int, pixels: Any) -> Any:
    """The same from the model alone."""
    return image_light(
        search.problem, 0, search.imagers.scenes[0].view.take(np.array([row])), search.imagers.camera[[row]],
        port_index=int(search.imagers.port[row]), lit=lighting.of(count), pixels=pixels, means=False,
    )  # fmt: skip


def test_remembered_light_is_the_light() -> None:
    for search in searches():
        search.problem = search.tables.problem
        lighting = search.tables.lightings[0]
        for count in (1, 2, 3):
            light = search.tables.exact(0, lighting, np.array([0]), count=count, pixels="frame", means=False)
            plain = plain_light(search, 0, lighting, count, "frame")
            width = plain.worst_e.shape[2]
            assert light.worst_e[:, :, :width] == pytest.approx(plain.worst_e, rel=1e-6)
            assert light.may_miss == plain.may_miss


@pytest.mark.parametrize("pixels", ["frame", "darkest"])
def test_some_pixels_bound_the_one_that_decides(pixels: Any) -> None:
    tight = []
    for search in searches():
        search.problem = search.tables.problem
        for lighting in search.tables.lightings[:3]:
            for count in (1, 3):
                most_e = search.tables.likely_pixel(0, lighting, np.array([0]), count=count, pixels=pixels)[0]
                light = plain_light(search, 0, lighting, count, pixels)
                there = np.sort(light.worst_e[0, -1])[light.may_miss]
                assert most_e >= there
                tight.append(most_e <= there * (1 + 1e-6))
    assert any(tight)  # the outermost places are the darkest as a rule


@pytest.mark.parametrize("pixels", ["frame", "darkest"])
def test_some_pixels_with_their_veils_ask_for_no_more_light_than_all(pixels: Any) -> None:
    def asked(light: Any) -> float:
        each = light_for_snr(
            12.0, signal_per_light_e=light.worst_e[0, -1], read_noise_e=4.0,
            total_per_light_e=light.worst_e[0, -1] + light.worst_veil_e[0, -1], prnu_frac=0.01,
        )  # fmt: skip
        return float(np.sort(each)[::-1][light.may_miss])

    tight = []
    for search in searches():
        search.problem = search.tables.problem
        for lighting in search.tables.lightings[:3]:
            row = np.array([0])
            few = search.tables.exact(0, lighting, row, count=2, pixels=pixels, means=False, veils="likely")
            every = plain_light(search, 0, lighting, 2, pixels)
            if every.worst_veil_e is not None:
                assert asked(few) <= asked(every) * (1 + 1e-9)
                tight.append(asked(few) >= asked(every) * (1 - 1e-6))
    assert any(tight)


def test_few_places_bound_the_uniformity() -> None:
    close = []
    for search in searches():
        problem, few = search.tables.problem, np.arange(min(3, len(search.imagers)))
        view = search.imagers.scenes[0].view.take(few)
        for lighting in search.tables.lightings[:3]:
            for row in range(len(view.tan_along)):
                hardware: dict[str, Any] = dict(port_index=int(search.imagers.port[row]), lit=lighting.of(1))
                one = view.take(np.array([row]))
                most = most_uniformities(problem, 0, one, **hardware)[0]
                true = uniformity(problem, 0, one, **hardware).min()
                assert most >= true
                close.append(most < 1.01 * true)
    assert any(close)


def test_few_places_refuse_no_even_floor_and_the_whole_of_it_decides() -> None:
    apart = 0
    for search in searches():
        problem, port = search.tables.problem, search.imagers.port[:1]
        view = search.imagers.scenes[0].view.take(np.array([0]))
        for lighting in search.tables.lightings[:3]:
            least = uniformity(problem, 0, view, port_index=int(port[0]), lit=lighting.of(1)).min()

            kept = partial(even_enough, problem, 0, view, port=port, lit=lighting.of(1))
            assert kept(wanted=0.9995 * least, whole=True) and kept(wanted=0.9995 * least, whole=False)
            assert not kept(wanted=1.0005 * least, whole=True)  # few places may tell of it, or not
            apart += int(kept(wanted=1.0005 * least, whole=False)[0])
            assert not kept(wanted=1.5 * least, whole=True)
    assert apart


def test_whole_floors_are_counted_as_work_once_an_image_and_height() -> None:
    search = searches()[0]
    problem, lighting = search.tables.problem, search.tables.lightings[0]
    view, port = search.imagers.scenes[0].view.take(np.array([0])), search.imagers.port[:1]
    heights = len(problem.scenes[0].range_m)
    for wanted, counted in ((1e-9, heights), (1e-9, 0), (0.0, 0)):
        before = effort_s()
        kept = even_enough(problem, 0, view, port=port, lit=lighting.of(1), wanted=wanted)
        assert kept.all() and effort_s() - before == pytest.approx(counted * COSTS_S["floors"])


def test_pixels_that_never_decide_are_left_out() -> None:
    rng = np.random.default_rng(3)
    signal = np.round(rng.uniform(0.0, 1.0, (4, 2, 60)), 1)  # with ties
    veil = np.round(rng.uniform(0.0, 1.0, signal.shape), 1)
    for may_miss in (0, 1, 7):
        kept, over = decisive_pixels(signal, veil, may_miss)
        assert kept.shape == over.shape and kept.shape[2] < 60
        # SNR^2 = s^2 / (s + v + r^2), of which all but k reach the (k + 1)-th least
        for noise in (1e-3, 0.1, 1.0, 10.0):
            every, few = (np.sort(np.square(s) / (s + v + noise)) for s, v in ((signal, veil), (kept, over)))
            assert few[:, :, may_miss] == pytest.approx(every[:, :, may_miss], rel=1e-12)
    same = np.ones((1, 1, 5))
    assert decisive_pixels(same, same, 2)[0].shape[2] == 4  # three of five that are alike, and the easiest
    ever_more = np.arange(1.0, 6.0)[None, None]
    kept, over = decisive_pixels(ever_more, np.square(ever_more), 0)  # any of them may decide, so none is left out
    assert kept.tolist() == [[[1.0, 2.0, 3.0, 4.0, 5.0, 5.0]]] and over.tolist() == [[[1.0, 4.0, 9.0, 16.0, 25.0, 1.0]]]


def sunlit() -> Any:
    """A search of one sunlit scene in physics full."""
    made = case(1)
    scenes = [one | {"sun_lux": 3e4, "depth_m": 5.0} for one in made.mission.to_dict()["scenes"]]
    return replace(made, mission=made.mission.with_changes(scenes=scenes, physics="full")).searcher()


def test_daylight_of_images_of_all_sizes_is_that_of_each_ray() -> None:
    """Polynomials that images of nearly one size share, against the water along each ray for itself."""
    problem = sunlit().problem
    field, scene = SunField(problem, 0, port_index=0, efficiency=0), problem.scenes[0]
    weight = field.electrons(field.at_floor() * scene.reflectance / np.pi)
    for is_dome in (False, True):
        shape = field.shape = field.shape._replace(is_dome=is_dome, outer_radius_m=0.1)
        for widest in (0.11, 0.89, 1.18, 2.3):
            tangent = np.linspace(0.0, widest, 7)
            shared = field.radial_logs(tangent[None], np.zeros((1, 7)))
            for range_m, (floor, _, path) in zip(scene.range_m, shared[:, :, 0], strict=True):
                bent = tangent / np.sqrt(shape.n_water**2 * (1 + tangent**2) - tangent**2)
                water = tangent if shape.is_dome else bent
                reach_m = (range_m + shape.outer_radius_m) if shape.is_dome else range_m
                path_m = reach_m * np.hypot(1.0, water) - (shape.outer_radius_m if shape.is_dome else 0.0)
                alone = (weight * np.exp(-scene.attenuation_per_m * path_m[:, None])).sum(axis=1)
                assert np.exp(floor) == pytest.approx(alone, rel=1e-7)
                sent = field.path_electrons(path_m, 1.0 / np.hypot(1.0, water))
                assert np.exp(path) == pytest.approx(sent, rel=1e-7)


@pytest.mark.parametrize("pixels", [None, "frame", "darkest"])
def test_remembered_sun_is_the_sun(pixels: Any) -> None:
    search = sunlit()
    imagers = search.prepare()
    port, efficiency = int(imagers.port[0]), int(search.problem.cameras.qe_index[imagers.camera[0]])
    alike = np.flatnonzero(imagers.port == port)
    for rows in (alike[:1], np.repeat(alike, 3)):  # of the second the first is known
        view = imagers.scenes[0].view.take(rows)
        view = replace(view, collecting_m2=view.collecting_m2 * np.arange(1.0, 1.0 + len(rows)))
        known, plain = (
            field(search.problem, 0, port_index=port, efficiency=efficiency).light(view, pixels=pixels)
            for field in (RememberedSunField, SunField)
        )
        for name in ("signal_e_s", "forward_e_s", "path_e_s", "worst_e_s", "worst_veil_e_s"):
            if getattr(plain, name) is None:
                assert getattr(known, name) is None and pixels is None
                continue
            assert getattr(known, name) == pytest.approx(getattr(plain, name), rel=1e-6)


def test_few_pixels_of_the_sun_alone_decide_as_all_do() -> None:
    """It dims towards the edges: what all but k of the frame's pixels reach is what all but k of the outermost do."""
    search = sunlit()
    imagers = search.prepare()
    port, efficiency = int(imagers.port[0]), int(search.problem.cameras.qe_index[imagers.camera[0]])
    view = imagers.scenes[0].view.take(np.flatnonzero(imagers.port == port)[:3])
    field = RememberedSunField(search.problem, 0, port_index=port, efficiency=efficiency)
    few, every = (field.light(view, pixels="frame", few=one).worst_e_s for one in (True, False))
    assert few is not None and every is not None and few.shape[2] < 0.2 * every.shape[2]
    least, all_but = (reached_by_most(light, FRAME_MAY_MISS) for light in (few, every))
    assert least == pytest.approx(all_but, rel=1e-9)
