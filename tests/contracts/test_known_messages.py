"""Messages of every sensor for numbers that all differ, of two copies one of which has measured nothing, by several
settings; true motion, plans, structures of LCM, forms in JSON."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from known import DOUBLE, check, on_one_scale
from pelagos.bridges.lcm_transport import STRUCTURES
from pelagos.bridges.machinery import battery_message, joint_message, supply_of
from pelagos.bridges.rihs import type_hash
from pelagos.config import registry
from pelagos.messages import lcm, motion
from pelagos.messages.encoders import ENCODERS, encoder
from pelagos.messages.encoding import Site
from pelagos.messages.group import plan_label  # noqa: F401
