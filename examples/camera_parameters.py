"""A sheet of what each of the camera's parameters does: pairs of small pictures that differ in one of them.

    python examples/camera_parameters.py [camera_parameters.jpg]

takes about three minutes on two cores. The names above are those of HoloOcean's camera, below them ours.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from camera_gallery import LAGOON, Picture, sea
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

import pelagos as pl

SIZE = (156, 104)  # [px]
COLUMNS = 3
GARDEN, DUSK, NIGHT, RISING, SINKING = "garden", "dusk", "night", "rising", "sinking"
FIXED = {"exposure": "manual", "shutter_s": 5e-4}
FILM = {"tone": "film"}
LONG = {"exposure": "manual", "shutter_s": 0.08, "iso": 1, "aperture": 2.8, "samples": 64}
WIDE = {"sensor_width_mm": 60, "samples": 256, "focus_distance_m": 0.4, "exposure": "manual", "shutter_s": 1e-2,
        "iso": 200, "aperture": 1.4, "horizontal_fov_deg": 50,
        "lamps": [
            {"position_m": (0.5, y, 0.5), "orientation_deg": (0, 6, -25 * y), "flux_lm": 9000.0, "beam_angle_deg": 70.0}
            for y in (-1.2, 1.2)
        ]}  # fmt: skip


@dataclass(frozen=True)
class Pair:
    """Two pictures.

    Attributes:
        name: HoloOcean's, of the parameter.
        motif: where they are taken.
        before, after: the keys that differ.
        both: the keys that they share.
    """

    name: str
    motif: str
    before: dict[str, Any]
    after: dict[str, Any]
    both: dict[str, Any] = field(default_factory=dict)


PAIRS = (
    Pair("CaptureWidth, CaptureHeight", GARDEN, {"width_px": 39, "height_px": 26}, {"width_px": 156, "height_px": 104}),
    Pair("FovAngle", GARDEN, {"horizontal_fov_deg": 45}, {"horizontal_fov_deg": 110}),
    Pair("TargetGamma", GARDEN, {"gamma": 1.4}, {"gamma": 3.0}, {"tone": "gamma"}),
    Pair("ExposureMethod", DUSK, {"metering": "average"}, {"metering": "centre"}),
    Pair("ExposureCompensation", GARDEN, {"compensation_ev": -1.5}, {"compensation_ev": 1.5}),
    Pair("ShutterSpeed", GARDEN, {"shutter_s": 2.5e-4}, {"shutter_s": 1e-3}, {"exposure": "manual"}),
    Pair("ISO", GARDEN, {"iso": 100}, {"iso": 1600}, {"exposure": "manual", "shutter_s": 2.5e-4, "aperture": 8,
                                                       "full_well_e": 3000}),
    Pair("Aperture", GARDEN, {"aperture": 5.6}, {"aperture": 2.8}, FIXED),
    Pair("FocalDistance", GARDEN, {"focus_distance_m": 1.3}, {"focus_distance_m": 8.0},
         {"aperture": 1.4, "sensor_width_mm": 250, "samples": 64}),
    Pair("DepthBlurAmount", GARDEN, {"depth_blur_distance_m": 30.0}, {"depth_blur_distance_m": 3.0},
         {"depth_blur_px": 40, "samples": 32}),
    Pair("DepthBlurRadius", GARDEN, {"depth_blur_px": 1}, {"depth_blur_px": 40},
         {"depth_blur_distance_m": 3.0, "samples": 32}),
    Pair("BladeCount", NIGHT, {"aperture_blades": 0}, {"aperture_blades": 5}, WIDE),
    Pair("DepthOfFieldMinFstop", NIGHT, {"aperture_widest": 1.4}, {"aperture_widest": 0.7},
         {**WIDE, "aperture_blades": 5}),
    Pair("FilmSlope", GARDEN, {"film_slope": 0.6}, {"film_slope": 1.2}, FILM),
    Pair("FilmToe", GARDEN, {"film_toe": 0.1}, {"film_toe": 0.9}, FILM),
    Pair("FilmShoulder", GARDEN, {"film_shoulder": 0.05}, {"film_shoulder": 0.8}, {**FILM, "compensation_ev": 1.5}),
    Pair("FilmBlackClip", GARDEN, {"film_black_clip": 0.0}, {"film_black_clip": 0.3}, {**FILM, "compensation_ev": -1}),
    Pair("FilmWhiteClip", GARDEN, {"film_white_clip": 0.0}, {"film_white_clip": 0.5}, {**FILM, "compensation_ev": 2}),
    Pair("ExposureMinBrightness", GARDEN, {"meter_min_cd_m2": 0}, {"meter_min_cd_m2": 12000}),
    Pair("ExposureMaxBrightness", GARDEN, {"meter_max_cd_m2": 30000}, {"meter_max_cd_m2": 300}),
    Pair("ExposureSpeedUp", RISING, {"exposure_speed_up_ev_per_s": 20}, {"exposure_speed_up_ev_per_s": 0.7}),
    Pair("ExposureSpeedDown", SINKING, {"exposure_speed_down_ev_per_s": 20}, {"exposure_speed_down_ev_per_s": 0.5}),
    Pair("MotionBlurIntensity", GARDEN, {"motion_blur": 0}, {"motion_blur": 1}, LONG),
    Pair("MotionBlurMaxDistortion", GARDEN, {"motion_blur_max": 0.02}, {"motion_blur_max": 1.0},
         {**LONG, "motion_blur": 1}),
    Pair("MotionBlurMinObjectScreenSize", GARDEN, {"motion_blur_min_object": 0.3}, {"motion_blur_min_object": 0.0},
         {**LONG, "motion_blur": 1}),
    Pair("LensFlareIntensity", DUSK, {"lens_flare": 0}, {"lens_flare": 12}),
    Pair("BloomIntensity", DUSK, {"bloom": 0}, {"bloom": 8}),
    Pair("WhiteTemp", GARDEN, {"white_temperature_k": 4000}, {"white_temperature_k": 12000}),
    Pair("WhiteTint", GARDEN, {"white_tint": -0.6}, {"white_tint": 0.6}),
    Pair("ChromAberrIntensity", DUSK, {"chromatic_aberration": 0}, {"chromatic_aberration": 0.05}),
    Pair("ChromAberrOffset", DUSK, {"chromatic_aberration_start": 0.0}, {"chromatic_aberration_start": 0.7},
         {"chromatic_aberration": 0.05}),
    Pair("MaxViewDistanceOverride", GARDEN, {"max_range_m": 60}, {"max_range_m": 3}),
)  # fmt: skip


def scenario(motif: str) -> dict[str, Any]:
    """World, water and where the camera is; the body's x axis is the way it moves."""
    if motif == DUSK:
        start = {"position_m": (-9, -4, 1.2), "heading_deg": -24}
        return {"world": LAGOON, "ocean": sea("IA", 9, 336, height_m=0.1), "agents": {"eye": {"start": start}}}
    if motif == GARDEN:
        start = {"position_m": (-5, -3, -1.5), "heading_deg": -110, "speed_mps": 3.0}  # to the left of the picture
        other = {"vehicle": "remus100", "start": {"position_m": (-3.2, -2.6, -1.5), "heading_deg": 80, "speed_mps": 8}}
        return {"world": LAGOON, "ocean": sea("IA", 60, 200, height_m=0.12),
                "agents": {"eye": {"start": start}, "other": other}}  # fmt: skip
    if motif == NIGHT:
        balls = [
            {"shape": "sphere", "at_m": [3.2 + 0.3 * (k % 3), 1.1 - 0.37 * k, -5.6 - 0.55 * (k * k % 3)],
             "size_m": [0.07, 0.07, 0.07], "material": "white", "label": "buoy", "name": "bead"} for k in range(7)
        ]  # fmt: skip
        beads = {"type": "built", "depth_m": 40, "things": balls}
        return {"world": beads, "ocean": sea("I", -20), "agents": {"eye": {"start": {"position_m": (0, 0, -6)}}}}
    up = 1.0 if motif == RISING else -1.0
    start = {"position_m": (0, 0, -4 - 3 * up), "pitch_deg": 89.0 * up, "speed_mps": 3.0}
    world: dict[str, Any] = {"type": "built", "depth_m": 14, "things": [
        {"shape": "cylinder", "at_m": [3, -0.8 + 1.6 * k, -7], "size_m": [0.5, 0.5, 16], "material": "yellow",
         "label": "piling", "name": "pile"} for k in range(2)]}  # fmt: skip
    return {"world": world, "ocean": sea("3C", 50, 200), "agents": {"eye": {"start": start}}}


MOUNT = {GARDEN: (0, 12, -90), DUSK: (0, 4, 0), NIGHT: (0, 0, 0), RISING: (0, 89, 0), SINKING: (0, -89, 0)}
"""Roll, pitch, yaw of the cameras on the body [deg]."""


def pictures(motif: str, pairs: list[Pair]) -> list[tuple[Picture, Picture]]:
    """All pictures of a motif: one simulation with a camera for each."""
    sensors: dict[str, Any] = {}
    for k, pair in enumerate(pairs):
        for side, keys in (("before", pair.before), ("after", pair.after)):
            sensors[f"{side}{k}"] = {
                "type": "camera", "rate_hz": 10, "width_px": SIZE[0], "height_px": SIZE[1], "samples": 8,
                "orientation_deg": MOUNT[motif], "horizontal_fov_deg": 80, "motion_blur": 0, **pair.both, **keys,
            }  # fmt: skip
    values = scenario(motif)
    values["agents"]["eye"] |= {"vehicle": "hovering_auv", "sensors": sensors}
    seen = pl.Simulation.load(values).reset()["eye"]
    return [(seen[f"before{k}"].data[0], seen[f"after{k}"].data[0]) for k in range(len(pairs))]


def shown(keys: dict[str, Any]) -> str:
    """Names and values as a scenario has them."""
    return ", ".join(f"{k}: {v}" for k, v in keys.items())


def tile(pair: Pair, before: Picture, after: Picture) -> NDArray[np.uint8]:
    """The two pictures side by side under their names."""
    whole = Image.new("RGB", (2 * SIZE[0] + 12, SIZE[1] + 40), "white")
    for k, picture in enumerate((before, after)):
        whole.paste(Image.fromarray(picture).resize(SIZE, Image.Resampling.NEAREST), (k * (SIZE[0] + 4), 28))
    draw = ImageDraw.Draw(whole)
    draw.text((0, 0), pair.name, fill="black", font=ImageFont.load_default(size=12))
    values = " | ".join(str(v) for v in pair.after.values())
    text = f"{shown(pair.before)} | {values}"
    draw.text((0, 14), text, fill=(70, 70, 70), font=ImageFont.load_default(size=10))
    return np.asarray(whole)


def main() -> None:
    """Draw the sheet."""
    output = Path(sys.argv[1] if len(sys.argv) > 1 else "camera_parameters.jpg")
    made: dict[str, NDArray[np.uint8]] = {}
    for motif in (GARDEN, DUSK, NIGHT, RISING, SINKING):
        pairs = [p for p in PAIRS if p.motif == motif]
        for pair, (before, after) in zip(pairs, pictures(motif, pairs), strict=True):
            made[pair.name] = tile(pair, before, after)
        print(motif, flush=True)
    tiles = [made[p.name] for p in PAIRS]
    tiles += [np.full_like(tiles[0], 255)] * (-len(tiles) % COLUMNS)
    rows = [np.concatenate(tiles[i : i + COLUMNS], axis=1) for i in range(0, len(tiles), COLUMNS)]
    Image.fromarray(np.concatenate(rows)).save(output, quality=82)
    print(f"written: {output}")


if __name__ == "__main__":
    main()
