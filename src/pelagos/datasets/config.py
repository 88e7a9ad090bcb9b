"""The configuration of a data set: a scenario, what of it is drawn, poses, formats, splits."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, Self, get_args

from pydantic import Field, ValidationError, field_validator, model_validator

from pelagos.config.document import Document, plain, read_document
from pelagos.config.override import change
from pelagos.config.problem import as_error, coerced, scenario_error
from pelagos.config.strict import Strict, refusal
from pelagos.datasets.distribution import Distribution
from pelagos.errors import ScenarioError

Format = Literal["webdataset", "parquet", "coco", "yolo", "kitti", "mcap"]
FORMATS: tuple[Format, ...] = get_args(Format)
OF_EPISODES = ("minari", "lerobot")
SPLITS = ("train", "val", "test")
Range = tuple[float, float]


class Poses(Strict):
    """Poses of the vehicle, sample by sample."""

    area_m: tuple[tuple[float, float], tuple[float, float]] | None = None
    """Two opposite corners, world x (north) and y (west) [m]; the whole ground where not given."""
    altitude_m: Range = (1.5, 6.0)
    """Lowest and highest altitude above the seabed [m], of poses that face nothing in particular."""
    depth_m: Range | None = None
    """Lowest and highest depth below the mean sea surface [m], instead of an altitude."""
    heading_deg: Range = (0.0, 360.0)
    """Compass headings [deg]."""
    pitch_deg: Range = (-10.0, 10.0)
    """Lowest and highest pitch, nose up positive [deg]."""
    roll_deg: Range = (-5.0, 5.0)
    """Lowest and highest roll [deg]."""
    facing: float = Field(default=0.7, ge=0, le=1)
    """Share of poses from which an object is in view of the camera (of the first sensor where there is no camera)."""
    facing_labels: tuple[str, ...] = ()
    """Labels of the objects to face; every kind of object where not given."""
    distance_m: Range = (2.0, 6.0)
    """Least and greatest distance of the camera to an object that it faces [m]."""
    off_axis_deg: float = Field(default=15.0, ge=0, le=60)
    """An object that is faced is at most this far from the middle of the view, sideways and upwards [deg]."""
    clearance_m: float = Field(default=0.4, ge=0)
    """Radius about the vehicle that is free of everything [m]."""

    @field_validator("altitude_m", "depth_m", "heading_deg", "pitch_deg", "roll_deg", "distance_m")
    @classmethod
    def _rising(cls, value: Range | None) -> Range | None:
        if value is not None and value[0] > value[1]:
            raise refusal(f"a range goes from the lowest to the highest value, not from {value[0]:g} to {value[1]:g}")
        return value

    @model_validator(mode="after")
    def _within(self) -> Self:
        for key, least, most in (("altitude_m", 0, 1e5), ("depth_m", 0, 1.2e4), ("distance_m", 0.05, 1e4)):
            value = getattr(self, key)
            if value is not None and not (least <= value[0] and value[1] <= most):
                raise refusal(f"{key} lies between {least:g} and {most:g}, not {list(value)}")
        for key, most in (("pitch_deg", 90), ("roll_deg", 180), ("heading_deg", 360)):
            if max(abs(a) for a in getattr(self, key)) > most:
                raise refusal(f"{key} lies between -{most} and {most}, not {list(getattr(self, key))}")
        return self


class DatasetConfig(Strict):
    """Configuration of a data set, as data."""

    name: str = Field(default="dataset", min_length=1, max_length=200)
    """A short name."""
    description: str = ""
    """What it is for."""
    licence: str = Field(default="CC-BY-4.0", min_length=1)
    """Licence of the data set, an SPDX identifier; goes onto the data card."""
    seed: int = Field(default=0, ge=0, lt=2**63)
    """Seed of worlds, waters, poses and noise."""
    scenario: str | dict[str, Any]
    """A scenario: a file, relative to this one, or its keys."""
    agent: str = ""
    """Whose sensors; the scenario's only agent where not given."""
    worlds: int = Field(default=10, ge=1, le=10_000_000)
    """How many worlds: each is drawn anew, and lies in one split only."""
    samples_per_world: int = Field(default=100, ge=1, le=10_000_000)
    """Poses in each world."""
    samples_per_shard: int | None = Field(default=None, ge=1)
    """Samples of one file; those of a world together where not given. A shard never mixes worlds."""
    batch: int = Field(default=8, ge=1, le=4096)
    """Poses that are read in one call: more are faster and take more memory."""
    vary: dict[str, Distribution] = Field(default_factory=dict)
    """Keys of the scenario that are drawn for every world, such as `ocean.turbidity`. The world's seed always is."""
    poses: Poses = Poses()
    """Where the vehicle is, sample by sample."""
    sensors: tuple[str, ...] = ()
    """The agent's sensors to read; all where not given."""
    camera: str | None = None
    """The sensor that labels belong to: a camera; the first of the agent's where not given."""
    labels: tuple[Literal["depth", "semantic", "instance"], ...] = ("depth", "semantic", "instance")
    """Pictures that go with the camera's, pixel by pixel: distance along the axis, label, and object."""
    classes: tuple[str, ...] = ()
    """Labels that get boxes and masks, in the order of their class numbers; every label but ground and water where not
    given."""
    least_area_px: int = Field(default=12, ge=1)
    """Objects that fewer pixels show get no box."""
    image_format: Literal["png", "jpeg"] = "png"
    """How colour pictures are written."""
    formats: tuple[Format, ...] = Field(default=("webdataset",), min_length=1)
    """Formats to write."""
    split: dict[Literal["train", "val", "test"], float] = Field(
        default_factory=lambda: {"train": 0.8, "val": 0.1, "test": 0.1}, validate_default=True
    )
    """Shares of the worlds."""

    @field_validator("formats", mode="before")
    @classmethod
    def _of_samples(cls, value: object) -> object:
        for name in value if isinstance(value, list | tuple) else ():
            if name in OF_EPISODES:
                raise refusal(
                    f"{name!r} is a format of episodes with actions: pelagos evaluate TASK --{name}. Samples go into "
                    f"{', '.join(FORMATS)}"
                )
        return value

    @field_validator("split")
    @classmethod
    def _shares(cls, value: dict[str, float]) -> dict[str, float]:
        if not value or min(value.values()) < 0 or abs(sum(value.values()) - 1) > 1e-9:
            raise refusal(f"shares are 0 or more and add up to 1; given {value}")
        return value

    @field_validator("formats", "labels", "sensors", "classes")
    @classmethod
    def _once(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        twice = sorted({v for v in value if value.count(v) > 1})
        if twice:
            raise refusal(f"{', '.join(twice)} is given twice")
        return value

    @model_validator(mode="after")
    def _boxes_need_instances(self) -> Self:
        need = [f for f in self.formats if f in ("coco", "yolo", "kitti")]
        if need and "instance" not in self.labels:
            raise refusal(f"{' and '.join(need)} hold boxes of objects: 'labels' must have 'instance'")
        return self

    @property
    def shard_size(self) -> int:
        """Samples of one shard at most."""
        return min(self.samples_per_shard or self.samples_per_world, self.samples_per_world)


def load_config(source: str | Path | Mapping[str, Any] | DatasetConfig, changes: tuple[str, ...] = ()) -> DatasetConfig:
    """Read and check a configuration; the path of its scenario becomes absolute. Needs no device.

    Args:
        source: a YAML or JSON file, a mapping, or a configuration.
        changes: values to change, "key.path=value".

    Raises:
        ScenarioError: something is wrong; says where, what was given and what is allowed.
    """
    if isinstance(source, DatasetConfig):
        document = Document(source.model_dump(mode="json", exclude_unset=True), {}, Path.cwd())
    elif isinstance(source, Mapping):
        document = Document(plain(source), {}, Path.cwd())
    else:
        document = read_document(Path(source))
    for text in changes:
        document = change(document, text)
    if not isinstance(document.data, Mapping):
        raise ScenarioError("the configuration of a data set is a mapping of keys", where=document.where(()))
    try:
        config = DatasetConfig.model_validate(document.data)
    except ValidationError as error:
        raise scenario_error(error, document, DatasetConfig) from None
    problems = [(document.where(path), text) for path, text in coerced(document.data, config)]
    if problems:
        raise as_error(problems)
    if isinstance(config.scenario, str):
        config = config.model_copy(update={"scenario": str((document.folder / config.scenario).resolve())})
    return config
