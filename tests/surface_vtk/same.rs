//! Whether two meshes are one: as many vertices, and the same triangles with the same normals, in whatever order.

use std::collections::HashMap;
use std::fmt::Write;

use glam::{DAffine3, DVec3, Vec3};
use vcsg::surface::Mesh;
use vcsg::volume::Grid;

/// What normals may differ by: VTK rounds them to 32 bits, divides them by the spacing, and rounds them again.
const NORMAL: f32 = 1e-5;

/// A position by its bits; all NaN are one, and so are the two zeros.
type Place = [u32; 3];

/// A triangle by its corners' places, turned to the smallest, so that only the winding counts.
type Corners = [Place; 3];

fn place(p: [f32; 3]) -> Place {
    p.map(|x| {
        if x.is_nan() {
            f32::NAN.to_bits()
        } else {
            (x + 0.0).to_bits()
        }
    })
}

fn corners(mesh: &Mesh, n: usize) -> Corners {
    let [a, b, c] = mesh.corners(n).map(place);
    [a, b, c].min([b, c, a]).min([c, a, b])
}

/// Fails with the first difference between `ours` and `theirs`, surfaces of `grid` at `iso`.
pub fn same(grid: &Grid, iso: f64, ours: &Mesh, theirs: &Mesh) -> Result<(), String> {
    same_shape(grid, iso, ours, theirs)?;
    normals(ours, theirs)
}

/// [`same`] but for normals.
pub fn same_shape(grid: &Grid, iso: f64, ours: &Mesh, theirs: &Mesh) -> Result<(), String> {
    triangles(grid, iso, ours, theirs)?;
    let (n, m) = (finite(ours), finite(theirs));
    if n != m {
        return Err(format!("{n} vertices, and VTK has {m}"));
    }
    Ok(())
}

/// How many vertices are somewhere. VTK makes one at NaN each time it is used, so those are not compared.
fn finite(mesh: &Mesh) -> usize {
    mesh.positions
        .iter()
        .filter(|p| p.iter().all(|x| x.is_finite()))
        .count()
}

fn triangles(grid: &Grid, iso: f64, ours: &Mesh, theirs: &Mesh) -> Result<(), String> {
    let mut balance: HashMap<Corners, i64> = HashMap::new();
    for (mesh, sign) in [(ours, 1), (theirs, -1)] {
        for n in 0..mesh.triangles.len() {
            *balance.entry(corners(mesh, n)).or_default() += sign;
        }
    }
    let wrong = balance.into_iter().filter(|(_, sum)| *sum != 0).min();
    match wrong {
        None => Ok(()),
        Some((corners, sum)) => Err(explain(grid, iso, [ours, theirs], corners, sum)),
    }
}

/// The cell of a triangle that only one of the meshes has, its values, and what both make of it.
fn explain(grid: &Grid, iso: f64, meshes: [&Mesh; 2], corners: Corners, sum: i64) -> String {
    let index_from_world = grid.world_from_index().inverse();
    let cell = cell(&index_from_world, corners);
    let whose = if sum > 0 { "ours" } else { "VTK's" };
    let mut text = format!(
        "a triangle is only {whose}: {:?}\ncell {cell:?} at {iso}, values",
        corners.map(position)
    );
    for c in 0..8 {
        let at: [i64; 3] = std::array::from_fn(|a| cell[a] + (c >> a & 1));
        let inside = at.iter().zip(grid.dims()).all(|(n, dim)| (0..dim as i64).contains(n));
        let value = if inside {
            grid.value_at(at.map(|n| n as usize))
        } else {
            f64::NAN
        };
        let _ = write!(text, " {value}");
    }
    for (mesh, name) in meshes.into_iter().zip(["ours", "VTK's"]) {
        let _ = write!(text, "\n{name}:");
        for n in 0..mesh.triangles.len() {
            if self::cell(&index_from_world, self::corners(mesh, n)) == cell {
                let _ = write!(text, "\n  {:?}", mesh.corners(n));
            }
        }
    }
    text
}

/// The cell that a triangle's middle lies in.
fn cell(index_from_world: &DAffine3, corners: Corners) -> [i64; 3] {
    let middle: DVec3 = corners.map(|c| Vec3::from(position(c)).as_dvec3()).into_iter().sum();
    index_from_world
        .transform_point3(middle / 3.0)
        .floor()
        .as_i64vec3()
        .to_array()
}

fn position(place: Place) -> [f32; 3] {
    place.map(f32::from_bits)
}

fn normals(ours: &Mesh, theirs: &Mesh) -> Result<(), String> {
    let mut by_place: HashMap<Place, Vec<[f32; 3]>> = HashMap::new();
    for (p, n) in theirs.positions.iter().zip(&theirs.normals) {
        by_place.entry(place(*p)).or_default().push(*n);
    }
    for (p, n) in ours.positions.iter().zip(&ours.normals) {
        let candidates = by_place.get(&place(*p)).map_or(&[][..], Vec::as_slice);
        if p.iter().all(|x| x.is_finite()) && !candidates.iter().any(|m| like(*n, *m)) {
            return Err(format!("at {p:?} the normal is {n:?}, and VTK has {candidates:?}"));
        }
    }
    Ok(())
}

/// Whether two normals are one. Where there is no gradient ours is 0, and VTK's 0 or, where it divided by its length, NaN.
fn like(ours: [f32; 3], theirs: [f32; 3]) -> bool {
    if ours == [0.0; 3] {
        return theirs.iter().all(|x| *x == 0.0 || !x.is_finite());
    }
    ours.iter().zip(theirs).all(|(a, b)| (a - b).abs() <= NORMAL)
}
