"""A camera by the dam: `pelagos holoocean camera.py`."""

import sys

import holoocean
from PIL import Image

with holoocean.make("Dam-HoveringCamera") as env:
    env.act("auv0", [0, 0, 0, 0, 5, 5, 5, 5])
    for _ in range(201):
        state = env.tick()
        if "LeftCamera" in state:
            picture = state["LeftCamera"]
Image.fromarray(picture[:, :, 2::-1]).save(sys.argv[1] if len(sys.argv) > 1 else "left.png")
print(picture.shape, picture[:, :, :3].mean(axis=(0, 1)).round(1))
