"""Writes a DICOM series of JPEG 2000, lossless, a file a slice, into a folder: dicom_series.py FOLDER.

The volume is the CT head that setup brings, made 512 x 512 pixels, under noise of three bits as a scanner's.
"""

import pathlib
import sys

import imagecodecs
import numpy
import pydicom
import scipy.ndimage
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.encaps import encapsulate

JPEG_2000 = "1.2.840.10008.1.2.4.90"
CT_HEAD = "target/deps/data/cranium.raw"


def head():
    voxels = numpy.fromfile(CT_HEAD, "<i2").reshape(108, 256, 256)
    larger = scipy.ndimage.zoom(voxels, (1, 2, 2), order=1)
    noise = numpy.random.default_rng(1).integers(-4, 4, larger.shape, dtype="i2")
    return larger + noise


def slice_file(path, pixels, number):
    data = Dataset()
    data.file_meta = FileMetaDataset()
    data.file_meta.TransferSyntaxUID = JPEG_2000
    data.SOPClassUID, data.SOPInstanceUID = "1.2.840.10008.5.1.4.1.1.2", f"1.2.3.{number + 1}"
    data.file_meta.MediaStorageSOPClassUID, data.file_meta.MediaStorageSOPInstanceUID = data.SOPClassUID, data.SOPInstanceUID
    data.StudyInstanceUID, data.SeriesInstanceUID = "1.2.1", "1.2.2"
    data.Modality, data.InstanceNumber = "CT", number
    data.ImagePositionPatient, data.ImageOrientationPatient = [0, 0, 1.5 * number], [1, 0, 0, 0, 1, 0]
    data.PixelSpacing, data.SliceThickness = [0.5, 0.5], 1.5
    data.Rows, data.Columns = pixels.shape
    data.SamplesPerPixel, data.PhotometricInterpretation = 1, "MONOCHROME2"
    data.BitsAllocated, data.BitsStored, data.HighBit, data.PixelRepresentation = 16, 16, 15, 1
    stream = imagecodecs.jpeg2k_encode(pixels, level=0, reversible=True, codecformat="j2k")
    data.PixelData = encapsulate([stream])
    data["PixelData"].VR = "OB"
    data.preamble = bytes(128)
    pydicom.dcmwrite(path, data)


def main():
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for number, pixels in enumerate(head()):
        slice_file(folder / f"{number:03}.dcm", pixels, number)


main()
