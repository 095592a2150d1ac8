//! Rust and GLSL lay the shared structures out alike: the compiled shaders are reflected and compared.

use std::collections::{BTreeMap, BTreeSet};

use spirq::ReflectConfig;
use spirq::ty::{SpirvType, StructType, Type};
use vcsg::interface::{Layout, layouts};
use vcsg::shaders;

/// What a shader reads that has a layout.
#[derive(Default)]
struct Found {
    structures: Vec<StructType>,
    /// The names of arrays' elements, and the bytes from one to the next.
    strides: Vec<(String, Option<usize>)>,
}

impl Found {
    /// Adds everything within `ty`, itself included.
    fn add(&mut self, ty: &Type) {
        match ty {
            Type::Struct(structure) => {
                self.structures.push(structure.clone());
                structure.members.iter().for_each(|member| self.add(&member.ty));
            }
            Type::Array(array) => {
                if let Type::Struct(element) = &*array.element_ty {
                    self.strides
                        .push((element.name.clone().unwrap_or_default(), array.stride));
                }
                self.add(&array.element_ty);
            }
            _ => (),
        }
    }
}

/// What a shader's uniforms, buffers and push constants are made of.
fn reflected(spirv: &[u32]) -> Found {
    let config = ReflectConfig::new().spv(spirv).ref_all_rscs(true).reflect();
    let mut found = Found::default();
    let variables = config.expect("SPIR-V").into_iter().flat_map(|entry| entry.vars);
    variables.for_each(|variable| found.add(variable.ty()));
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
    for found in shaders::ALL.iter().map(|shader| reflected(shader.1)) {
        for glsl in &found.structures {
            if let Some(layout) = glsl.name.as_deref().and_then(|name| by_name.get(name)) {
                assert_alike(layout, glsl);
                seen.insert(layout.name);
            }
        }
        for (name, stride) in &found.strides {
            let size = by_name.get(name.as_str()).map(|layout| layout.size);
            assert!(size.is_none() || size == *stride, "the stride of an array of {name}");
        }
    }
    let all: BTreeSet<_> = by_name.keys().copied().collect();
    assert_eq!(seen, all, "each shared structure is in a reflected shader");
}
