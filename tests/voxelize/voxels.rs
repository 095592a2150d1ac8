//! Voxelisation between depth buffers gives each voxel the density at its place.

use glam::{DAffine3, DVec3};
use vcsg::math::affine;
use vcsg::voxelize::Primitive;
use vcsg::voxelize::beams::Voxelizer;

use crate::cases::{KINDS, Random};

const DIMS: [usize; 3] = [40, 36, 30];

fn lattice(random: &mut Random) -> DAffine3 {
    let middle = DVec3::from_array(DIMS.map(|n| 0.5 * n as f64));
    random.pose() * DAffine3::from_translation(-middle)
}

#[test]
fn each_voxel_has_the_density_at_its_place() {
    for (name, make) in KINDS {
        for seed in 0..6 {
            let mut random = Random(1000 + seed);
            let whole = Primitive::soft(make(&mut random).solid, 1.0);
            let primitive = match seed % 2 {
                0 => whole.clone().shell(random.within(0.5, 5.0)).unwrap_or(whole),
                _ => whole,
            };
            let placed = primitive.placed(&DAffine3::IDENTITY, 1.0);
            let world_from_lattice = lattice(&mut random);
            let voxelizer = Voxelizer::new(&placed, DIMS, &world_from_lattice);
            let densities = voxelizer.voxelize();
            let local_from_lattice = placed.local_from_world * world_from_lattice;
            for (n, density) in densities.iter().enumerate() {
                let at = [n % DIMS[0], n / DIMS[0] % DIMS[1], n / (DIMS[0] * DIMS[1])];
                let local = affine::point(&local_from_lattice, DVec3::from_array(at.map(|i| i as f64)));
                assert_eq!(*density, placed.coverage(local), "{name} {seed} at {at:?}");
            }
        }
    }
}
