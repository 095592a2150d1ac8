"""Times VTK's two volume ray casters on a raw volume and prints JSON.

    target/deps/vtk/bin/python tools/peers/vtk_render.py --raw target/bench/head.raw --table tools/peers/tables/soft.json

One sample a voxel, linear interpolation, no jitter, no automatic sample distance, parallel projection whose square frame
just holds the volume's box. Every repetition turns the camera a little, so that nothing can be reused, and waits until
the picture is finished. "render" stops there; "frame" also reads the picture back, as an offline user must. With --serve
one mapper, shaded or not, draws a frame for every line on standard input, and prints its seconds.

The eye looks from (sin a cos e, -cos a cos e, sin e) with +z up: azimuth 0, elevation 0 is a patient's face (LPS).
"""

import argparse
import json
import math
import os
import pathlib
import sys

os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

import numpy as np
import vtkmodules.vtkRenderingVolumeOpenGL2  # noqa: F401  registers the OpenGL implementation
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray, vtkVersion
from vtkmodules.vtkCommonDataModel import vtkPiecewiseFunction
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingCore import (
    vtkColorTransferFunction,
    vtkRenderer,
    vtkRenderWindow,
    vtkVolume,
    vtkVolumeProperty,
    vtkWindowToImageFilter,
)
from vtkmodules.vtkRenderingVolume import vtkFixedPointVolumeRayCastMapper
from vtkmodules.vtkRenderingVolumeOpenGL2 import vtkOpenGLGPUVolumeRayCastMapper

from timing import measure, serve
from volumes import image_from_array

TYPES = {"u8": "u1", "i16": "<i2", "u16": "<u2", "f32": "<f4"}
TURN_DEG = 0.01


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--raw", required=True, type=pathlib.Path)
    parser.add_argument("--dims", nargs=3, type=int, default=[256, 256, 256])
    parser.add_argument("--spacing", nargs=3, type=float, default=[1.0, 1.0, 1.0], help="mm")
    parser.add_argument("--type", choices=TYPES, default="u8")
    parser.add_argument("--table", required=True, type=pathlib.Path)
    parser.add_argument("--mapper", nargs="+", choices=["gpu", "fixed"], default=["gpu", "fixed"])
    parser.add_argument("--shade", nargs="+", choices=["off", "on"], default=["off", "on"])
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--azimuth", type=float, default=30.0, help="degrees")
    parser.add_argument("--elevation", type=float, default=20.0, help="degrees")
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--threads", type=int, default=2, help="of the CPU ray caster")
    parser.add_argument("--png", type=pathlib.Path, help="folder for the pictures")
    parser.add_argument("--serve", action="store_true", help="a frame for every line on standard input")
    return parser.parse_args()


def load(args):
    voxels = np.fromfile(args.raw, TYPES[args.type])
    expected = math.prod(args.dims)
    if voxels.size != expected:
        sys.exit(f"{args.raw}: {voxels.size} voxels, the dimensions say {expected}")
    return image_from_array(voxels.reshape(args.dims[::-1]), args.spacing)


def appearance(table, shade, voxel_mm):
    """Opacity per voxel length, colour, and Phong coefficients."""
    opacity = vtkPiecewiseFunction()
    for value, alpha in table["opacity_per_voxel"]:
        opacity.AddPoint(value, alpha)
    colour = vtkColorTransferFunction()
    for value, *rgb in table["colour"]:
        colour.AddRGBPoint(value, *rgb)
    properties = vtkVolumeProperty()
    properties.SetScalarOpacity(opacity)
    properties.SetColor(colour)
    properties.SetScalarOpacityUnitDistance(voxel_mm)
    properties.SetInterpolationTypeToLinear()
    properties.SetShade(shade)
    properties.SetAmbient(0.1)
    properties.SetDiffuse(0.7)
    properties.SetSpecular(0.2)
    properties.SetSpecularPower(8.0)
    return properties


def gpu_mapper(voxel_mm, _threads):
    mapper = vtkOpenGLGPUVolumeRayCastMapper()
    mapper.SetUseJittering(False)
    mapper.SetSampleDistance(voxel_mm)
    return mapper


def fixed_mapper(voxel_mm, threads):
    mapper = vtkFixedPointVolumeRayCastMapper()
    mapper.SetNumberOfThreads(threads)
    mapper.SetSampleDistance(voxel_mm)
    mapper.SetInteractiveSampleDistance(voxel_mm)
    return mapper


MAPPERS = {"gpu": gpu_mapper, "fixed": fixed_mapper}


def view_axes(azimuth_deg, elevation_deg):
    """Rows right, up, toward the eye; orthonormal."""
    a, e = math.radians(azimuth_deg), math.radians(elevation_deg)
    toward = np.array([math.sin(a) * math.cos(e), -math.cos(a) * math.cos(e), math.sin(e)])
    right = np.array([math.cos(a), math.sin(a), 0.0])
    return np.array([right, np.cross(toward, right), toward])


def half_height(axes, image):
    """The largest eye-space |x| or |y| of the box's corners about its centre, mm."""
    low, high = np.array(image.GetBounds()).reshape(3, 2).T
    return float((np.abs(axes[:2]) @ ((high - low) / 2)).max())


def place_camera(renderer, image, args):
    axes = view_axes(args.azimuth, args.elevation)
    centre = np.array(image.GetCenter())
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    camera.SetFocalPoint(*centre)
    camera.SetPosition(*(centre + axes[2] * 2 * image.GetLength()))
    camera.SetViewUp(*axes[1])
    camera.SetParallelScale(half_height(axes, image))
    renderer.ResetCameraClippingRange()
    return {"right": list(axes[0]), "up": list(axes[1]), "toward_eye": list(axes[2]),
            "centre_mm": list(centre), "half_height_mm": camera.GetParallelScale()}


def open_window(size):
    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetSize(size, size)
    renderer = vtkRenderer()
    window.AddRenderer(renderer)
    return window, renderer


def device(window):
    lines = [line.split(":", 1) for line in window.ReportCapabilities().splitlines()
             if line.startswith(("OpenGL renderer string", "OpenGL version string"))]
    return {key.strip(): value.strip() for key, value in lines}


def save(window, path):
    path.parent.mkdir(parents=True, exist_ok=True)
    grab = vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    writer = vtkPNGWriter()
    writer.SetInputConnection(grab.GetOutputPort())
    writer.SetFileName(str(path))
    writer.Write()


def picture_path(args, kind, shade):
    return args.png / f"vtk-{args.raw.stem}-{args.table.stem}-{kind}-shade-{'on' if shade else 'off'}.png"


class Case:
    """A volume in a window, its first frame drawn."""

    def __init__(self, image, table, args, kind, shade):
        voxel_mm = min(image.GetSpacing())
        self.window, self.renderer = open_window(args.size)
        mapper = MAPPERS[kind](voxel_mm, args.threads)
        mapper.SetInputData(image)
        mapper.SetAutoAdjustSampleDistances(False)
        mapper.SetImageSampleDistance(1.0)
        volume = vtkVolume()
        volume.SetMapper(mapper)
        volume.SetProperty(appearance(table, shade, voxel_mm))
        self.renderer.AddVolume(volume)
        view = place_camera(self.renderer, image, args)
        self.window.Render()
        self.about = {"vtk": vtkVersion.GetVTKVersion(), "mapper": mapper.GetClassName(), "shaded": shade, "view": view,
                      "device": device(self.window)}
        if args.png:
            path = picture_path(args, kind, shade)
            save(self.window, path)
            self.about["picture"] = str(path)
        self.pixels = vtkUnsignedCharArray()
        self.last = args.size - 1

    def render(self, i):
        self.renderer.GetActiveCamera().Azimuth(TURN_DEG if i % 2 else -TURN_DEG)
        self.window.Render()
        self.window.WaitForCompletion()

    def frame(self, i):
        self.render(i)
        self.window.GetRGBACharPixelData(0, 0, self.last, self.last, 0, self.pixels)


def time_case(image, table, args, kind, shade):
    case = Case(image, table, args, kind, shade)
    return case.about | {"render": measure(case.render, args.repeats), "frame": measure(case.frame, args.repeats)}


def main():
    args = arguments()
    image = load(args)
    table = json.loads(args.table.read_text())
    if args.serve:
        case = Case(image, table, args, args.mapper[0], args.shade[0] == "on")
        serve(case.about, case.frame)
        return
    results = [time_case(image, table, args, kind, shade == "on") for kind in args.mapper for shade in args.shade]
    json.dump({"vtk": vtkVersion.GetVTKVersion(), "raw": str(args.raw), "table": args.table.stem, "size": args.size,
               "threads": args.threads, "load_average": os.getloadavg(), "results": results}, sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
