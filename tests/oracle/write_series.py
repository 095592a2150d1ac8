"""Writes volumes as DICOM series with pydicom: a request is a line of JSON, {"folder", "dims", "origin", "steps"}, with the voxels after
it, bytes, x fastest; `steps` are the millimetres from voxel to voxel along x, y and z, three numbers each. The answer is an empty line."""

import json
import pathlib
import sys

import numpy
import pydicom
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.uid import ExplicitVRLittleEndian


def slice_file(request, number, pixels):
    steps = numpy.array(request["steps"])
    lengths = numpy.linalg.norm(steps, axis=1)
    data = Dataset()
    data.file_meta = FileMetaDataset()
    data.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
    data.SOPClassUID, data.SOPInstanceUID = "1.2.840.10008.5.1.4.1.1.4", f"1.2.3.{number + 1}"
    data.file_meta.MediaStorageSOPClassUID, data.file_meta.MediaStorageSOPInstanceUID = data.SOPClassUID, data.SOPInstanceUID
    data.StudyInstanceUID, data.SeriesInstanceUID, data.Modality = "1.2.1", "1.2.2", "MR"
    # Numbered from the other end: it is the place that counts.
    data.InstanceNumber = request["dims"][2] - number
    data.ImagePositionPatient = list(request["origin"] + number * steps[2])
    data.ImageOrientationPatient = [*(steps[0] / lengths[0]), *(steps[1] / lengths[1])]
    data.PixelSpacing, data.SliceThickness = [lengths[1], lengths[0]], lengths[2]
    data.Rows, data.Columns = pixels.shape
    data.SamplesPerPixel, data.PhotometricInterpretation, data.PixelRepresentation = 1, "MONOCHROME2", 0
    data.BitsAllocated, data.BitsStored, data.HighBit = 8, 8, 7
    data.PixelData = pixels.tobytes() + bytes(pixels.size % 2)
    data["PixelData"].VR = "OB"
    data.preamble = bytes(128)
    return data


def main():
    while line := sys.stdin.buffer.readline():
        request = json.loads(line)
        x, y, z = request["dims"]
        voxels = numpy.frombuffer(sys.stdin.buffer.read(x * y * z), "u1").reshape(z, y, x)
        folder = pathlib.Path(request["folder"])
        folder.mkdir(parents=True)
        for number, pixels in enumerate(voxels):
            pydicom.dcmwrite(folder / f"{number}", slice_file(request, number, pixels))
        sys.stdout.buffer.write(b"\n")
        sys.stdout.buffer.flush()


main()
