"""Readings as ROS 2 messages: the one encoder, whose bytes go to recordings and to every bridge."""
