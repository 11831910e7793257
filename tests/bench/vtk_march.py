#!/usr/bin/env python3
# The CPU march beside VTK's fixed-point ray caster (vtkFixedPointVolumeRayCastMapper): times in turns on one machine, and both pictures.
# Same volume, transfer function, camera and step. The packages are those of vtk_requirements.txt, for this script alone.
"""Usage: vtk_march.py MARCH_FRAMES VOLUME.raw --out FOLDER

Writes one line a view, FOLDER/vtk_march.json and pictures: warpscope's, VTK's and their difference, side by side. MARCH_FRAMES is the program of that name
in the build's folder tests/. VOLUME is raw, of 8 bits, with its size in its name. Exit codes: 0; 1 if pictures are farther apart than --flip."""
import argparse
import ctypes
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time

import numpy
from PIL import Image

# Pictures are compared as they are shown: sRGB over this background (linear).
BACKGROUND = 0.0


def encoded(linear):
    """Linear light as sRGB (IEC 61966-2-1), both 0..1."""
    linear = numpy.clip(linear, 0.0, 1.0)
    return numpy.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def shown(premultiplied):
    """A picture of premultiplied linear colours as 8-bit values of a screen, 0..1."""
    linear = premultiplied[..., :3] + (1.0 - premultiplied[..., 3:]) * BACKGROUND
    return numpy.rint(255.0 * encoded(linear)) / 255.0


class Warpscope:
    """Runs march_frames anew each turn: a turn is a process, as a user would start it."""

    def __init__(self, program, scene, view, side, folder):
        self.command = [program, scene, str(side), str(view[0]), str(view[1])]
        self.side, self.path = side, os.path.join(folder, "picture.rgba")
        self.times = {"pictures": {"wallS": [], "cpuS": []}, "frames": {"wallS": [], "cpuS": []}}

    def turn(self, runs):
        done = subprocess.run(self.command + [str(runs), self.path], check=True, capture_output=True, text=True)
        self.facts = json.loads(done.stdout)
        for what, times in self.times.items():
            for clock in times:
                times[clock] += self.facts[what][clock]

    def picture(self):
        return numpy.fromfile(self.path, dtype=numpy.float32).reshape(self.side, self.side, 4)


class Vtk:
    """What VTK takes is counted between the events that it sends before and after its rays: not the drawing of the finished picture by OpenGL, which
    is done in software here, nor what it prepares where nothing changed."""

    def __init__(self, facts, voxels, side, light):
        import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  what makes windows
        import vtkmodules.vtkRenderingVolumeOpenGL2  # noqa: F401
        from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPiecewiseFunction
        from vtkmodules.vtkRenderingCore import vtkColorTransferFunction, vtkLight, vtkRenderer, vtkRenderWindow, vtkVolume, vtkVolumeProperty
        from vtkmodules.vtkRenderingVolume import vtkFixedPointVolumeRayCastMapper
        from vtkmodules.util.numpy_support import numpy_to_vtk

        volume, camera = facts["volume"], facts["camera"]
        image = vtkImageData()
        image.SetDimensions(volume["dims"])
        image.SetSpacing(volume["edges"])
        image.SetOrigin([lower + 0.5 * edge for lower, edge in zip(volume["lower"], volume["edges"], strict=True)])
        self.scalars = numpy_to_vtk(voxels)
        image.GetPointData().SetScalars(self.scalars)

        color, opacity = vtkColorTransferFunction(), vtkPiecewiseFunction()
        color.SetColorSpaceToRGB()
        table = numpy.array(facts["transfer"])
        isVisible = numpy.flatnonzero(table[:, 3] > 0)
        for value, row in enumerate(table):
            nearest = table[isVisible[numpy.abs(isVisible - value).argmin()]]  # what is invisible has a colour, too, that VTK blends
            color.AddRGBPoint(value, *nearest[:3])
            opacity.AddPoint(value, row[3])
        look = vtkVolumeProperty()
        look.SetColor(color)
        look.SetScalarOpacity(opacity)
        look.SetScalarOpacityUnitDistance(1.0)
        look.SetInterpolationTypeToLinear()
        if light is None:
            look.ShadeOff()
        else:
            look.ShadeOn()
            look.SetAmbient(light["ambient"])
            look.SetDiffuse(light["diffuse"])
            look.SetSpecular(light["specular"])
            look.SetSpecularPower(light["exponent"])

        self.mapper = vtkFixedPointVolumeRayCastMapper()
        self.mapper.SetInputData(image)
        self.mapper.AutoAdjustSampleDistancesOff()
        self.mapper.LockSampleDistanceToInputSpacingOff()
        self.mapper.SetImageSampleDistance(1.0)
        self.mapper.SetSampleDistance(facts["step"])
        self.mapper.SetInteractiveSampleDistance(facts["step"])
        self.mapper.SetNumberOfThreads(os.cpu_count())
        actor = vtkVolume()
        actor.SetMapper(self.mapper)
        actor.SetProperty(look)

        self.window, renderer = vtkRenderWindow(), vtkRenderer()
        self.window.SetOffScreenRendering(1)
        self.window.SetMultiSamples(0)
        self.window.SetSize(side, side)
        self.window.AddRenderer(renderer)
        renderer.AddVolume(actor)
        headlight = vtkLight()
        headlight.SetLightTypeToHeadlight()
        headlight.SetAmbientColor(1.0, 1.0, 1.0)  # black unless it is set: then there is no ambient light
        renderer.AddLight(headlight)
        vtkCamera = renderer.GetActiveCamera()
        eye, forward, up = (numpy.array(camera[key]) for key in ("eye", "forward", "up"))
        self.isMirrored = numpy.dot(numpy.cross(forward, up), camera["right"]) < 0
        vtkCamera.SetPosition(*eye)
        vtkCamera.SetFocalPoint(*(eye + forward * max(volume["dims"])))
        vtkCamera.SetViewUp(*up)
        vtkCamera.SetViewAngle(2 * numpy.degrees(numpy.arctan(camera["tanHalfFovY"])))
        renderer.ResetCameraClippingRange()
        self.side, self.times = side, {"wallS": [], "cpuS": []}
        self.mapper.AddObserver("VolumeMapperRenderStartEvent", lambda *_: self.start())
        self.mapper.AddObserver("VolumeMapperRenderEndEvent", lambda *_: self.end())
        self.window.Render()  # warms up, and prepares gradients
        self.times = {"wallS": [], "cpuS": []}

    def start(self):
        self.started = time.perf_counter(), time.process_time()

    def end(self):
        self.times["wallS"].append(time.perf_counter() - self.started[0])
        self.times["cpuS"].append(time.process_time() - self.started[1])

    def turn(self, runs):
        for _ in range(runs):
            self.window.Render()

    def picture(self):
        """The ray caster's own picture, of 15 bits a channel: what is drawn on the screen has lost 7 of them. It covers the part that the volume does."""
        image = self.mapper.GetRayCastImage()
        memory, used, origin = image.GetImageMemorySize(), image.GetImageInUseSize(), image.GetImageOrigin()
        address = int(image.GetImage().split("_")[1], 16)
        values = numpy.ctypeslib.as_array(ctypes.cast(address, ctypes.POINTER(ctypes.c_uint16)), (memory[1], memory[0], 4))
        whole = numpy.zeros((self.side, self.side, 4), numpy.float32)
        whole[origin[1]:origin[1] + used[1], origin[0]:origin[0] + used[0]] = values[:used[1], :used[0]] / 32767.0
        whole = whole[::-1]
        return whole[:, ::-1] if self.isMirrored else whole


def compared(ours, theirs):
    import flip_evaluator
    flipMap, flip, _ = flip_evaluator.evaluate(ours.astype("float32"), theirs.astype("float32"), "LDR", inputsRGB=True, applyMagma=True)
    return flipMap, flip


def summary(times):
    return {clock: {"least": min(values), "median": statistics.median(values)} for clock, values in times.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("volume")
    parser.add_argument("--out", required=True)
    parser.add_argument("--size", type=int, default=1024, help="pixels of a side")
    parser.add_argument("--step", type=float, default=0.5)
    parser.add_argument("--turns", type=int, default=6)
    parser.add_argument("--runs", type=int, default=5, help="frames a turn")
    parser.add_argument("--views", default="0:1,35:0.8", help="ANGLE:DISTANCE,...")
    parser.add_argument("--shaded", action="store_true", help="ambient, diffuse and specular light from the eye in both; needs a program that has shading")
    parser.add_argument("--flip", type=float, default=0.02, help="how far pictures may be apart")
    options = parser.parse_args()
    light = {"ambient": 0.3, "diffuse": 0.7, "specular": 0.2, "exponent": 20.0} if options.shaded else None
    os.makedirs(options.out, exist_ok=True)

    results = []
    with tempfile.TemporaryDirectory() as folder:
        march = {"step": options.step}
        if light:
            march |= {"shading": 1, "lights": "camera:0,0,1"} | light  # VTK takes one direction of light and view for the whole picture
        scene = os.path.join(folder, "scene.json")
        with open(scene, "w", encoding="utf-8") as file:
            json.dump({"name": "vtk", "volume": {"file": os.path.abspath(options.volume)}, "march": march}, file)
        for view in [tuple(map(float, text.split(":"))) for text in options.views.split(",")]:
            ours = Warpscope(options.program, scene, view, options.size, folder)
            ours.turn(1)
            voxels = numpy.fromfile(options.volume, dtype=numpy.uint8)
            theirs = Vtk(ours.facts, voxels, options.size, light)
            for _ in range(options.turns):
                ours.turn(options.runs)
                theirs.turn(options.runs)
            pictures = shown(ours.picture()), shown(theirs.picture())
            difference, flip = compared(*pictures)
            name = f"{'shaded' if light else 'unlit'}-{view[0]:g}-{view[1]:g}.png"
            Image.fromarray((255 * numpy.hstack([*pictures, difference])).round().astype(numpy.uint8)).save(os.path.join(options.out, name))
            row = {"angleDeg": view[0], "distance": view[1], "shaded": bool(light), "flip": float(flip), "covered": float((ours.picture()[..., 3] > 0).mean()),
                   "vtk": summary(theirs.times), **{what: summary(times) for what, times in ours.times.items()}}
            results.append(row)
            for clock, cores in (("wallS", "by the clock"), ("cpuS", "of all cores")):
                vtk, picture, frame = (row[key][clock] for key in ("vtk", "pictures", "frames"))
                print(f"{name}: {cores}: VTK {1e3 * vtk['least']:.0f} ms (median {1e3 * vtk['median']:.0f}), picture {1e3 * picture['least']:.0f} "
                      f"({1e3 * picture['median']:.0f}), frame with depths {1e3 * frame['least']:.0f} ({1e3 * frame['median']:.0f}): "
                      f"{vtk['least'] / picture['least']:.2f} and {vtk['least'] / frame['least']:.2f} times as fast")
            print(f"{name}: FLIP {flip:.4f}")
    with open(os.path.join(options.out, "vtk_march.json"), "w", encoding="utf-8") as file:
        json.dump({"size": options.size, "step": options.step, "cores": os.cpu_count(), "rows": results}, file, indent=2)
    if not all(row["flip"] <= options.flip for row in results):
        print(f"pictures are farther apart than FLIP {options.flip}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
