"""A dry business campus: three buildings that can be entered, a car park, streets, lawns and what stands about them."""

from __future__ import annotations

from typing import Final

import numpy as np

from pelagos.math.geodesy import GeoOrigin
from pelagos.world import shapes
from pelagos.world.built import BuiltConfig, level
from pelagos.world.mesh import Mesh, join
from pelagos.world.site import Site
from pelagos.world.world import World

_GROUND: Final = 0.05  # [m], the lawns: a little above the sea surface, which they cover
_STREET: Final = 0.10  # [m], top of the asphalt
_WALK: Final = 0.20  # [m], top of the sidewalks
_STOREY: Final = 3.4  # [m], floor to ceiling
_CAR_PAINTS: Final = ("white", "black", "gold", "hull_paint", "yellow")


class CampusConfig(BuiltConfig):
    """The campus, 200 m x 200 m."""

    def build(self) -> World:
        """Build it."""
        site = Site(user_labels=self.labels)
        site.ground(level((200.0, 200.0), -_GROUND), "grass", label="landscape", name="lawn")
        _paved(site)
        for x, y, length, width in ((45.0, 35.0, 36.0, 24.0), (45.0, -35.0, 30.0, 20.0), (-10.0, 60.0, 24.0, 18.0)):
            _building(site, x, y, length, width)
        _car_park(site)
        _street_furniture(site)
        _planting(site)
        return site.world(
            name="campus",
            description="a business campus",
            origin=GeoOrigin(self.latitude_deg or 0.0, self.longitude_deg or 0.0),
        )


def business_campus(seed: int) -> CampusConfig:
    """A dry campus of 200 m x 200 m: three buildings that can be entered, a car park with cars, streets, lawns."""
    del seed
    return CampusConfig(depth_m=None)


def _slab(site: Site, x: tuple[float, float], y: tuple[float, float], top: float, kind: tuple[str, str, str]) -> None:
    """A slab on the ground: between `x` and `y` [m], up to `top` [m]; `kind` is material, label and name."""
    low = _GROUND - 0.05
    mesh = shapes.box((x[1] - x[0], y[1] - y[0], top - low))
    site.add(mesh.moved(((x[0] + x[1]) / 2, (y[0] + y[1]) / 2, (top + low) / 2)), kind[0], label=kind[1], name=kind[2])


def _paved(site: Site) -> None:
    asphalt, walk = ("black", "asphalt", "street"), ("concrete", "sidewalk", "sidewalk")
    _slab(site, (-90.0, 90.0), (-4.0, 4.0), _STREET, asphalt)
    _slab(site, (-90.0, -20.0), (-64.0, -6.0), _STREET, ("black", "asphalt", "car park"))
    _slab(site, (-58.0, -50.0), (-6.0, -4.0), _STREET, asphalt)  # into the car park
    _slab(site, (15.0, 21.0), (-80.0, -4.0), _STREET, asphalt)
    for y in (-5.0, 5.0):
        for x in ((-90.0, -60.0), (-48.0, 13.0), (23.0, 90.0)):
            _slab(site, x, (y - 1.0, y + 1.0), _WALK, walk)
    _slab(site, (43.0, 47.0), (6.0, 22.5), _WALK, walk)
    _slab(site, (43.0, 47.0), (-24.5, -6.0), _WALK, walk)
    _slab(site, (-12.0, -8.0), (6.0, 50.5), _WALK, walk)
    _slab(site, (-80.0, -60.0), (40.0, 60.0), _WALK - 0.05, ("gravel", "ground_path", "court"))


def _building(site: Site, x: float, y: float, length: float, width: float) -> None:
    """A storey with a floor, walls with open windows, a door towards the street, rooms, furniture and a flat roof."""
    floor, top = _WALK, _WALK + _STOREY
    door = -1.0 if y > 0 else 1.0  # the side of the street
    _slab(site, (x - length / 2, x + length / 2), (y - width / 2, y + width / 2), floor, ("wood", "floor", "floor"))
    shell = []
    for side in (-1.0, 1.0):
        gap = 2.4 if side == door else 0.0
        shell += [m.moved((x, y + side * (width / 2 - 0.15), floor)) for m in _front(length, gap)]
        shell += [m.turned(yaw=np.pi / 2).moved((x + side * (length / 2 - 0.15), y, floor)) for m in _front(width, 0.0)]
    instance = site.add(join(shell), "brick", label="building", name="building")
    roof = shapes.box((length + 1.0, width + 1.0, 0.4)).moved((x, y, top + 0.3))
    site.add(roof, "concrete", label="building", name="building", instance=instance)
    ceiling = shapes.box((length - 0.6, width - 0.6, 0.1)).moved((x, y, top + 0.05))
    site.add(ceiling, "white", label="ceiling", name="ceiling")
    inner = [
        shapes.box((0.15, 0.6 * width, _STOREY)).moved(
            (x + s * length / 6, y - door * 0.15 * width, floor + _STOREY / 2)
        )
        for s in (-1, 1)
    ]
    site.add(join(inner), "white", label="wall", name="partition")
    for row in (-1, 0, 1):
        for column in (-1, 1):
            _desk(site, x + row * length / 3, y - door * width / 5 + column * 2.2, floor)
    _table(site, x, y + door * width / 4, floor)
    crate = shapes.box((0.8, 0.8, 0.8)).moved((x + length / 3, y + door * width / 3, floor + 0.4))
    site.add(crate, "wood", label="crate", name="crate")


def _front(length: float, gap: float) -> list[Mesh]:
    """A wall along x about the origin, from z = 0 up: sill, lintel and posts; with a gap for a door in its middle."""
    halves = [(-length / 2, -gap / 2), (gap / 2, length / 2)] if gap > 0 else [(-length / 2, length / 2)]
    made = [shapes.box((length, 0.3, _STOREY - 2.4)).moved((0, 0, (_STOREY + 2.4) / 2))]
    for a, b in halves:
        made.append(shapes.box((b - a, 0.3, 0.9)).moved(((a + b) / 2, 0, 0.45)))
        posts = np.linspace(a + 0.3, b - 0.3, max(2, round((b - a) / 4) + 1))
        made += [shapes.box((0.6, 0.3, 1.5)).moved((float(p), 0, 1.65)) for p in posts]
    return made


def _desk(site: Site, x: float, y: float, floor: float) -> None:
    legs = [shapes.box((0.05, 0.7, 0.72)).moved((s * 0.75, 0, 0.36)) for s in (-1, 1)]
    desk = join([shapes.box((1.6, 0.8, 0.05)).moved((0, 0, 0.745)), *legs])
    site.add(desk.moved((x, y, floor)), "wood", label="desk", name="desk")
    site.add(_chair().moved((x, y - 0.75, floor)), "black", label="chair", name="chair")


def _chair() -> Mesh:
    legs = [shapes.box((0.04, 0.04, 0.45)).moved((sx * 0.2, sy * 0.2, 0.225)) for sx in (-1, 1) for sy in (-1, 1)]
    seat, back = shapes.box((0.46, 0.46, 0.05)).moved((0, 0, 0.46)), shapes.box((0.46, 0.05, 0.5))
    return join([*legs, seat, back.moved((0, -0.21, 0.73))])


def _table(site: Site, x: float, y: float, floor: float) -> None:
    top = shapes.cylinder(0.7, 0.05, sides=32).moved((0, 0, 0.745))
    leg = shapes.cylinder(0.06, 0.72).moved((0, 0, 0.36))
    site.add(join([top, leg]).moved((x, y, floor)), "wood", label="table", name="table")


def _car_park(site: Site) -> None:
    """Rows of cars with places left free, a bus, a lorry, gates, cones and pallets."""
    number = 0
    for y in (-14.0, -30.0, -46.0):
        for k in range(10):
            number += 1
            if number % 4 == 0:
                continue  # a free place
            car, glass = _car()
            at = (-86.0 + 6.0 * k, y, _STREET)
            instance = site.add(car.turned(yaw=np.pi / 2).moved(at), _CAR_PAINTS[number % 5], label="car", name="car")
            site.add(glass.turned(yaw=np.pi / 2).moved(at), "black", label="car", name="car", instance=instance)
    bus = join([shapes.box((11.5, 2.5, 2.7)).moved((0, 0, 1.75)), *_wheels(7.0, 1.1, 0.5)])
    site.add(bus.moved((-40.0, -58.0, _STREET)), "yellow", label="bus", name="bus")
    lorry = [shapes.box((9.0, 2.5, 2.8)).moved((-2.0, 0, 2.4)), shapes.box((2.2, 2.4, 2.6)).moved((4.2, 0, 1.8))]
    lorry += _wheels(9.0, 1.1, 0.5)
    site.add(join(lorry).moved((-70.0, -58.0, _STREET)), "white", label="semi_truck", name="lorry")
    arm = join([shapes.box((0.4, 0.4, 1.1)).moved((-3.6, 0, 0.55)), shapes.box((6.8, 0.08, 0.12)).moved((0.2, 0, 1.0))])
    site.add(arm.moved((-54.0, -7.0, _STREET)), "yellow", label="parking_gate", name="gate")
    for x in np.arange(-34.0, -24.0, 2.0):
        cone = join([shapes.cone(0.16, 0.7).moved((0, 0, 0.37)), shapes.box((0.4, 0.4, 0.04)).moved((0, 0, 0.02))])
        site.add(cone.moved((float(x), -10.0, _STREET)), "yellow", label="cone", name="cone")
    for k in range(3):
        boards = [shapes.box((1.2, 0.12, 0.02)).moved((0, s, 0.13)) for s in np.linspace(-0.34, 0.34, 5)]
        rails = [shapes.box((0.1, 0.8, 0.12)).moved((s, 0, 0.06)) for s in (-0.5, 0, 0.5)]
        site.add(join(boards + rails).moved((-24.0, -56.0 + 1.5 * k, _STREET)), "wood", label="pallet", name="pallet")


def _wheels(base: float, half_track: float, radius: float) -> list[Mesh]:
    wheel = shapes.cylinder(radius, 0.25, sides=20).turned(roll=np.pi / 2)
    return [wheel.moved((sx * base / 2, sy * half_track, radius)) for sx in (-1, 1) for sy in (-1, 1)]


def _car() -> tuple[Mesh, Mesh]:
    """Body with wheels, and its windows, along x, on the ground below the origin."""
    outline = [(-2.2, 0.35), (2.2, 0.35), (2.25, 0.75), (1.2, 0.92), (-2.1, 0.95)]
    body = shapes.extrude(outline, 1.76).turned(roll=np.pi / 2).moved((0, 0.88, 0))
    roof = shapes.extrude([(-1.9, 0.93), (1.15, 0.90), (0.4, 1.42), (-1.3, 1.44)], 1.5)
    return join([body, *_wheels(2.7, 0.8, 0.32)]), roof.turned(roll=np.pi / 2).moved((0, 0.75, 0))


def _street_furniture(site: Site) -> None:
    post = shapes.cylinder(0.07, 6.0).moved((0, 0, 3.0))
    for station in range(-80, 81, 20):
        arm, head = shapes.beam((0, 0, 5.9), (0, -1.4, 6.1), 0.05), shapes.box((0.3, 0.7, 0.12))
        lamp = join([post, arm, head.moved((0, -1.5, 6.1))])
        site.add(lamp.moved((float(station), 5.5, _WALK)), "steel", label="street_lamps", name="street lamp")
    for x in (-30.0, 0.0, 30.0, 60.0):
        feet = [shapes.box((0.08, 0.4, 0.45)).moved((side * 0.7, 0, 0.22)) for side in (-1, 1)]
        back = shapes.box((1.8, 0.06, 0.4)).moved((0, 0.22, 0.75))
        seat = join([shapes.box((1.8, 0.45, 0.06)).moved((0, 0, 0.45)), back, *feet])
        site.add(seat.moved((x, 7.0, _GROUND)), "wood", label="bench", name="bench")
        can = shapes.cylinder(0.3, 0.9).moved((x + 2.0, 7.0, _GROUND + 0.45))
        site.add(can, "steel", label="garbage_can", name="garbage can")
    racks = [shapes.torus(0.4, 0.03).turned(roll=np.pi / 2).moved((0.7 * k, 0, 0.3)) for k in range(6)]
    site.add(join(racks).moved((30.0, 24.0, _GROUND)), "steel", label="bike_rack", name="bike rack")
    for x, y in ((66.0, 35.0), (64.0, -35.0)):
        bin_ = shapes.box((1.8, 1.2, 1.3)).moved((x, y, _GROUND + 0.65))
        site.add(bin_, "rusted_steel", label="dumpster", name="dumpster")
    for x in (-45.0, 35.0):
        hydrant = join([shapes.cylinder(0.12, 0.7).moved((0, 0, 0.35)), shapes.sphere(0.14).moved((0, 0, 0.72))])
        site.add(hydrant.moved((x, -7.0, _GROUND)), "rusted_steel", label="fire_hydrant", name="hydrant")
    for x, y, label in ((13.0, -6.0, "stop_sign"), (70.0, -6.0, "speed_limit_sign"), (-62.0, 6.5, "stop_sign")):
        sides = 8 if label == "stop_sign" else 4
        plate = shapes.cylinder(0.38, 0.04, sides=sides).turned(yaw=np.pi / sides).turned(pitch=np.pi / 2)
        sign = join([shapes.cylinder(0.04, 2.2).moved((0, 0, 1.1)), plate.moved((0, 0, 2.2))])
        site.add(sign.moved((x, y, _GROUND)), "white", label=label, name=label.replace("_", " "))
    for k in range(3):
        umbrella = join([shapes.cylinder(0.03, 2.4).moved((0, 0, 1.2)), shapes.cone(1.4, 0.6).moved((0, 0, 2.3))])
        at = (-74.0 + 5.0 * k, 50.0, _WALK - 0.05)
        site.add(umbrella.moved(at), "white", label="patio_umbrella", name="umbrella")
        _table(site, at[0] + 0.6, at[1], at[2])
    bars = [shapes.beam((-60.0, 40.0 + 2.0 * k, 0.1), (-60.0, 40.0 + 2.0 * k, 1.1), 0.03) for k in range(11)]
    bars += [shapes.beam((-60.0, 40.0, z), (-60.0, 60.0, z), 0.03) for z in (0.6, 1.1)]
    site.add(join(bars), "steel", label="railing", name="railing")
    for x, y in ((-30.0, 20.0), (-55.0, 30.0), (20.0, 45.0)):
        bag = shapes.noisy(shapes.sphere(0.35), 0.2, np.random.default_rng(round(x) % 97), scale=2.0)
        site.add(bag.moved((x, y, _GROUND + 0.3)), "black", label="trash", name="trash")


def _planting(site: Site) -> None:
    """Trees along the edges and bushes by the buildings."""
    rng = np.random.default_rng(54)
    crowns = [shapes.noisy(shapes.sphere(1.0, sides=20, rings=12), 0.25, rng, scale=3.0) for _ in range(4)]
    edge = [(float(x), s * 92.0) for x in range(-90, 91, 15) for s in (-1, 1)]
    edge += [(s * 95.0, float(y)) for y in range(-75, 76, 15) if abs(y) > 5 for s in (-1, 1)]
    for k, (x, y) in enumerate(edge):
        height = 4.5 + 1.5 * float(rng.uniform())
        trunk = shapes.cone(0.22, height, top_radius=0.12).moved((x, y, _GROUND + height / 2))
        instance = site.add(trunk, "wood", label="tree", name="tree")
        crown = crowns[k % 4].scaled((2.2, 2.2, 2.6)).moved((x, y, _GROUND + height + 1.2))
        site.add(crown, "grass", label="tree", name="tree", instance=instance, crease_deg=60)
    for k in range(24):
        x, y = -28.0 + 2.4 * (k % 12), (46.0 if k < 12 else 12.0)
        if abs(x + 10.0) < 3.0:
            continue  # the way to the door
        bush = crowns[k % 4].scaled((0.9, 0.7, 0.6)).moved((x, y, _GROUND + 0.45))
        site.add(bush, "grass", label="bush", name="bush", crease_deg=60)
