"""Shapes out of MJCF stand where MuJoCo puts them."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

from pelagos.world.robots.mjcf import read_mjcf
from pelagos.world.robots.read import read_description

MJCF = """<mujoco>
  <compiler angle="degree" eulerseq="zyx"/>
  <default>
    <geom size="0.5 0.4 0.3" type="box"/>
    <default class="rod"><geom type="cylinder" size="0.1 0.7"/>
      <default class="thin"><geom size="0.05 0.6"/></default></default>
  </default>
  <worldbody>
    <geom name="a" pos="1 2 3" euler="30 40 50"/>
    <geom name="b" class="rod" pos="-1 0 2" axisangle="1 1 0 70"/>
    <frame pos="0 4 0" euler="0 0 90"><geom name="c" class="thin" pos="1 0 0" zaxis="1 2 3"/></frame>
    <body pos="5 0 1" xyaxes="0 1 0 -1 0 0.5" childclass="rod">
      <geom name="d" pos="0.2 0.3 0.4" quat="1 2 3 4"/>
      <body pos="0 0 2" euler="10 20 30">
        <geom name="e" fromto="1 0 0 2 1 1"/>
        <geom name="f" type="ellipsoid" size="1 0.5 0.25" pos="0 -2 0"/>
        <geom name="g" type="capsule" size="0.2" fromto="0 0 0 0 0 -3"/>
      </body>
    </body>
  </worldbody>
</mujoco>"""

# name, half height of rods or None, geom_xpos, geom_xmat: MuJoCo 4.0.0, mj_forward at the initial state
MUJOCO = [
    ('a', None, [1.0, 2.0, 3.0],
     [0.663414, 0.10504, 0.740843, 0.383022, 0.802872, -0.456826, -0.642788, 0.586824, 0.492404]),
    ('b', 0.7, [-1.0, 0.0, 2.0],
     [0.67101, 0.32899, 0.664463, 0.32899, 0.67101, -0.664463, -0.664463, 0.664463, 0.34202]),
    ('c', 0.6, [1.0, 4.0, 0.0],
     [0.960357, -0.079287, 0.267261, 0.267261, 0.534522, -0.801784, -0.079287, 0.841427, 0.534522]),
    ('d', 0.7, [4.910557, 0.2, 1.491935],
     [-0.447214, 0.715542, -0.536656, -0.666667, 0.133333, 0.733333, 0.596285, 0.685728, 0.417399]),
    ('e', 0.866025, [5.535614, 1.5864, 3.112255],
     [0.831525, 0.551163, 0.069176, 0.399885, -0.507503, -0.763238, -0.385561, 0.662314, -0.642404]),
    ('f', None, [7.052963, -0.036057, 1.158978],
     [-0.298905, -0.579268, 0.758357, 0.925417, 0.018028, 0.378522, -0.232938, 0.814938, 0.530675]),
    ('g', 1.5, [4.756892, -0.567783, 1.992842],
     [-0.298905, -0.579268, 0.758357, 0.925417, 0.018028, 0.378522, -0.232938, 0.814938, 0.530675]),
]  # fmt: skip


def test_poses_and_sizes_are_those_of_mujoco(tmp_path):
    """Defaults by class, frames, fixed and moving axes, every way to write a turn; printed to six digits."""
    found = list(read_mjcf(ElementTree.fromstring(MJCF), tmp_path, "visual"))
    assert len(found) == len(MUJOCO)
    for (mesh, (turn, place)), (name, half, position, matrix) in zip(found, MUJOCO, strict=True):
        assert place == pytest.approx(position, abs=2e-6), name
        assert turn.ravel()[2::3] == pytest.approx(matrix[2::3], abs=2e-6), name
        if half is None:
            assert turn.ravel() == pytest.approx(matrix, abs=2e-6), name
        else:
            round_end = 0.2 if name == "g" else 0.0
            assert mesh.bounds[1, 2] == pytest.approx(half + round_end, abs=2e-6), name


FROM_TO = """<mujoco><worldbody><body pos="5 0 1" euler="10 20 30">
  <geom name="h" type="box" size="0.1" fromto="1 0 -0.5 2 1.5 1"/>
  <geom name="i" type="ellipsoid" size="0.3 0.2 0.1" fromto="-1 0.4 0 -2 1 -1.2"/>
  <geom name="j" type="box" size="0.3 0.2 0.7" fromto="-1 0.4 0 -2 1 -1.2"/>
</body></worldbody></mujoco>"""
# geom_size, geom_xpos, geom_xmat: MuJoCo 4.0.0, mj_forward at the initial state
MUJOCO_FROM_TO = [
    ([0.1, 0.1, 1.172604], [5.953817, 1.392343, 1.16314],
     [0.904632, -0.333595, -0.265247, -0.42303, -0.62713, -0.654029, 0.051837, 0.703863, -0.708442]),
    ([0.3, 0.3, 0.83666], [3.245199, -0.141631, 0.975218],
     [0.381509, -0.210473, 0.900085, 0.630969, 0.770895, -0.087178, -0.675522, 0.601184, 0.426905]),
    ([0.3, 0.3, 0.83666], [3.245199, -0.141631, 0.975218],
     [0.381509, -0.210473, 0.900085, 0.630969, 0.770895, -0.087178, -0.675522, 0.601184, 0.426905]),
]  # fmt: skip


def test_boxes_and_ellipsoids_reach_from_end_to_end_as_in_mujoco(tmp_path):
    """Their first size is half the width both ways, the second the way between the ends."""
    found = list(read_mjcf(ElementTree.fromstring(FROM_TO), tmp_path, "visual"))
    assert len(found) == len(MUJOCO_FROM_TO)
    for (mesh, (turn, place)), (size, position, matrix) in zip(found, MUJOCO_FROM_TO, strict=True):
        assert mesh.bounds == pytest.approx(np.array([-1, 1])[:, None] * size, abs=0.003)  # an ellipsoid is of facets
        assert mesh.bounds[1, 2] == pytest.approx(size[2], abs=2e-6)
        assert place == pytest.approx(position, abs=2e-6)
        assert turn.ravel() == pytest.approx(matrix, abs=2e-6)


def test_groups_and_contact_tell_visual_from_collision_shapes(tmp_path):
    (tmp_path / "part.xml").write_text(
        '<mujocoinclude><geom type="box" size="1 1 1" contype="0" conaffinity="0" group="1"/></mujocoinclude>'
    )
    (tmp_path / "a.xml").write_text(
        '<mujoco><worldbody><body pos="0 0 5"><include file="part.xml"/><geom size="3" group="3"/>'
        "</body></worldbody></mujoco>"
    )
    assert read_description(tmp_path / "a.xml").bounds == pytest.approx(np.array([[-1, -1, 4], [1, 1, 6]]))
    assert read_description(tmp_path / "a.xml", "collision").bounds[:, 2] == pytest.approx([2.0, 8.0])
