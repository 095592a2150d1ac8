"""Reads volume files with SimpleITK or VTK and prints what they say, one JSON line a file: sizes, place, and the voxels' bytes' checksum.

    target/deps/vtk/bin/python tests/oracle/read_volume.py itk head.nrrd vtk head.vti …
"""

import json
import sys
import zlib

import numpy as np


def described(size, spacing, origin, direction, voxels, components):
    """Voxels lie x fastest, and are told in little-endian order."""
    voxels = np.ascontiguousarray(voxels)
    values = np.abs(voxels.astype(np.complex128)) if voxels.dtype.kind == "c" else voxels.astype(np.float64)
    finite = values[np.isfinite(values)]
    return {
        "size": list(size),
        "spacing": list(spacing),
        "origin": list(origin),
        "direction": list(direction),
        "voxel": voxels.dtype.newbyteorder("<").str[1:],
        "components": components,
        "checksum": zlib.crc32(voxels.astype(voxels.dtype.newbyteorder("<")).tobytes()),
        "min": float(finite.min()),
        "max": float(finite.max()),
        "mean": float(finite.mean()),
    }


def with_itk(path):
    import SimpleITK as sitk

    sitk.ProcessObject.SetGlobalWarningDisplay(False)
    image = sitk.ReadImage(path)
    return described(
        image.GetSize(),
        image.GetSpacing(),
        image.GetOrigin(),
        image.GetDirection(),
        sitk.GetArrayViewFromImage(image),
        image.GetNumberOfComponentsPerPixel(),
    )


def with_vtk(path):
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLImageDataReader

    reader = vtkXMLImageDataReader()
    reader.SetFileName(path)
    reader.Update()
    image = reader.GetOutput()
    matrix = image.GetDirectionMatrix()
    direction = [matrix.GetElement(row, column) for row in range(3) for column in range(3)]
    scalars = image.GetPointData().GetScalars()
    return described(
        image.GetDimensions(),
        image.GetSpacing(),
        image.GetOrigin(),
        direction,
        vtk_to_numpy(scalars),
        scalars.GetNumberOfComponents(),
    )


READERS = {"itk": with_itk, "vtk": with_vtk}

for reader, path in zip(sys.argv[1::2], sys.argv[2::2]):
    print(json.dumps(READERS[reader](path)))
