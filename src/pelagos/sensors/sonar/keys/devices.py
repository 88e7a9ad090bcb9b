"""Real sonars by their data sheets, or by tables that cite these, as keys of the sensors' configurations.

`device: oculus_m750d` in a scenario gives a sensor the keys of that device; keys that the scenario names itself win.
What a sheet does not say keeps the sensor's default: no sheet here gives source levels or the receivers' noise.
`assumed` lists keys that are plausible and not from the sheet, or of which it is doubtful what they are of; the source
then says so.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from pydantic import BaseModel

from pelagos.errors import LookupFailed


@dataclass(frozen=True)
class Device:
    """A device: what it is, where its numbers come from, and the keys that it sets."""

    title: str
    source: str
    keys: Mapping[str, Any]
    assumed: tuple[str, ...] = field(default=())


DEVICES: Final[Mapping[str, Mapping[str, Device]]] = {
    "imaging_sonar": {
        "oculus_m750d": Device(
            "Blueprint Subsea Oculus M750d, 750 kHz mode",
            "Blueprint Subsea, Oculus M-Series user manual and data sheet",
            {"frequency_hz": 750e3, "horizontal_aperture_deg": 130.0, "vertical_beamwidth_deg": 20.0, "beams": 512,
             "beamwidth_deg": 1.0, "range_min_m": 0.1, "range_max_m": 120.0, "bandwidth_hz": 187.5e3},
            assumed=("range_min_m",),  # the bandwidth from the sheet's range resolution of 4 mm
        ),
        "oculus_m750d_high": Device(
            "Blueprint Subsea Oculus M750d, 1.2 MHz mode",
            "Blueprint Subsea, Oculus M-Series user manual and data sheet",
            {"frequency_hz": 1.2e6, "horizontal_aperture_deg": 70.0, "vertical_beamwidth_deg": 12.0, "beams": 512,
             "beamwidth_deg": 0.6, "range_min_m": 0.1, "range_max_m": 40.0, "bandwidth_hz": 300e3},
            assumed=("range_min_m",),  # the bandwidth from the sheet's range resolution of 2.5 mm
        ),
        "oculus_m1200d": Device(
            "Blueprint Subsea Oculus M1200d, 1.2 MHz mode",
            "Blueprint Subsea, Oculus M-Series user manual and data sheet",
            {"frequency_hz": 1.2e6, "horizontal_aperture_deg": 130.0, "vertical_beamwidth_deg": 20.0, "beams": 512,
             "beamwidth_deg": 0.6, "range_min_m": 0.1, "range_max_m": 40.0, "bandwidth_hz": 300e3},
            assumed=("range_min_m",),  # the bandwidth from the sheet's range resolution of 2.5 mm
        ),
        "oculus_m1200d_high": Device(
            "Blueprint Subsea Oculus M1200d, 2.1 MHz mode",
            "Blueprint Subsea, Oculus M-Series user manual and data sheet",
            {"frequency_hz": 2.0e6, "horizontal_aperture_deg": 60.0, "vertical_beamwidth_deg": 12.0, "beams": 512,
             "beamwidth_deg": 0.4, "range_min_m": 0.1, "range_max_m": 10.0, "bandwidth_hz": 300e3},
            assumed=("frequency_hz", "range_min_m"),  # 2.1 MHz; the absorption's fit ends at 2; 2.5 mm
        ),
        "oculus_m370s": Device(
            "Blueprint Subsea Oculus M370s",
            "Blueprint Subsea, Oculus M-Series data sheet DA-148-P01443-10, as a public table cites it: 8 mm "
            "of range resolution",
            {"frequency_hz": 375e3, "horizontal_aperture_deg": 130.0, "vertical_beamwidth_deg": 20.0, "beams": 256,
             "beamwidth_deg": 2.0, "range_min_m": 0.2, "range_max_m": 200.0, "bandwidth_hz": 93.75e3, "rate_hz": 2.5},
            assumed=("rate_hz",),  # at which the whole range is unambiguous
        ),
        "oculus_m3000d": Device(
            "Blueprint Subsea Oculus M3000d, 1.2 MHz mode",
            "Blueprint Subsea, Oculus M-Series data sheet DA-148-P01443-10, as a public table cites it: 2.5 mm "
            "of range resolution",
            {"frequency_hz": 1.2e6, "horizontal_aperture_deg": 130.0, "vertical_beamwidth_deg": 20.0, "beams": 512,
             "beamwidth_deg": 0.6, "range_min_m": 0.1, "range_max_m": 30.0, "bandwidth_hz": 300e3},
        ),
        "oculus_m3000d_high": Device(
            "Blueprint Subsea Oculus M3000d, 3.0 MHz mode",
            "Blueprint Subsea, Oculus M-Series data sheet DA-148-P01443-10, as a public table cites it: 2 mm "
            "of range resolution",
            {"frequency_hz": 2.0e6, "horizontal_aperture_deg": 40.0, "vertical_beamwidth_deg": 20.0, "beams": 512,
             "beamwidth_deg": 0.25, "range_min_m": 0.1, "range_max_m": 5.0, "bandwidth_hz": 375e3},
            assumed=("frequency_hz",),  # 3.0 MHz; the absorption's fit ends at 2 MHz
        ),
        "oculus_c550d": Device(
            "Blueprint Subsea Oculus C550d, 550 kHz mode",
            "Blueye Robotics, integration page of the Oculus C550d: 8 mm of range resolution; it gives no beamwidth",
            {"frequency_hz": 550e3, "horizontal_aperture_deg": 120.0, "vertical_beamwidth_deg": 20.0, "beams": 256,
             "range_min_m": 0.2, "range_max_m": 100.0, "bandwidth_hz": 93.75e3},
        ),
        "oculus_c550d_high": Device(
            "Blueprint Subsea Oculus C550d, 820 kHz mode",
            "Blueye Robotics, integration page of the Oculus C550d: 5 mm of range resolution; it gives no beamwidth",
            {"frequency_hz": 820e3, "horizontal_aperture_deg": 90.0, "vertical_beamwidth_deg": 20.0, "beams": 256,
             "range_min_m": 0.2, "range_max_m": 30.0, "bandwidth_hz": 150e3},
        ),
        "blueview_m900": Device(
            "Teledyne BlueView M900 Mk2",
            "Teledyne Marine, BlueView M900 Mk2 leaflet PLD20590-3, as a public table cites it: 13 mm "
            "of range resolution",
            {"frequency_hz": 900e3, "horizontal_aperture_deg": 130.0, "vertical_beamwidth_deg": 12.0, "beams": 768,
             "range_min_m": 0.5, "range_max_m": 100.0, "bandwidth_hz": 57.7e3},
            assumed=("range_min_m",),
        ),
        "blueview_p900": Device(
            "Teledyne BlueView P900-130",
            "W.-S. Choi et al., Frontiers in Robotics and AI 8, 706646 (2021): bandwidth of the P900, an inch of range "
            "resolution; Silveira et al., Aracati 2017 data set: ranges and sector of the P900-130",
            {"frequency_hz": 900e3, "horizontal_aperture_deg": 130.0, "vertical_beamwidth_deg": 20.0, "beams": 768,
             "range_min_m": 0.4, "range_max_m": 100.0, "bandwidth_hz": 29.5e3},
            assumed=("vertical_beamwidth_deg", "beams"),  # 10 to 20 deg in different places
        ),
        "gemini_1200ik": Device(
            "Tritech Gemini 1200ik, 720 kHz mode",
            "K. Xie et al., Scientific Data 9, 739 (2022), doi 10.1038/s41597-022-01854-w: 512 beams",
            {"frequency_hz": 720e3, "horizontal_aperture_deg": 120.0, "vertical_beamwidth_deg": 20.0, "beams": 512,
             "beamwidth_deg": 1.0, "range_min_m": 0.1, "range_max_m": 120.0, "bandwidth_hz": 187.5e3},
            assumed=("horizontal_aperture_deg", "vertical_beamwidth_deg", "beamwidth_deg", "range_min_m", "range_max_m",
                     "bandwidth_hz"),  # of the 720is, whose resolution is 4 mm
        ),
        "gemini_1200ik_high": Device(
            "Tritech Gemini 1200ik, 1.2 MHz mode",
            "K. Xie et al., Scientific Data 9, 739 (2022), doi 10.1038/s41597-022-01854-w: 1024 beams",
            {"frequency_hz": 1.2e6, "horizontal_aperture_deg": 120.0, "vertical_beamwidth_deg": 12.0, "beams": 1024,
             "beamwidth_deg": 0.6, "range_min_m": 0.1, "range_max_m": 50.0, "bandwidth_hz": 300e3},
            assumed=("horizontal_aperture_deg", "vertical_beamwidth_deg", "beamwidth_deg", "range_min_m", "range_max_m",
                     "bandwidth_hz"),
        ),
        "kongsberg_m3": Device(
            "Kongsberg Mesotech M3, imaging mode",
            "Kongsberg Mesotech, M3 Sonar; doubtful: its figures are recalled, no sheet was found to hold them to",
            {"frequency_hz": 500e3, "horizontal_aperture_deg": 120.0, "vertical_beamwidth_deg": 30.0, "beams": 256,
             "beamwidth_deg": 1.6, "range_min_m": 0.2, "range_max_m": 150.0, "bandwidth_hz": 75e3, "rate_hz": 4.0},
            assumed=("frequency_hz", "horizontal_aperture_deg", "vertical_beamwidth_deg", "beams", "beamwidth_deg",
                     "range_min_m", "range_max_m", "bandwidth_hz", "rate_hz"),
        ),
        "gemini_720is": Device(
            "Tritech Gemini 720is",
            "Tritech International, Gemini 720is product manual 0703-SOM-00002, Section 2.1",
            {"frequency_hz": 720e3, "horizontal_aperture_deg": 120.0, "vertical_beamwidth_deg": 20.0, "beams": 512,
             "beamwidth_deg": 1.0, "range_min_m": 0.2, "range_max_m": 120.0, "bandwidth_hz": 90e3},
            assumed=("bandwidth_hz",),  # from the range resolution of 8 mm
        ),
    },
    "singlebeam": {
        "ping2": Device(
            "Blue Robotics Ping2",
            "Blue Robotics, Ping Sonar Technical Guide: 115 kHz, 25 deg, 100 m",
            {"frequency_hz": 115e3, "beamwidth_deg": 25.0, "range_min_m": 0.3, "range_max_m": 100.0, "pulse": "cw",
             "pulse_s": 0.2e-3},
            assumed=("range_min_m", "pulse", "pulse_s"),
        ),
    },
    "profiling_sonar": {
        "imagenex_837": Device(
            "Imagenex 837 Delta T",
            "Imagenex Technology Corp., Model 837 Delta T data sheet",
            {"frequency_hz": 260e3, "horizontal_aperture_deg": 120.0, "vertical_beamwidth_deg": 3.0, "beams": 240,
             "beamwidth_deg": 1.5, "range_min_m": 0.5, "range_max_m": 100.0, "bandwidth_hz": 7e3},
            assumed=("beamwidth_deg", "bandwidth_hz"),
        ),
    },
    "mechanical_scanning_sonar": {
        "ping360": Device(
            "Blue Robotics Ping360",
            "Blue Robotics, Ping360 Scanning Imaging Sonar, technical details",
            {"frequency_hz": 750e3, "beamwidth_deg": 2.0, "vertical_beamwidth_deg": 25.0, "range_min_m": 0.75,
             "range_max_m": 50.0, "step_deg": 0.9, "sector_deg": 360.0, "bins": 1200},
        ),
        "imagenex_881l": Device(
            "Imagenex 881L, 675 kHz",
            "Imagenex Technology Corp., Model 881L data sheet 445-039 (2006, revised 2017)",
            {"frequency_hz": 675e3, "beamwidth_deg": 1.8, "vertical_beamwidth_deg": 20.0, "range_min_m": 0.15,
             "range_max_m": 50.0, "step_deg": 1.2},
            assumed=("range_max_m", "step_deg"),  # full scale up to 200 m
        ),
    },
    "multibeam": {
        "r2sonic_2024": Device(
            "R2Sonic 2024, 400 kHz",
            "R2Sonic LLC, Sonic 2024/2022 Operation Manual 96000001, Section 1.1: 200 to 400 kHz, 10 to 160 deg, 256 "
            "beams; its head commands: ranges of 2 to 500 m",
            {"frequency_hz": 400e3, "swath_deg": 120.0, "beams": 256, "beamwidth_across_deg": 0.5,
             "beamwidth_along_deg": 1.0, "range_min_m": 2.0, "range_max_m": 500.0, "bandwidth_hz": 60e3,
             "pulse_s": 0.1e-3, "rate_hz": 1.0},
            assumed=("swath_deg", "beamwidth_across_deg", "beamwidth_along_deg", "bandwidth_hz", "pulse_s", "rate_hz"),
        ),
        "norbit_wbms": Device(
            "NORBIT WBMS, 400 kHz",
            "NORBIT Subsea, WBMS bathymetry data sheet; user manual, Section 5.1 (bandwidth, sweep)",
            {"frequency_hz": 400e3, "swath_deg": 150.0, "beams": 256, "beamwidth_across_deg": 0.9,
             "beamwidth_along_deg": 1.9, "range_min_m": 0.2, "range_max_m": 275.0, "bandwidth_hz": 80e3,
             "pulse_s": 0.5e-3, "rate_hz": 2.5},
            assumed=("rate_hz",),  # at which the whole range is unambiguous
        ),
        "kongsberg_em2040": Device(
            "Kongsberg EM 2040, 300 kHz, 1 x 1 deg",
            "Kongsberg Maritime, EM 2040 brochure: 0.5 x 1 and 1 x 1 deg at the standard 300 kHz, 200 to 400 kHz; the "
            "number of beams from its product description",
            {"frequency_hz": 300e3, "swath_deg": 140.0, "beams": 400, "beamwidth_across_deg": 1.0,
             "beamwidth_along_deg": 1.0, "range_min_m": 0.5, "range_max_m": 520.0, "bandwidth_hz": 40e3,
             "rate_hz": 1.0},
            assumed=("range_min_m", "range_max_m", "bandwidth_hz", "rate_hz"),
        ),
        "kongsberg_em712": Device(
            "Kongsberg EM 712, 70 kHz",
            "Kongsberg Maritime, EM 712: 40 to 100 kHz, 140 deg, from 3 m below the transducers on; doubtful: "
            "recalled, no sheet was found to hold these to",
            {"frequency_hz": 70e3, "swath_deg": 140.0, "beams": 400, "beamwidth_across_deg": 1.0,
             "beamwidth_along_deg": 1.0, "range_min_m": 3.0, "range_max_m": 3000.0, "bandwidth_hz": 3e3,
             "pulse_s": 2e-3, "rate_hz": 0.2},
            assumed=("frequency_hz", "swath_deg", "beams", "beamwidth_across_deg", "beamwidth_along_deg", "range_min_m",
                     "range_max_m", "bandwidth_hz", "pulse_s", "rate_hz"),
        ),
        "seabat_7160": Device(
            "Teledyne RESON SeaBat 7160, 44 kHz class",
            "NERC Vocabulary Server, SDN:L22::TOOL1110; doubtful: its frequency is printed as 440 kHz",
            {"frequency_hz": 44e3, "swath_deg": 150.0, "spacing": "equidistant", "beams": 512,
             "beamwidth_across_deg": 2.0, "beamwidth_along_deg": 1.5, "range_min_m": 3.0, "range_max_m": 3000.0,
             "bandwidth_hz": 3e3, "pulse_s": 5e-3, "source_level_db": 225.0, "rate_hz": 0.2},
            # the page prints 440 kHz, at which water takes some 100 dB from a kilometre: not with its depths of 3000 m
            assumed=("frequency_hz", "swath_deg", "bandwidth_hz", "pulse_s", "source_level_db", "rate_hz"),
        ),
    },
    "sidescan": {
        "edgetech_2205": Device(
            "EdgeTech 2205, 540 kHz of 230/540/850 kHz",
            "EdgeTech, 2205 System Technical and User's Guide 0022175, Section 9: the frequencies",
            {"frequency_hz": 540e3, "beamwidth_deg": 0.26, "vertical_beamwidth_deg": 50.0, "depression_deg": 20.0,
             "range_max_m": 80.0, "bandwidth_hz": 60e3},
            assumed=("beamwidth_deg", "vertical_beamwidth_deg", "depression_deg", "range_max_m", "bandwidth_hz"),
        ),
        "edgetech_4125": Device(
            "EdgeTech 4125, 400 kHz",
            "EdgeTech, 4125 side scan sonar data sheet",
            {"frequency_hz": 400e3, "beamwidth_deg": 0.46, "vertical_beamwidth_deg": 50.0, "depression_deg": 20.0,
             "range_max_m": 80.0, "bandwidth_hz": 33e3},
            assumed=("range_max_m", "bandwidth_hz"),  # 150 m at most
        ),
        "klein_4000": Device(
            "Klein 4000, 400 kHz of 100/400 kHz",
            "Klein Marine Systems, System 4000; doubtful: beams and ranges are recalled, no sheet was found for them",
            {"frequency_hz": 400e3, "beamwidth_deg": 0.3, "vertical_beamwidth_deg": 50.0, "depression_deg": 25.0,
             "range_max_m": 80.0, "bandwidth_hz": 30e3},
            assumed=("beamwidth_deg", "vertical_beamwidth_deg", "depression_deg", "range_max_m", "bandwidth_hz"),
        ),
        "klein_uuv3500": Device(
            "Klein UUV-3500, 455 kHz",
            "Klein Marine Systems, UUV-3500 data sheet; doubtful: whether 0.34 deg is of 455 or of 900 kHz",
            {"frequency_hz": 455e3, "beamwidth_deg": 0.34, "vertical_beamwidth_deg": 45.0, "depression_deg": 25.0,
             "range_max_m": 80.0, "bandwidth_hz": 30e3},
            assumed=("beamwidth_deg", "vertical_beamwidth_deg", "depression_deg", "range_max_m", "bandwidth_hz"),
        ),
        "starfish_450f": Device(
            "Blueprint Subsea StarFish 450F",
            "Blueprint Subsea, StarFish 450F data sheet",
            {"frequency_hz": 450e3, "beamwidth_deg": 1.7, "vertical_beamwidth_deg": 60.0, "depression_deg": 30.0,
             "range_max_m": 80.0, "bandwidth_hz": 40e3},
            assumed=("range_max_m", "bandwidth_hz"),  # 100 m at most
        ),
    },
    "dvl": {
        "waterlinked_a125": Device(
            "Water Linked DVL A125",
            "Water Linked AS, DVL A125 data sheet; documentation, range modes: from 0.05 m, 2 to 4 readings a second "
            "at long range",
            {"frequency_hz": 420e3, "beam_tilt_deg": 22.5, "range_min_m": 0.05, "range_max_m": 125.0, "rate_hz": 4.0,
             "noise_mps": 0.004, "noise_relative": 0.0101},
            assumed=("noise_mps", "noise_relative"),  # as of the A50
        ),
        "nortek_dvl500": Device(
            "Nortek DVL500",
            "Nortek AS, DVL500-300m data sheet, as a public table cites it: 8 mm/s a ping at 1.5 m/s; doubtful: its "
            "nearest range (0.1 to 0.3 m)",
            {"frequency_hz": 500e3, "beam_tilt_deg": 25.0, "range_min_m": 0.3, "range_max_m": 200.0, "rate_hz": 2.5,
             "noise_mps": 0.008, "noise_relative": 0.001},
            assumed=("range_min_m", "rate_hz", "noise_relative"),  # up to 8 Hz; the long-term accuracy for noise
        ),
        "sonardyne_syrinx": Device(
            "Sonardyne Syrinx, 600 kHz",
            "Sonardyne, Syrinx DVL: 600 kHz, four beams at 30 deg, from 0.4 m on",
            {"frequency_hz": 600e3, "beam_tilt_deg": 30.0, "range_min_m": 0.4, "range_max_m": 175.0, "rate_hz": 2.5,
             "noise_mps": 0.003, "noise_relative": 0.002},
            assumed=("range_max_m", "rate_hz", "noise_mps", "noise_relative"),
        ),
        "pathfinder_600": Device(
            "Teledyne RD Instruments Pathfinder, 600 kHz",
            "Teledyne RD Instruments, Pathfinder DVL data sheet and guide (2018); Table 40: ranges in cm downwards",
            {"frequency_hz": 614e3, "beam_tilt_deg": 30.0, "range_min_m": 0.15, "range_max_m": 89.0,
             "noise_mps": 0.004, "noise_relative": 0.0115, "range_resolution_m": 0.01 / 0.75**0.5},  # cos 30 deg
            assumed=("noise_mps", "noise_relative"),  # the sheet's long-term accuracy of 1.15 % taken for noise
        ),
        "nortek_dvl1000": Device(
            "Nortek DVL1000",
            "Nortek AS, DVL1000 data sheet and manual (2017)",
            {"frequency_hz": 1.0e6, "beam_tilt_deg": 25.0, "range_min_m": 0.2, "range_max_m": 75.0, "rate_hz": 8.0,
             "noise_mps": 0.003, "noise_relative": 0.001},
            assumed=("noise_mps", "noise_relative"),  # the sheet's long-term accuracy of 0.1 % taken for noise
        ),
        "waterlinked_a50": Device(
            "Water Linked DVL A50",
            "Water Linked AS, DVL A50 documentation",
            {"frequency_hz": 1.0e6, "beam_tilt_deg": 22.5, "range_min_m": 0.05, "range_max_m": 50.0,
             "noise_mps": 0.004, "noise_relative": 0.0101},
            assumed=("noise_mps", "noise_relative"),  # the sheet's long-term accuracy of 1.01 % taken for noise
        ),
    },
}  # fmt: skip


def device(kind: str, name: str) -> Device:
    """The device `name` of the sensor type `kind`.

    Raises:
        LookupFailed: there is none; the message lists those there are.
    """
    known = DEVICES.get(kind, {})
    if name not in known:
        raise LookupFailed(f"{kind} device", name, known)
    return known[name]


def device_keys(config: BaseModel) -> Mapping[str, Any]:
    """Keys that a configuration has of its device; none where it names no device, or its type has none."""
    if "device" not in type(config).model_fields:
        return {}
    named: Any = config
    return {} if named.device is None else device(named.type, named.device).keys


def with_device(values: Any, kind: str) -> Any:
    """Keys of a configuration with those of its `device` under them."""
    if not isinstance(values, dict) or not isinstance(values.get("device"), str):
        return values
    try:
        found = device(kind, values["device"])
    except LookupFailed as problem:
        raise ValueError(str(problem)) from problem
    keys = dict(found.keys)
    if values.get("pulse") == "cw" and "bandwidth_hz" not in values:
        keys.pop("bandwidth_hz", None)  # a tone burst has its own
    return {**keys, **values}
