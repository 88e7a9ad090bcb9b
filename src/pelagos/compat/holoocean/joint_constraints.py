"""Limits of joints, of agents that Pelagos does not have."""

from __future__ import annotations


def get_joint_constraints(agent_type: str, joint_name: str) -> None:
    """None: no agent of Pelagos has HoloOcean's joints."""
    return None
