#!/usr/bin/env python3
# What a picture says of the places between its pixels: the truth, taken at every fourth pixel of a picture four times as wide and high, and resampled at the others.
# An estimate, not a bound, of what can be drawn from one ray a pixel at angles at which hardly anything is missing but what lies between the rays.
# Linear, and cubic (Keys 1981, a = -1/2), in linear light; PSNR in sRGB over black, as the program's. A measurement, not a test; wants Debian's python3-numpy and python3-pil.
"""Usage: between_pixels.py PROGRAM SCENE... Prints dB for linear and cubic: the mean over all 16 places a pixel, and over the four beside one another."""
import os
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image

SIDE, PLACES = 1024, 4


def linear_light(path):
    pixels = np.asarray(Image.open(path).convert("RGBA"), dtype=np.float32) / 255
    colour, alpha = pixels[..., :3], pixels[..., 3:]
    return np.where(colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4) * alpha


def srgb(light):
    light = np.clip(light, 0, 1)
    return np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)


def weights(kind, t):
    if kind == "linear":
        return {0: 1 - t, 1: t}
    return {-1: t * (-0.5 + t * (1 - 0.5 * t)), 0: 1 + t * t * (-2.5 + 1.5 * t), 1: t * (0.5 + t * (2 - 1.5 * t)), 2: t * t * (-0.5 + 0.5 * t)}


def resampled(picture, kind, t, axis):
    return sum(weight * np.roll(picture, -step, axis) for step, weight in weights(kind, t).items())


def main():
    program, scenes = sys.argv[1], sys.argv[2:]
    if not scenes:
        sys.exit(__doc__)
    Image.MAX_IMAGE_PIXELS = None
    for scene in scenes:
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "truth.png")
            subprocess.run([program, "shot", scene, "--technique", "reference", "--size", f"{SIDE * PLACES}x{SIDE * PLACES}", "--quiet", "--out", file], check=True)
            truth = linear_light(file)
        known = truth[::PLACES, ::PLACES]
        for kind in ("linear", "cubic"):
            errors = np.array([[np.mean((srgb(resampled(resampled(known, kind, y / PLACES, 0), kind, x / PLACES, 1)) - srgb(truth[y::PLACES, x::PLACES])) ** 2)
                                for x in range(PLACES)] for y in range(PLACES)])
            print(f"{os.path.basename(scene)}: {kind} {-10 * np.log10(errors.mean()):.1f} dB, beside one another {-10 * np.log10(errors[0].mean()):.1f} dB", flush=True)


if __name__ == "__main__":
    main()
