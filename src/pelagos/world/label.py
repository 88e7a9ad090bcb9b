"""Labels of things: the semantic labels 0 .. 255 of HoloOcean, with their colours, and labels of the user's own.

Numbers, names and colours: HoloOcean documentation, "Semantic labels" (BYU FRoSt Lab, MIT licence).
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

from pelagos.errors import CommandError, LookupFailed


@dataclass(frozen=True)
class Label:
    """A class of things.

    Attributes:
        number: 0 .. 255, as semantic sensors report it.
        name: lower case with underscores, as scenarios name it.
        color: (red, green, blue) 0 .. 255, as semantic cameras paint it.
    """

    number: int
    name: str
    color: tuple[int, int, int]


_TABLE: Final = """
0 none 0,0,0; 1 cube 240,29,219; 2 sphere 29,89,240; 3 base_shape 29,240,89; 4 landscape 201,162,54;
5 ground_grass 91,235,52; 6 ground_rock 196,101,6; 7 ground 194,164,159; 8 ground_path 76,117,252;
9 water_plane 66,135,245; 10 boat 128,64,128; 11 yacht 70,70,70; 12 container_boat 102,102,156;
13 concrete 214,138,230; 14 pipe 192,175,201; 15 pipe_cover 164,72,217; 16 vent_cover 245,215,66; 17 rock 153,115,9;
18 seaweed 75,166,5; 19 coral 235,64,52; 20 plane 176,165,146; 21 sub 146,80,176; 22 pier 186,76,2; 23 buoy 237,53,7;
24 trash 107,156,137; 25 grass 91,235,52; 26 asphalt 79,82,77; 27 bench 212,191,125; 28 bike_rack 209,208,203;
29 building 31,240,205; 30 bus 240,220,43; 31 bush 177,247,124; 32 car 224,109,237; 33 ceiling 161,247,233;
34 chair 65,13,255; 35 cone 255,169,10; 36 crate 140,86,0; 37 desk 242,65,224; 38 dumpster 0,138,14;
39 fire_hydrant 255,0,0; 40 floor 2,125,104; 41 garbage_can 0,184,92; 42 pallet 143,129,6; 43 parking_gate 222,164,177;
44 patio_umbrella 195,0,255; 45 railing 242,97,130; 46 semi_truck 124,6,138; 47 sidewalk 232,232,232;
48 speed_limit_sign 222,218,245; 49 stop_sign 250,37,62; 50 street_lamps 255,149,10; 51 table 186,17,169;
52 tree 69,99,46; 53 wall 126,60,250; 54 unlabeled 0,0,0; 255 any 255,255,255
"""

_OWN: Final = """
64 vehicle 255,220,0; 65 piling 120,84,60; 66 ladder 230,230,120; 67 fender 40,40,60; 68 chain 150,150,90;
69 anchor 90,90,120; 70 mine 200,30,30; 71 tyre 60,60,60; 72 barrel 200,120,40; 73 trap 160,160,60;
74 cable 240,200,120; 75 net 120,160,160; 76 jacket 230,170,60; 77 turbine 210,210,230; 78 manifold 240,160,20;
79 dock 90,200,220; 80 fish 140,200,255; 81 sponge 220,140,60; 82 debris 128,128,96; 83 mooring 170,110,70;
84 gate 110,130,160; 85 trash_rack 100,110,120; 86 aircraft 190,190,200; 87 wreck 128,96,128
"""


def _parse(text: str) -> dict[str, Label]:
    rows = [row.split() for row in text.replace("\n", " ").split(";")]
    labels = [Label(int(n), name, tuple(int(c) for c in rgb.split(","))) for n, name, rgb in rows]  # type: ignore[arg-type]
    return {label.name: label for label in labels}


HOLOOCEAN_LABELS: Final[dict[str, Label]] = _parse(_TABLE)
"""HoloOcean's own table by name."""

LABELS: Final[dict[str, Label]] = HOLOOCEAN_LABELS | _parse(_OWN)
"""All labels by name: HoloOcean's 0 .. 54 and 255, Pelagos's 64 .. 87; 128 .. 254 are free for users."""

FIRST_USER_LABEL: Final = 128


def label_number(name: str | int, user: dict[str, int] | None = None) -> int:
    """The number of a label, given by name, number or HoloOcean's spelling ("BaseShape").

    Args:
        name: as above.
        user: further labels of the scenario, name to number.

    Raises:
        CommandError: a number outside 0 .. 255.
        LookupFailed: no such name.
    """
    if isinstance(name, int):
        if not 0 <= name <= 255:
            raise CommandError(f"a label is a number from 0 to 255, not {name}")
        return name
    own = user or {}
    if name in own:
        return own[name]
    plain = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).lower().replace(" ", "_")
    if plain in own:
        return own[plain]
    if plain not in LABELS:
        raise LookupFailed("label", name, [*LABELS, *own])
    return LABELS[plain].number


def label_name(number: int, user: dict[str, int] | None = None) -> str:
    """The name of a label's number; "user_200" for one without a name."""
    for name, known in (user or {}).items():
        if known == number:
            return name
    for label in LABELS.values():
        if label.number == number:
            return label.name
    return f"user_{number}"


def label_color(number: int) -> tuple[int, int, int]:
    """The colour of a label (red, green, blue) 0 .. 255; a fixed mixed colour for a user's own."""
    for label in LABELS.values():
        if label.number == number:
            return label.color
    mixed = number * 2654435761 & 0xFFFFFFFF
    return 64 + (mixed >> 24) % 192, 64 + (mixed >> 16) % 192, 64 + (mixed >> 8) % 192
