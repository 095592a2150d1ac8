//! Writing NIfTI-1 in one file.
//!
//! *Practice.* The place is written as sform, and where its axes are square to each other as qform too, with a mirror as `qfac`. Both
//! have 32-bit numbers: of each entry what `f32` does not hold is lost, a part in 2²⁴ (of 200 mm a hundred-thousandth).

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::geometry::LPS_FROM_RAS;
use super::write::{Contents, Output, Work, Writer, voxel_bytes};
use crate::math::affine;
use crate::volume::voxel::VoxelType;

/// How NIfTI is written.
pub(super) const WRITER: Writer = Writer {
    suffixes: &[".nii", ".nii.gz"],
    writes: "NIfTI-1 as its suffix says; sform, and qform where the axes are square; the place in 32-bit numbers",
    files,
};

/// Where the voxels start.
const OFFSET: usize = 352;

/// Scanner coordinates, for `sform_code` and `qform_code`.
const SCANNER: i16 = 1;

/// The largest cosine between axes that are square to each other as far as `f32` can tell: both unit vectors' entries may be off by
/// a part in 2²⁴, and with them the products' sum.
const SQUARE: f64 = 1.0 / (1 << 23) as f64;

fn files<'a>(work: &Work<'a>) -> Result<Vec<Output<'a>>, String> {
    let voxels = voxel_bytes(work.grid);
    let header = header(work)?;
    let contents = match work.path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz")) {
        true => vec![Contents::Gzip(vec![header.into(), voxels.into()])],
        false => vec![Contents::Made(header), Contents::There(voxels)],
    };
    let path = work.path.to_owned();
    Ok(vec![Output { path, contents }])
}

/// The header, and the four bytes that say that no extension follows.
fn header(work: &Work) -> Result<Vec<u8>, String> {
    let mut header = Header(vec![0; OFFSET]);
    let dims = work.grid.dims();
    let voxel = work.grid.voxel_type();
    header.put(0, 348_i32.to_ne_bytes());
    header.put(40, 3_i16.to_ne_bytes());
    for (axis, n) in dims.into_iter().chain([1; 4]).enumerate() {
        let n = i16::try_from(n).map_err(|_| {
            format!(
                "NIfTI-1 holds at most {} voxels along an axis, not {n}: write NRRD",
                i16::MAX
            )
        })?;
        header.put(42 + 2 * axis, n.to_ne_bytes());
    }
    header.put(70, data_type(voxel).to_ne_bytes());
    header.put(72, (8 * voxel.bytes() as i16).to_ne_bytes());
    header.float(108, OFFSET as f64);
    header.float(112, 1.0);
    header.put(123, [MILLIMETRES]);
    let ras_from_index = DAffine3::from_scale(LPS_FROM_RAS) * *work.grid.world_from_index();
    header.sform(&ras_from_index);
    header.qform(&ras_from_index);
    header.put(344, *b"n+1\0");
    match header.is_finite() {
        true => Ok(header.0),
        false => Err("its place is beyond 32-bit numbers: write NRRD".to_owned()),
    }
}

/// The unit of `xyzt_units`.
const MILLIMETRES: u8 = 2;

/// A header's bytes.
struct Header(Vec<u8>);

impl Header {
    fn put<const N: usize>(&mut self, at: usize, bytes: [u8; N]) {
        self.0[at..at + N].copy_from_slice(&bytes);
    }

    fn float(&mut self, at: usize, value: f64) {
        self.put(at, (value as f32).to_ne_bytes());
    }

    fn sform(&mut self, ras_from_index: &DAffine3) {
        self.put(254, SCANNER.to_ne_bytes());
        let axes = ras_from_index.matrix3.transpose();
        let rows = [axes.x_axis, axes.y_axis, axes.z_axis];
        for (n, (row, last)) in rows.into_iter().zip(ras_from_index.translation.to_array()).enumerate() {
            for (column, entry) in row.extend(last).to_array().into_iter().enumerate() {
                self.float(280 + 16 * n + 4 * column, entry);
            }
        }
    }

    /// The spacing, and the rotation if it is one, mirrored or not.
    fn qform(&mut self, ras_from_index: &DAffine3) {
        let spacing = affine::spacing(ras_from_index);
        let axes = ras_from_index.matrix3;
        let axes = DMat3::from_cols(
            axes.x_axis / spacing.x,
            axes.y_axis / spacing.y,
            axes.z_axis / spacing.z,
        );
        let qfac = axes.determinant().signum();
        for (n, size) in [qfac].into_iter().chain(spacing.to_array()).enumerate() {
            self.float(76 + 4 * n, size);
        }
        let cosines = [
            axes.x_axis.dot(axes.y_axis),
            axes.y_axis.dot(axes.z_axis),
            axes.z_axis.dot(axes.x_axis),
        ];
        if cosines.iter().any(|cosine| cosine.abs() > SQUARE) {
            return;
        }
        self.put(252, SCANNER.to_ne_bytes());
        let rotation = DQuat::from_mat3(&(axes * DMat3::from_diagonal(DVec3::new(1.0, 1.0, qfac)))).normalize();
        // The fourth component is not stored and taken for positive.
        let rotation = if rotation.w < 0.0 { -rotation } else { rotation };
        let numbers = [rotation.x, rotation.y, rotation.z].into_iter();
        for (n, number) in numbers.chain(ras_from_index.translation.to_array()).enumerate() {
            self.float(256 + 4 * n, number);
        }
    }

    /// Whether the numbers of the place are.
    fn is_finite(&self) -> bool {
        let float = |at: usize| f32::from_ne_bytes(std::array::from_fn(|n| self.0[at + n]));
        (256..328).chain(76..92).step_by(4).all(|at| float(at).is_finite())
    }
}

const fn data_type(voxel: VoxelType) -> i16 {
    match voxel {
        VoxelType::U8 => 2,
        VoxelType::I8 => 256,
        VoxelType::U16 => 512,
        VoxelType::I16 => 4,
        VoxelType::U32 => 768,
        VoxelType::I32 => 8,
        VoxelType::F32 => 16,
        VoxelType::F64 => 64,
    }
}
