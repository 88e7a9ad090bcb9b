"""Doors to other software: ROS 2, autopilots, LCM, MOOS, viewers and instruments' own languages; no physics."""
