"""What is wanted: the mission, its scenes, and the view a solver has of each scene.

`load_mission` is the door: a file name or a mapping becomes a `Mission`, or one MissionError that names
every fault. Units are those of the keys; converting to SI is the caller's step into the model.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, PrivateAttr, model_validator
from pydantic_core import PydanticCustomError

from uwopt.documents.key_types import CHOICE, NUMBER, WHOLE, Section, Text, all_optional, given_values
from uwopt.documents.reading import Document, read_document
from uwopt.documents.validation import validated
from uwopt.documents.whole_file import WholeFile, with_origin
from uwopt.mission import checks
from uwopt.mission.best_image import NAME, BestImageGoal, to_goal
from uwopt.mission.doubt import Confidence, Doubt
from uwopt.mission.fixed import Fixed
from uwopt.mission.keys import OBJECTIVES
from uwopt.mission.practice import DEFAULT_PRACTICE, Practice, with_practice
from uwopt.mission.reserves import Reserve, ReserveOrWord, depth_factor, held_of, kept_of, with_refusals
from uwopt.mission.sections.catalog_choice import CatalogChoice
from uwopt.mission.sections.limits import Limits
from uwopt.mission.sections.requirements import Requirements
from uwopt.mission.sections.scene import RequirementsOverride, Scene, VehicleOverride
from uwopt.mission.sections.vehicle import Vehicle

PIXELS_PER_CIRCLE = 2.0  # default circle of confusion outside physics `paper`

Physics = Literal["auto", "full", "paper"]


@dataclass(frozen=True)
class SceneView:
    """One scene as a solver sees it: its overrides applied, its share of time known.

    `requirements.circle_of_confusion_px` is filled in; None there means the rule of physics `paper`.
    `requirements` are what designs must meet, the mission's reserve included; `asked` are those without it.
    """

    index: int
    scene: Scene
    vehicle: Vehicle
    requirements: Requirements
    time_share: float
    asked: Requirements

    def kept(self, key: str) -> float:
        """How much of a limit is reserve, in the requirement's unit."""
        return kept_of(self.asked, self.requirements, key)


class Mission(WholeFile):
    """Everything that is wanted of a system."""

    name: Text = Field(default="mission", description="name of the mission")
    objective: Annotated[str | dict[str, float] | BestImageGoal, BeforeValidator(to_goal)] = Field(
        default="power",
        description=f"figure ({', '.join(OBJECTIVES)}), weights such as {{power: 1, cost: 0.01}}, or {NAME}, with "
        "gains {per_w, per_100_usd} where others than 0.01 are wanted",
    )
    physics: Annotated[Physics, CHOICE] = Field(
        default="auto", description="physics of the model: auto, full or paper"
    )
    tolerance: Annotated[float, Field(gt=0, le=0.5), NUMBER] = Field(
        default=0.005, description="error that physics auto may make, a share such as 0.005"
    )
    practice: Annotated[Practice, CHOICE] = Field(
        default=DEFAULT_PRACTICE,
        description="practice that stands in for keys left out: recommended (good practice: light and sharpness over "
        "the whole image, reserves, a lens one stop down, nothing that an expert would refuse) or bare (nothing)",
    )
    confidence: Confidence = Field(
        default="central",
        description="share of the scenarios of what is uncertain in which the hardware must hold, 0.5 to 0.99; "
        "central (every estimate at its likeliest value) or ends (at the worst of its ends)",
    )
    seed: Annotated[int, Field(ge=0, le=2**32 - 1), WHOLE] = Field(
        default=0, description="seed of all random numbers, 0 or above"
    )
    scenes: Annotated[tuple[Scene, ...], Field(min_length=1, max_length=100)] = Field(
        description="scene, or the list of scenes that one system must serve"
    )
    vehicle: Vehicle = Field(description="section vehicle with altitude_m and speed_m_s")
    requirements: Requirements = Field(
        default_factory=lambda: Requirements(), description="section of what the images must be"
    )
    reserve: ReserveOrWord = Field(
        default_factory=lambda: Reserve(),
        description="section of reserves, by how much requirements are to be exceeded, or the word recommended",
    )
    doubt: Doubt = Field(
        default_factory=lambda: Doubt(), description="section of what is uncertain beside the numbers of parts"
    )
    limits: Limits = Field(
        default_factory=lambda: Limits(), description="section of what the system may cost, draw and weigh"
    )
    fixed: Fixed = Field(
        default_factory=lambda: Fixed(),
        description="section of settings that stay as given, the rest being chosen",
    )
    catalog: CatalogChoice = Field(
        default_factory=lambda: CatalogChoice(), description="section of which parts may be used"
    )

    _source_name: str = PrivateAttr(default="mission")
    _stated: frozenset[str] = PrivateAttr(default=frozenset())

    @model_validator(mode="before")
    @classmethod
    def _scenes_in_one_form(cls, data: Any) -> Any:
        if not isinstance(data, Mapping):
            return data
        plain, faults = checks.in_one_form(data)
        if faults:
            raise PydanticCustomError("cross_check", "{what}", {"what": faults[0][1]})
        return with_practice(plain)

    @model_validator(mode="after")
    def _keys_agree(self) -> Self:
        scenes = [
            given_values(scene)
            | {name: given_values(getattr(scene, name)) for name in ("vehicle", "requirements")}
            for scene in self.scenes
        ]
        named = ("vehicle", "requirements", "limits", "catalog")
        given = {name: given_values(getattr(self, name)) for name in named}
        faults = [*checks.missing_waters(scenes), *checks.cross_faults({**given, "scenes": scenes})]
        if faults:
            raise PydanticCustomError("cross_check", "{what}", {"what": faults[0][1]})
        return self

    @property
    def source_file(self) -> dict[str, str] | None:
        """The mission file for a result: name, folder ("" unless it names files), text; None from Python."""
        if self._source_text is None:
            return None
        names_files = self.to_dict() != self.to_dict(absolute_paths=True)
        folder = str(self._base_dir) if names_files and self._base_dir is not None else ""
        return {"name": Path(self._source_name).name, "folder": folder, "text": self._source_text}

    @property
    def asked_depth_m(self) -> float:
        """Depth that ports and lights are asked to be rated for: as limited, else that of the deepest scene."""
        given = self.limits.depth_rating_m
        return max(scene.depth_m for scene in self.scenes) if given is None else given

    @property
    def depth_factor(self) -> float:
        """Depth that ports and lights must be rated for, over the one asked for."""
        overrides = [scene.requirements for scene in self.scenes]
        refused = [self.requirements.refuse if own is None or own.refuse is None else own.refuse for own in overrides]
        return depth_factor(self.reserve.depth, refused, self.limits.depth_rating_m)

    @property
    def required_depth_m(self) -> float:
        """Depth that ports and lights must be rated for, reserve included."""
        return self.asked_depth_m * self.depth_factor

    @property
    def time_shares(self) -> tuple[float, ...]:
        """Share of time of each scene, summing to 1; scenes without one divide the rest equally."""
        return checks.time_shares([scene.time_share for scene in self.scenes])

    @property
    def views(self) -> tuple[SceneView, ...]:
        """All scenes as a solver sees them."""
        return tuple(self.scene_view(i) for i in range(len(self.scenes)))

    def scene_view(self, index: int) -> SceneView:
        """One scene with its overrides of `vehicle` and `requirements` applied and checked again."""
        scene = self.scenes[index]
        vehicle = checks.overridden(given_values(self.vehicle), given_values(scene.vehicle))
        wanted = checks.overridden(given_values(self.requirements), given_values(scene.requirements))
        if self.physics != "paper" and wanted.get("circle_of_confusion_px") is None:
            wanted["circle_of_confusion_px"] = PIXELS_PER_CIRCLE
        carried = Vehicle.model_validate(vehicle)
        asked = with_refusals(Requirements.model_validate(wanted), carried)
        return SceneView(
            index, scene, carried, held_of(asked, self.reserve), self.time_shares[index], asked
        )

    def with_changes(self, **changes: Any) -> "Mission":
        """The same mission with other top-level values, checked: `with_changes(physics="paper")`.

        `practice="recommended"` fills what was left out; what it has filled in stays with `practice="bare"`.
        """
        given = self._as_given(unset="practice" not in changes)
        document = Document(
            self._source_name, {**given, **changes}, base_dir=self._base_dir, text=self._source_text,
            changed=frozenset(changes),
        )  # fmt: skip
        made = with_origin(_checked(document), document).stating(self.stated)
        if not {"vehicle", "practice"} & changes.keys():  # what its file states binds a system, defaults do not
            made.__dict__["vehicle"] = self.vehicle
        return made

    @property
    def stated(self) -> frozenset[str]:
        """What is asked of images and kept in hand by the mission's own words, not by practice: section.key."""
        return self._stated

    def stating(self, stated: Iterable[str]) -> "Mission":
        """This mission, as one whose own words are these."""
        self._stated = frozenset(stated)
        return self

    @property
    def without_gain_cap(self) -> "Mission":
        """The same without the cap of gain that yields where nothing fits below it; itself where it has none."""
        if self.reserve.max_gain_db is None:
            return self
        return self.with_changes(reserve=self.reserve.model_dump(mode="json") | {"max_gain_db": None})

    def to_dict(self, absolute_paths: bool = False) -> dict[str, Any]:
        """Plain values with all defaults filled in; `load_mission` takes them again.

        With `absolute_paths` the files it names are found from any folder.
        """
        data = self._as_given()
        data["requirements"] = self.requirements.model_dump(mode="json", by_alias=True)
        if self.physics != "paper" and self.requirements.circle_of_confusion_px is None:
            data["requirements"]["circle_of_confusion_px"] = PIXELS_PER_CIRCLE
        if absolute_paths:
            checks.make_paths_absolute(data, lambda text: str(self.resolve_path(text).absolute()))
        return data

    def _as_given(self, *, unset: bool = True) -> dict[str, Any]:
        """Plain values; those that nobody has set with them, or not."""
        data = self.model_dump(mode="json", by_alias=True, exclude_unset=not unset)
        for scene, dumped in zip(self.scenes, data["scenes"], strict=True):
            for section in ("vehicle", "requirements"):
                override = getattr(scene, section)
                dumped.pop(section, None)
                if override is not None:
                    dumped[section] = override.model_dump(mode="json", by_alias=True, exclude_unset=True)
        return data


def load_mission(
    source: str | Path | Mapping[str, Any] | Mission, *, base_dir: Path | None = None
) -> Mission:
    """A mission from a YAML file or a mapping; raises one MissionError that lists every fault.

    `base_dir` is where a mapping's files are looked for; a file's are looked for in its own folder.
    """
    if isinstance(source, Mission):
        return source
    document = read_document(source, "mission")
    made = with_origin(_checked(document), document, base_dir)
    own = {name: document.data.get(name) for name in ("requirements", "reserve")}
    return made.stating(
        f"{name}.{key}" for name, keys in own.items() if isinstance(keys, Mapping)
        for key, value in keys.items() if value is not None
    )  # fmt: skip


def mission_sections() -> dict[str, type[Section]]:
    """The sections of a mission file by name; "" is its top level."""
    return {
        "": Mission,
        "vehicle": Vehicle,
        "requirements": Requirements,
        "reserve": Reserve,
        "doubt": Doubt,
        "limits": Limits,
        "fixed": Fixed,
        "catalog": CatalogChoice,
        "scene": Scene,
    }


def _checked(document: Document) -> Mission:
    data, early = checks.in_one_form(document.data)
    return validated(
        Mission,
        document,
        data,
        sections=mission_sections(),
        origin=checks.origins,
        early=[*early, *checks.missing_waters(data.get("scenes"))],
        cross_faults=lambda raw: checks.cross_faults(_valid_parts(raw)),
    )


def _valid_parts(raw: Mapping[str, Any]) -> dict[str, Any]:
    """What of a faulty mission is right on its own, so that its keys can still be held against each other."""
    valid = checks.valid_values
    sections_of: dict[str, type[Section]] = {"vehicle": VehicleOverride, "requirements": RequirementsOverride}
    parts: dict[str, Any] = {name: valid(model, raw.get(name)) for name, model in sections_of.items()}
    parts["limits"] = valid(Limits, raw.get("limits"))
    parts["catalog"] = valid(CatalogChoice, with_practice(raw).get("catalog"))
    scene_model = all_optional(Scene, "SceneParts")
    parts["scenes"] = []
    scenes = raw.get("scenes")
    for scene in scenes if isinstance(scenes, list) else ():
        own = dict(scene) if isinstance(scene, Mapping) else {}
        nested = {name: valid(model, own.pop(name, None)) for name, model in sections_of.items()}
        parts["scenes"].append(valid(scene_model, own) | nested)
    return parts
