//! Whether two targets are one, bit for bit.

use vcsg::target::{Block, BlockVoxels, Octree, Target, Update, VoxelTarget};

use super::path::same_bits;

/// Whether an updated target with its voxels is the one that was built anew.
pub fn same(target: &Target, voxels: &[BlockVoxels], anew: &Target) -> Result<(), String> {
    let text = |found: &dyn std::fmt::Debug| format!("{found:?}");
    let octree = |t: &Target| -> Octree { t.octree.clone() };
    let described = |t: &Target| (text(&t.blocks), text(&t.value_range), t.lattice);
    if octree(target) != octree(anew) || described(target) != described(anew) {
        return Err(format!(
            "{:?} with {:?}, not {:?}",
            target.blocks, target.octree, anew.blocks
        ));
    }
    if target.paths != anew.paths {
        return Err(format!("paths {:?}, not {:?}", target.paths, anew.paths));
    }
    let truth = VoxelTarget::new(anew).voxels;
    for ((found, true_voxels), block) in voxels.iter().zip(&truth).zip(&anew.blocks) {
        same_voxels(found, true_voxels).map_err(|what| format!("{block:?}: {what}"))?;
    }
    Ok(())
}

/// Whether all that a picture of a block that is kept can depend on is as it was.
pub fn same_pictures(before: &Target, update: &Update) -> Result<(), String> {
    for (block, kept) in update.target.blocks.iter().zip(&update.kept) {
        if let Some(kept) = kept.map(|index| &before.blocks[index as usize]) {
            let was = BlockVoxels::reconstruct(before, kept, Block::REACH);
            let is = BlockVoxels::reconstruct(&update.target, block, Block::REACH);
            same_voxels(&was, &is).map_err(|what| format!("{block:?} was kept: {what}"))?;
        }
    }
    Ok(())
}

pub fn same_voxels(found: &BlockVoxels, truth: &BlockVoxels) -> Result<(), String> {
    let equal = |a: &[f32], b: &[f32]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same_bits(*a, *b));
    let [found_coverage, true_coverage] = [found, truth].map(|v| v.coverage.as_deref().unwrap_or(&[]));
    if found.dims != truth.dims || found.apron != truth.apron {
        return Err(format!("{:?} voxels, not {:?}", found.dims, truth.dims));
    }
    if !equal(&found.premultiplied, &truth.premultiplied) || !equal(found_coverage, true_coverage) {
        return Err("other voxels".into());
    }
    let colors = |v: &BlockVoxels| v.rgb().map(|rgb| rgb.as_flattened().to_vec());
    match (colors(found), colors(truth)) {
        (None, None) => {}
        (Some(a), Some(b)) if equal(&a, &b) => {}
        _ => return Err("other colours".into()),
    }
    Ok(())
}
