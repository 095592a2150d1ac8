//! Rust and GLSL lay the shared structures out alike: the compiled shaders are reflected and compared.

use std::collections::{BTreeMap, BTreeSet};

use spirq::ReflectConfig;
use spirq::ty::{SpirvType, StructType, Type};
use vcsg::interface::{Layout, layouts};
use vcsg::shaders;

/// Every structure within `ty`, itself included.
fn structures(ty: &Type, found: &mut Vec<StructType>) {
    match ty {
        Type::Struct(structure) => {
            found.push(structure.clone());
            structure
                .members
                .iter()
                .for_each(|member| structures(&member.ty, found));
        }
        Type::Array(array) => structures(&array.element_ty, found),
        _ => (),
    }
}

/// The structures that a shader's uniforms, buffers and push constants are made of.
fn reflected(spirv: &[u32]) -> Vec<StructType> {
    let entry_points = ReflectConfig::new()
        .spv(spirv)
        .ref_all_rscs(true)
        .reflect()
        .expect("SPIR-V");
    let mut found = Vec::new();
    entry_points
        .iter()
        .flat_map(|entry| &entry.vars)
        .for_each(|var| structures(var.ty(), &mut found));
    found
}

fn assert_alike(rust: &Layout, glsl: &StructType) {
    let members: Vec<_> = glsl
        .members
        .iter()
        .map(|member| (member.name.as_deref(), member.offset))
        .collect();
    let expected: Vec<_> = rust
        .members
        .iter()
        .map(|member| (Some(member.name), Some(member.offset)))
        .collect();
    assert_eq!(members, expected, "members and offsets of {}", rust.name);
    assert_eq!(glsl.nbyte(), Some(rust.size), "the size of {}", rust.name);
}

#[test]
fn every_shared_structure_has_one_layout() {
    let layouts = layouts();
    let by_name: BTreeMap<_, _> = layouts.iter().map(|layout| (layout.name, layout)).collect();
    let mut seen = BTreeSet::new();
    for glsl in shaders::ALL.iter().flat_map(|shader| reflected(shader.1)) {
        if let Some(layout) = glsl.name.as_deref().and_then(|name| by_name.get(name)) {
            assert_alike(layout, &glsl);
            seen.insert(layout.name);
        }
    }
    assert_eq!(
        seen,
        by_name.keys().copied().collect(),
        "each shared structure is in a reflected shader"
    );
}
