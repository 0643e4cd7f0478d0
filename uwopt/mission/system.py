"""What is to be evaluated: a system of catalogue or inline parts, and its settings.

`load_system` is the door, as `load_mission` is for missions.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Discriminator, Field, PrivateAttr, Tag, model_validator
from pydantic_core import PydanticCustomError

from uwopt.catalog.catalogue import Catalog
from uwopt.catalog.inline import (
    INLINE_MODELS,
    SYNONYMS,
    InlineCamera,
    InlineHousing,
    InlineLens,
    InlineLight,
    InlinePart,
    InlinePort,
    inline_faults,
)
from uwopt.catalog.parts.light import NO_LAMP
from uwopt.catalog.records import KINDS, OF_A_DESIGN
from uwopt.documents.faults import KeyPath, nearest
from uwopt.documents.key_types import (
    CHOICE,
    NUMBER,
    WHOLE,
    Count,
    NonNegative,
    Positive,
    Section,
    Share,
    Text,
    given_values,
    to_text,
)
from uwopt.documents.reading import read_document
from uwopt.documents.validation import validated
from uwopt.documents.whole_file import WholeFile, with_origin
from uwopt.errors import CatalogError, MissionError
from uwopt.mission.checks import Fault, valid_values
from uwopt.mission.mission import Mission
from uwopt.mission.sections.vehicle import MAX_LIGHTS, LightMount
from uwopt.results.design import FARTHEST_M

PART_KINDS = (*OF_A_DESIGN, "housing")  # the last may be left out
PIECES = ("camera", "lens", "port", "housing")  # what a complete camera stands for
LEVEL_KEYS = ("flux_lm", "dim_frac", "flash_energy_j")

BY_ID, INLINE, NOTHING = "<id>", "<inline>", "<nothing>"  # steps of pydantic's paths that no file holds


def _form_of_part(value: Any) -> str | None:
    if isinstance(value, str):
        return BY_ID
    return INLINE if isinstance(value, (Mapping, InlinePart)) else None


def _discriminator(form: Callable[[Any], str | None]) -> Discriminator:
    return Discriminator(
        form,
        custom_error_type="fault",
        custom_error_message="{what}",
        custom_error_context={
            "what": "is neither an id nor an inline record",
            "mend": "write the id of a catalogue part, or its keys in braces",
        },
    )


_FORM = _discriminator(_form_of_part)
_FORM_OR_NOTHING = _discriminator(lambda value: NOTHING if value is None else _form_of_part(value))
PartId = Annotated[str, BeforeValidator(to_text), Tag(BY_ID)]


class Settings(Section):
    """How the system is set; what is left out takes the default that its description names."""

    f_number: Annotated[float, Field(gt=0.4, le=128), NUMBER] | None = Field(
        default=None, description="f-number; the lens's widest opening unless given"
    )
    exposure_ms: Annotated[float, Field(gt=0, le=600_000), NUMBER] | None = Field(
        default=None,
        description="exposure in milliseconds; the longest that requirements and limits allow unless given",
    )
    pulse_ms: Annotated[float, Field(gt=0, le=600_000), NUMBER] | None = Field(
        default=None,
        description="time that pulsed lights are on, in milliseconds; the exposure unless given; a flash has its own",
    )
    gain: Annotated[float, Field(ge=1, le=1e5), NUMBER] | None = Field(
        default=None,
        description="gain as a ratio, at least 1, which is 0 dB; that of the wanted mean level unless given, else 1",
    )
    flux_lm: NonNegative | None = Field(
        default=None,
        description="nameplate flux of all lights together in lumens; full unless a level is given",
    )
    dim_frac: Share | None = Field(
        default=None, description="light level as a share 0..1 of full, instead of flux_lm"
    )
    flash_energy_j: Positive | None = Field(
        default=None, description="energy of one flash of one lamp in joules, instead of flux_lm"
    )
    frame_rate_hz: Positive | None = Field(
        default=None, description="frame rate in hertz; the least that the requirements need unless given"
    )
    focus_distance_m: Annotated[float, Field(gt=0, le=FARTHEST_M), NUMBER] | None = Field(
        default=None,
        description="focus in water from the port in metres; the nominal altitude unless given, of several scenes "
        "the one that serves all",
    )


class System(WholeFile):
    """Hardware and settings of one system."""

    name: Text = Field(default="system", description="name of the system")
    camera: Annotated[PartId | Annotated[InlineCamera, Tag(INLINE)], _FORM] = Field(
        description="camera: an id of the catalogue, or an inline record"
    )
    lens: Annotated[PartId | Annotated[InlineLens, Tag(INLINE)], _FORM] = Field(
        description="lens: an id of the catalogue, or an inline record"
    )
    port: Annotated[PartId | Annotated[InlinePort, Tag(INLINE)], _FORM] = Field(
        description="port: an id of the catalogue, or an inline record"
    )
    light: Annotated[PartId | Annotated[InlineLight, Tag(INLINE)], _FORM] = Field(
        description="light: an id of the catalogue, or an inline record; no-lamp with light_count 0"
    )
    housing: Annotated[
        PartId | Annotated[InlineHousing, Tag(INLINE)] | Annotated[None, Tag(NOTHING)], _FORM_OR_NOTHING
    ] = Field(
        default=None, description="housing that the port is built into, an id of the catalogue or an inline record"
    )
    spacer_mm: Annotated[float, Field(ge=0, le=100), NUMBER] | None = Field(
        default=None,
        description="length of the spacer rings between lens and camera in millimetres; unless given the least that "
        "the focus needs where the mission allows rings, else none",
    )
    complete: Text | None = Field(
        default=None,
        description="id of a complete camera of the catalogue, instead of camera, lens, port and housing",
    )
    camera_count: Count = Field(default=1, description="number of cameras, each with lens and port")
    light_count: Annotated[int, Field(ge=0, le=MAX_LIGHTS), WHOLE] = Field(
        default=1, description="number of lights, 0 for none; that of light_mounts unless given"
    )
    light_baseline_m: Annotated[float, Field(ge=0, le=20), NUMBER] | None = Field(
        default=None,
        description="distance across track from port to lights in metres; the mission's unless given",
    )
    light_tilt_deg: Annotated[float, Field(gt=-90, lt=90), NUMBER] | None = Field(
        default=None, description="outward tilt of the lights in degrees; the mission's unless given"
    )
    light_mounts: Annotated[tuple[LightMount, ...], Field(max_length=MAX_LIGHTS)] | None = Field(
        default=None, description="place and aim of each light, instead of baseline and tilt"
    )
    orientation: Annotated[Literal["landscape", "portrait"], CHOICE] = Field(
        default="landscape",
        description="side of the image along the motion: landscape its height, portrait its width",
    )
    settings: Settings = Field(default_factory=lambda: Settings(), description="settings in every scene")
    scenes: dict[str, Settings] = Field(
        default_factory=dict, description="settings that differ in a scene, by the scene's name"
    )

    _source_name: str = PrivateAttr(default="system")

    @model_validator(mode="before")
    @classmethod
    def _as_many_lights_as_mounts(cls, data: Any) -> Any:
        return _in_one_form(data) if isinstance(data, Mapping) else data

    @model_validator(mode="after")
    def _keys_agree(self) -> Self:
        parts = {kind: getattr(self, kind) for kind in self.kinds}
        faults = _cross_faults(
            given_values(self)
            | {kind: part if isinstance(part, str) else given_values(part) for kind, part in parts.items()}
            | {"settings": given_values(self.settings)}
            | {"scenes": {name: given_values(own) for name, own in self.scenes.items()}}
        )
        if faults:
            raise PydanticCustomError("cross_check", "{what}", {"what": faults[0][1]})
        return self

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of parts that it names."""
        return tuple(kind for kind in PART_KINDS if getattr(self, kind) is not None)

    def part(self, kind: str) -> str | dict[str, Any]:
        """The id of the camera, lens, port, light or housing, or what its inline record states."""
        part: str | InlinePart = getattr(self, kind)
        return part if isinstance(part, str) else part.model_dump(mode="json", exclude_unset=True)

    def settings_for(self, scene_name: str) -> Settings:
        """Settings of one scene: those of every scene with its own on top."""
        own = given_values(self.scenes.get(scene_name))
        base = given_values(self.settings)
        if any(own.get(key) is not None for key in LEVEL_KEYS):
            base = {key: value for key, value in base.items() if key not in LEVEL_KEYS}
        return Settings.model_validate(base | own)

    def check_scenes(self, mission: Mission) -> None:
        """Raise MissionError when settings are given for a scene that the mission has not."""
        names = [scene.name for scene in mission.scenes]
        faults = [
            f"{self._source_name}: scenes.{name} is no scene of {mission.source_name}; {_hint(name, names)}"
            for name in self.scenes
            if name not in names
        ]
        if faults:
            raise MissionError(faults)

    def to_dict(self, absolute_paths: bool = False) -> dict[str, Any]:
        """Plain values with defaults filled in (inline parts as given); `load_system` takes them again.

        With `absolute_paths` the files that inline parts name are found from any folder.
        """
        data = self.model_dump(mode="json", exclude={*PART_KINDS, "scenes"})
        data |= {kind: self.part(kind) for kind in self.kinds}
        data["scenes"] = {n: s.model_dump(mode="json", exclude_unset=True) for n, s in self.scenes.items()}
        if absolute_paths:
            for part in (data[kind] for kind in self.kinds if isinstance(data[kind], dict)):
                for key, value in part.items():
                    if isinstance(value, str) and value.casefold().endswith(".csv"):
                        part[key] = str(self.resolve_path(value).absolute())
        return data


def load_system(source: str | Path | Mapping[str, Any] | System, catalog: Catalog | None = None) -> System:
    """A system from a YAML file or a mapping; raises one MissionError that lists every fault.

    catalog : in which the parts have to be that it names
    """
    if isinstance(source, System):
        return source
    document = read_document(source, "system")
    made = validated(
        System,
        document,
        _in_one_form(document.data),
        sections=system_sections(),
        origin=_origins,
        cross_faults=lambda raw: _cross_faults(_valid_parts(raw)),
        early=[] if catalog is None else _unknown_parts(document.data, catalog),
    )
    return with_origin(made, document)


def system_sections() -> dict[str, type[Section]]:
    """The sections of a system file by name; "" is its top level."""
    return {"": System, "settings": Settings, **INLINE_MODELS}


def _in_one_form(data: Mapping[str, Any]) -> dict[str, Any]:
    plain = {
        key: value for key, value in data.items() if value is not None or key not in ("settings", "scenes")
    }
    whole = plain.get("complete")
    if isinstance(whole, str) and whole.strip():  # stands for its pieces, which the catalogue has by these ids
        plain = {**{kind: f"{whole.strip()} {kind}" for kind in ("camera", "lens", "port")}, **plain}
    mounts = plain.get("light_mounts")
    if plain.get("light_count") is None and isinstance(mounts, (list, tuple)) and mounts:
        plain["light_count"] = min(len(mounts), MAX_LIGHTS)
    return plain


def _origins(path: KeyPath) -> Iterator[KeyPath]:
    yield path
    if len(path) == 2 and path[0] in PART_KINDS:
        for other, name in SYNONYMS[str(path[0])].items():
            if name == path[1]:
                yield (path[0], other)


def _cross_faults(parts: Mapping[str, Any]) -> list[Fault]:
    faults: list[Fault] = []
    for kind in PART_KINDS:
        if isinstance(parts.get(kind), Mapping):
            faults += [((kind, key), text) for key, text in inline_faults(kind, parts[kind])]
    faults += _level_faults(("settings",), parts.get("settings") or {})
    for name, own in (parts.get("scenes") or {}).items():
        faults += _level_faults(("scenes", name), own)
    if parts.get("complete") is not None:
        for kind in PIECES:
            if parts.get(kind) not in (None, f"{parts['complete']} {kind}"):
                faults.append(((kind,), "and complete are both given; keep one of them"))
    mounts, count = parts.get("light_mounts"), parts.get("light_count")
    if mounts is not None and count is not None and len(mounts) != count:
        text = f"= {count} but light_mounts has {len(mounts)} place(s); give one for each light"
        faults.append((("light_count",), text))
    if mounts is not None:
        for key in ("light_baseline_m", "light_tilt_deg"):
            if parts.get(key) is not None:
                faults.append(((key,), "and light_mounts are both given; keep one of them"))
    return faults


def _unknown_parts(data: Mapping[str, Any], catalog: Catalog) -> list[Fault]:
    """Ids that the catalogue does not have, or of another kind of part."""
    faults: list[Fault] = []
    for kind in KINDS:
        named = data.get(kind)
        if not isinstance(named, str) or not named.strip():
            continue
        if kind == "light" and (data.get("light_count") == 0 or named.strip() == NO_LAMP.id):
            continue
        try:
            catalog.part(named.strip(), kind)
        except CatalogError as fault:
            faults += [((kind,), f"= {text.removeprefix('part ')}") for text in fault.faults]
    return faults


def _level_faults(path: KeyPath, settings: Mapping[str, Any]) -> list[Fault]:
    given = [key for key in LEVEL_KEYS if settings.get(key) is not None]
    if len(given) < 2:
        return []
    return [((*path, given[1]), f"and {given[0]} both set the light level; keep one of them")]


def _valid_parts(raw: Mapping[str, Any]) -> dict[str, Any]:
    parts: dict[str, Any] = {}
    for kind, model in INLINE_MODELS.items():
        parts[kind] = _complete_inline(model, raw.get(kind))
    if isinstance(raw.get("complete"), str):
        parts |= {kind: raw[kind] for kind in PIECES if isinstance(raw.get(kind), str)} | {"complete": raw["complete"]}
    parts["settings"] = valid_values(Settings, raw.get("settings"))
    scenes = raw.get("scenes")
    if isinstance(scenes, Mapping):
        parts["scenes"] = {str(name): valid_values(Settings, own) for name, own in scenes.items()}
    for key in ("light_mounts", "light_count", "light_baseline_m", "light_tilt_deg"):
        whole = {"camera": "x", "lens": "x", "port": "x", "light": "x", key: raw.get(key)}
        parts[key] = valid_values(System, whole).get(key) if raw.get(key) is not None else None
    return parts


def _complete_inline(model: type[InlinePart], raw: Any) -> dict[str, Any] | None:
    """An inline record that is right key by key; None otherwise, so that nothing is told twice."""
    values = valid_values(model, raw)
    return values if isinstance(raw, Mapping) and len(values) == len(raw) else None


def _hint(name: str, known: Iterable[str]) -> str:
    names = list(known)
    near = nearest(name, names)
    return f"did you mean {near!r}?" if near else f"its scenes are {', '.join(map(repr, names))}."
