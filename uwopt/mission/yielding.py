"""What of good practice gives way where nothing meets all of it: keys that it has filled in, never what a mission says.

Instruments that have worked at sea seldom keep all of it at once: corners of a wide frame get less light by the fourth
power of a cosine, so that an SNR of the whole frame is a few decibels more than the same of its mean. So the frame may
have less than its mean by a few decibels before nothing is asked of it.

The reserve of depth gives way last, and only where none is made for more: instruments are rated to 6000 m and work
there, so that 1.25 times as much asks for what nobody sells.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from uwopt.mission.duration import Duration
from uwopt.mission.mission import Mission
from uwopt.mission.practice import ACCEPTABLE_SNR_DB, LEAST_UNIFORMITY, RECOMMENDED_KEYS, is_wanted
from uwopt.mission.reserves import MADE_FOR_M, RECOMMENDED_RESERVE

WHITE_BALANCE, AIRY = "white_balance", "max_airy_px"
WIDER_AIRY_PX = 4.0  # of a diffraction that leaves bars of two pixels half of their contrast
SEEN_SNR_DB = 14.0  # 5:1, from which on a thing is told from noise (Rose 1948)
FRAME_LESS_DB = (3.0, 6.0, 10.0)  # so much less than its mean may the darkest 5 % of the frame begin with, step by step
SNR_AT, SNR_LESS = "snr_at", "snr_at_less_db"


@dataclass(frozen=True)
class Yield:
    """One key that good practice fills in, and what it is where it gives way."""

    section: str
    key: str
    kept: Any  # by good practice
    instead: Any
    words: str  # what is then held no more
    for_certainty: bool = True  # whether it gives way too where something fits, but not as often as is asked
    chooses_parts: bool = False  # whether it decides which parts there are, so that hardware that fits tells nothing

    @property
    def path(self) -> str:
        """The key with its section."""
        return f"{self.section}.{self.key}"

    @property
    def as_held(self) -> str:
        """The key and what is held instead, which names it among all: `reserve.swath = 0`."""
        if self.key == "refuse":
            return f"{self.path} without {WHITE_BALANCE}"
        return f"{self.path} = {self.instead:g}" if isinstance(self.instead, float) else f"{self.path} = {self.instead}"


def _frame_less(less_db: float) -> Yield:
    words = f"the signal to noise holds in the image's mean, and with {less_db:g} dB less over the frame"
    return Yield("requirements", SNR_LESS, 0.0, less_db, words)


def _reserve(key: str, words: str) -> Yield:
    return Yield("reserve", key, RECOMMENDED_RESERVE[key], 0.0, words)


def _asked(key: str, instead: Any, words: str) -> Yield:
    return Yield("requirements", key, RECOMMENDED_KEYS["requirements"][key], instead, words, for_certainty=False)


#: What gives way first, first: reserves, then colour, then what is asked of the frame's darkest places. Diffraction is
#: held by the contrast of fine bars (`min_mtf_half_nyquist`), too, which stays.
YIELDS: tuple[Yield, ...] = (
    _reserve("swath", "no reserve on swath"),
    _reserve("dof", "no reserve on depth of field"),
    _reserve("blur", "no reserve on motion blur"),
    Yield("requirements", "refuse", WHITE_BALANCE, None, "one colour channel is amplified more than fourfold"),
    *(_frame_less(less_db) for less_db in FRAME_LESS_DB),
    _reserve("snr_db", "no reserve on signal to noise"),
    _reserve("energy", "no reserve on the battery"),
    _asked(SNR_AT, "mean", "the signal to noise holds in the image's mean, not over the frame"),
    _asked("dof_at", "axis", "the depth of field holds on the axis, not in the corners"),
    _asked("lens_stop_down", 0.0, "the lens need not be stopped down"),
    Yield(
        "requirements", "min_uniformity", LEAST_UNIFORMITY, 0.0, "the darkest place of the floor may be dark",
        for_certainty=False,
    ),
    Yield("requirements", AIRY, None, WIDER_AIRY_PX, "the Airy disc is four pixels wide, not two", for_certainty=False),
    Yield(
        "requirements", "min_snr_db", ACCEPTABLE_SNR_DB, SEEN_SNR_DB,
        f"the signal to noise is {SEEN_SNR_DB:g} instead of {ACCEPTABLE_SNR_DB:g} dB", for_certainty=False,
    ),
    Yield(
        "reserve", "depth", RECOMMENDED_RESERVE["depth"], 1.0,
        "no reserve on depth, so that parts work as deep as they are rated for", for_certainty=False,
        chooses_parts=True,
    ),
)


def yields_of(mission: Mission) -> tuple[Yield, ...]:
    """What may give way in a mission, first what does so first: what good practice has filled in, if it is wanted."""
    return tuple(
        one for one in YIELDS
        if is_wanted(mission.practice) and _is_kept(mission, one) and not _of_whom(one) & mission.stated
    )  # fmt: skip


def _of_whom(one: Yield) -> set[str]:
    """The keys by which a mission says itself what else good practice does."""
    more = {SNR_LESS: f"requirements.{SNR_AT}", AIRY: "requirements.refuse"}
    return {one.path, more.get(one.key, one.path)}


def _is_kept(mission: Mission, one: Yield) -> bool:
    section = getattr(mission, one.section)
    if one.key == "refuse":
        return WHITE_BALANCE in section.refuse and section.max_white_balance is None
    if one.key == "depth" and not mission.asked_depth_m <= MADE_FOR_M < mission.required_depth_m:
        return False  # deeper parts are made
    if one.key == "energy" and not Duration.of(mission).energy_reserve_wh:
        return False  # nothing of a battery is kept
    if one.key == SNR_LESS and section.snr_at != RECOMMENDED_KEYS[one.section][SNR_AT]:
        return False
    return bool(getattr(section, one.key) == one.kept)


def with_yields(mission: Mission, given_way: Collection[Yield]) -> Mission:
    """The mission in which these have given way."""
    data = {"requirements": mission.to_dict()["requirements"], "reserve": mission.reserve.model_dump(mode="json")}
    for one in given_way:
        place = data[one.section]
        if one.key == "refuse":
            place[one.key] = [word for word in place[one.key] if word != WHITE_BALANCE]
        else:
            place[one.key] = one.instead
    if data["requirements"][SNR_AT] == "mean":
        data["requirements"][SNR_LESS] = 0.0  # of no pixels
    return mission.with_changes(**data)


def gave_way_between(asked: Mission, held: Mapping[str, Any]) -> tuple[Yield, ...]:
    """What has given way of a mission where these plain values of it are held."""
    return tuple(one for one in yields_of(asked) if _is_instead(one, held.get(one.section) or {}))


def _is_instead(one: Yield, section: Mapping[str, Any]) -> bool:
    if one.key == "refuse":
        return WHITE_BALANCE not in (section.get(one.key) or ())
    return bool(section.get(one.key) == one.instead)


def yields_named(text: str) -> tuple[Yield, ...]:
    """Those that a text names, `as_held` of each, with commas between."""
    named = text.split(", ")
    return tuple(one for one in YIELDS if one.as_held in named)


def with_given_way(mission: Mission, given_way: Collection[Yield]) -> Mission:
    """A mission like the one of which these have given way, in which they do too: but for what it states otherwise."""
    known = yields_of(mission) if given_way else ()
    here = [one for one in given_way if one in known]
    return with_yields(mission, here) if here else mission
