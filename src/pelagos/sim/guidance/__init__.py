"""Missions: legs become tasks (`plan`), tasks goals (`guidance`), and goals set-points of a mode (`steering`)."""
