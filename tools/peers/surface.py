"""Times the extraction of a surface by another program, and prints JSON.

    target/deps/vtk/bin/python tools/peers/surface.py --raw target/bench/ball-256.f32 --side 256 --iso 0.5 --method flying-edges

VTK computes normals and keeps neither scalars nor gradients. scikit-image computes normals and values, PyMCubes no normals; both
run on one thread. With --serve one surface is made for every line on standard input.
"""

import argparse
import json
import os
import pathlib
import sys

import mcubes
import numpy as np
import skimage.measure
from vtkmodules.vtkCommonCore import vtkSMPTools
from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D, vtkMarchingCubes

from timing import measure, serve
from volumes import image_from_array

TYPES = {".u8": np.uint8, ".f32": np.float32}


def vtk_method(filter_type):
    """What starts a VTK filter on voxels: a function that makes the surface and says how many triangles and points it has."""

    def start(voxels, iso, threads):
        vtkSMPTools.SetBackend("STDThread")
        vtkSMPTools.Initialize(threads)
        surface = filter_type()
        surface.SetInputData(image_from_array(voxels))
        surface.SetValue(0, iso)
        surface.ComputeNormalsOn()
        surface.ComputeGradientsOff()
        surface.ComputeScalarsOff()

        def run():
            surface.Modified()
            surface.Update()
            return surface.GetOutput().GetNumberOfCells(), surface.GetOutput().GetNumberOfPoints()

        return run

    return start


def scikit_image(voxels, iso, _):
    def run():
        points, triangles, _, _ = skimage.measure.marching_cubes(voxels, iso)
        return len(triangles), len(points)

    return run


def pymcubes(voxels, iso, _):
    def run():
        points, triangles = mcubes.marching_cubes(voxels, iso)
        return len(triangles), len(points)

    return run


METHODS = {
    "flying-edges": vtk_method(vtkFlyingEdges3D),
    "marching-cubes": vtk_method(vtkMarchingCubes),
    "scikit-image": scikit_image,
    "pymcubes": pymcubes,
}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--raw", required=True, type=pathlib.Path, help="voxels, the suffix says their type")
    parser.add_argument("--side", required=True, type=int)
    parser.add_argument("--iso", required=True, type=float)
    parser.add_argument("--method", required=True, choices=METHODS)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--serve", action="store_true", help="a surface for every line on standard input")
    return parser.parse_args()


def main():
    args = arguments()
    voxels = np.fromfile(args.raw, TYPES[args.raw.suffix]).reshape(args.side, args.side, args.side)
    surface = METHODS[args.method](voxels, args.iso, args.threads)
    triangles, points = surface()
    about = {"raw": str(args.raw), "threads": args.threads, "triangles": triangles, "points": points,
             "load_average": os.getloadavg()}
    if args.serve:
        serve(about, lambda _: surface())
        return
    json.dump(about | {args.method: measure(lambda _: surface(), args.repeats)}, sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
