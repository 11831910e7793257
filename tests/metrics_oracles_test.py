#!/usr/bin/env python3
# Metrics of warped pictures against scikit-image (SSIM: Wang et al. 2004, Gaussian weights; PSNR) and flip-evaluator (FLIP: Andersson et al. 2020,
# by its authors), on the same bytes. Both live in a virtual environment that the launcher makes; skipped, visibly, where it is missing.
"""Usage: metrics_oracles_test.py WARPSCOPE PICTURE_METRICS VIRTUAL_ENVIRONMENT. Exit codes: 0 passed, 1 failed, 77 skipped."""
import json
import os
import subprocess
import sys
import tempfile

SKIPPED = 77
SCENES = ["shells", "block"]
TECHNIQUES = ["points", "spheres", "hold"]
ANGLES_DEG = [10, 25]
SIZE = "400x301"  # neither side a multiple of anything
BACKGROUND = (40, 90, 160)
TOLERANCES = {"psnrDb": 1e-5, "ssim": 1e-5, "flip": 1e-4}


def enter(environment):
    """Goes on in the virtual environment, or ends the test as skipped."""
    python = os.path.join(environment, "bin", "python3")
    if os.path.realpath(sys.prefix) == os.path.realpath(environment):
        return
    if not os.path.exists(os.path.join(environment, "installed.txt")) or not os.access(python, os.X_OK):
        print(f"skipped: scikit-image and flip-evaluator are not in {environment}; './warpscope test' installs them where it can reach PyPI")
        sys.exit(SKIPPED)
    os.execv(python, [python] + sys.argv)


def opaque(path, out):
    """Writes the picture at `path`, which may be transparent, over a background, and returns it: height x width x 3 of 0..255."""
    import numpy
    from PIL import Image
    rgba = numpy.asarray(Image.open(path).convert("RGBA"), dtype=numpy.float64)
    alpha = rgba[..., 3:] / 255.0
    picture = numpy.rint(alpha * rgba[..., :3] + (1.0 - alpha) * numpy.array(BACKGROUND)).astype(numpy.uint8)
    Image.fromarray(picture, "RGB").save(out)
    return picture


def oracles(reference, picture):
    import flip_evaluator
    from skimage.metrics import peak_signal_noise_ratio, structural_similarity
    a, b = reference.astype("float64") / 255.0, picture.astype("float64") / 255.0
    _, flip, _ = flip_evaluator.evaluate(a.astype("float32"), b.astype("float32"), "LDR", inputsRGB=True, applyMagma=False)
    return {"psnrDb": peak_signal_noise_ratio(a, b, data_range=1.0),
            "ssim": structural_similarity(a, b, channel_axis=2, gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1.0),
            "flip": flip}


def check(program, metrics, scene, folder):
    """Returns how many figures were compared and the sentences about those that differ."""
    out = os.path.join(folder, scene)
    subprocess.run([program, "compare", scene, "--size", SIZE, "--out", out, "--quiet"], check=True, stdout=subprocess.DEVNULL)
    with open(os.path.join(out, "metrics.json"), encoding="utf-8") as file:
        views = {round(row["angleDeg"]): row["view"] for row in json.load(file)["rows"]}
    compared, failures = 0, []
    for angle in ANGLES_DEG:
        paths, pictures = [], []
        for technique in ["reference"] + TECHNIQUES:
            paths.append(os.path.join(out, f"{angle}-{technique}.png"))
            pictures.append(opaque(os.path.join(out, f"view{views[angle]}-{technique}.png"), paths[-1]))
        ours = json.loads(subprocess.run([metrics] + paths, check=True, capture_output=True, text=True).stdout)
        for technique, picture, figures in zip(TECHNIQUES, pictures[1:], ours, strict=True):
            for name, expected in oracles(pictures[0], picture).items():
                difference = abs(figures[name] - expected)
                line = f"{scene}, {angle} degrees, {technique}: {name} {figures[name]:.7f}, oracle {expected:.7f}, apart {difference:.1e}"
                print(line)
                compared += 1
                if not difference <= TOLERANCES[name]:
                    failures.append(f"{line}, allowed {TOLERANCES[name]:.0e}")
    return compared, failures


def main():
    if len(sys.argv) != 4:
        print(__doc__, file=sys.stderr)
        return 2
    program, metrics, environment = sys.argv[1:]
    enter(environment)
    compared, failures = 0, []
    with tempfile.TemporaryDirectory() as folder:
        for scene in SCENES:
            count, messages = check(program, metrics, scene, folder)
            compared += count
            failures += messages
    for failure in failures:
        print("FAILED: " + failure, file=sys.stderr)
    if compared != len(SCENES) * len(ANGLES_DEG) * len(TECHNIQUES) * len(TOLERANCES):
        print(f"FAILED: only {compared} figures were compared", file=sys.stderr)
        return 1
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
