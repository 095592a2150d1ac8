"""Writes small valid files of each format, from which fuzzing sets out: seeds FOLDER. They go to a folder a format, named as it is."""

import pathlib
import sys

import dicom_files
import plain
import tiff_stacks
import vtk_images
import zarr_arrays

SEEDS = {
    "nrrd": plain.nrrd,
    "nifti": plain.nifti,
    "metaimage": plain.metaimage,
    "dicom": dicom_files.dicom,
    "vtk-xml": vtk_images.xml,
    "vtk-legacy": vtk_images.legacy,
    "tiff": tiff_stacks.stacks,
    "zarr": zarr_arrays.arrays,
    "slices": tiff_stacks.folders,
    "volpack": plain.volpack,
    "raw": plain.raw,
}


def main():
    for name, seeds in SEEDS.items():
        folder = pathlib.Path(sys.argv[1]) / name
        folder.mkdir(parents=True, exist_ok=True)
        for n, data in enumerate(seeds()):
            (folder / f"{n:02}").write_bytes(data)


main()
