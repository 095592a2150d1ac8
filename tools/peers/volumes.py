"""Writes the two benchmark volumes under target/bench: 256 cubed voxels, u8, 1 mm, x fastest.

dense.raw  smooth noise from 40 to 255 that fills the cube: no voxel is invisible
head.raw   the MR head ch2.nii.gz at 0.9 mm, centred in air, its voxels called 1 mm
"""

import gzip
import pathlib
import sys

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkImagingCore import vtkImageReslice

SIDE = 256
HEAD_SPACING_MM = 0.9
ROOT = pathlib.Path(__file__).resolve().parents[2]


def image_from_array(array, spacing=(1.0, 1.0, 1.0)):
    """A vtkImageData over a (z, y, x) array, its origin at 0."""
    image = vtkImageData()
    image.SetDimensions(array.shape[::-1])
    image.SetSpacing(spacing)
    image.GetPointData().SetScalars(numpy_to_vtk(array.ravel(), deep=True))
    return image


def dense():
    """Value noise: 32 random knots an axis, joined by smoothstep."""
    knots = 32
    at = np.arange(SIDE) * (knots - 1) / (SIDE - 1)
    cell = np.minimum(at.astype(int), knots - 2)
    step = (at - cell) ** 2 * (3 - 2 * (at - cell))
    blend = np.zeros((SIDE, knots))
    blend[np.arange(SIDE), cell] = 1 - step
    blend[np.arange(SIDE), cell + 1] = step
    noise = np.random.default_rng(1).random((knots, knots, knots))
    for _ in range(3):
        noise = np.tensordot(noise, blend, axes=(0, 1))
    noise = (noise - noise.min()) / (noise.max() - noise.min())
    return np.round(40 + 215 * noise).astype(np.uint8)


def head():
    """ch2 on a lattice of 256 cubed points round its centre."""
    packed = ROOT / "target/deps/data/ch2.nii.gz"
    if not packed.exists():
        sys.exit(f"{packed} is missing: run make setup")
    voxels = np.frombuffer(gzip.decompress(packed.read_bytes())[352:], np.uint8)
    # NIfTI counts to the right and to the front, LPS to the left and to the back.
    source = image_from_array(voxels.reshape(181, 217, 181)[:, ::-1, ::-1])
    reslice = vtkImageReslice()
    reslice.SetInputData(source)
    reslice.SetInterpolationModeToLinear()
    reslice.SetOutputSpacing([HEAD_SPACING_MM] * 3)
    reslice.SetOutputExtent(0, SIDE - 1, 0, SIDE - 1, 0, SIDE - 1)
    half = (SIDE - 1) / 2 * HEAD_SPACING_MM
    reslice.SetOutputOrigin([c - half for c in source.GetCenter()])
    reslice.Update()
    return vtk_to_numpy(reslice.GetOutput().GetPointData().GetScalars())


def main():
    folder = ROOT / "target/bench"
    folder.mkdir(parents=True, exist_ok=True)
    for name, make in (("dense", dense), ("head", head)):
        path = folder / f"{name}.raw"
        if not path.exists():
            beside = path.with_suffix(".part")
            make().tofile(beside)
            beside.rename(path)
        print(path)


if __name__ == "__main__":
    main()
