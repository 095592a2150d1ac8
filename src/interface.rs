//! Constants and structures that Rust and GLSL share.
//!
//! Each is written once, here: the compiler sees the Rust text, and `build.rs`, which includes this file, hands the GLSL
//! text of [`glsl`] to shaders as `#include "interface.glsl"`. A test reflects the compiled shaders and compares every
//! offset and size. GLSL's std140 and std430 agree with `repr(C)` where vectors of 3 are avoided and structures are padded
//! to 16 bytes.

/// Four floats.
pub type Vec4 = [f32; 4];
/// Four unsigned integers.
pub type UVec4 = [u32; 4];

/// One member of a shared structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Member {
    /// Its name.
    pub name: &'static str,
    /// Its Rust type, as written.
    pub rust_type: &'static str,
    /// Its place, bytes.
    pub offset: usize,
}

/// A shared structure as Rust lays it out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Its name.
    pub name: &'static str,
    /// Its members in order.
    pub members: Vec<Member>,
    /// Its size, bytes.
    pub size: usize,
}

/// Declares the constants for both languages.
macro_rules! constants {
    ($($(#[$doc:meta])* pub const $constant:ident: u32 = $value:expr;)*) => {
        $($(#[$doc])* pub const $constant: u32 = $value;)*

        /// The shared constants: name and value.
        pub fn constants() -> Vec<(&'static str, u32)> {
            vec![$((stringify!($constant), $constant)),*]
        }
    };
}

/// Declares the structures for both languages.
macro_rules! structures {
    ($($(#[$doc:meta])* pub struct $name:ident { $($(#[$member_doc:meta])* pub $member:ident: $type:tt,)* })*) => {
        $(
            $(#[$doc])*
            #[repr(C)]
            #[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
            pub struct $name { $($(#[$member_doc])* pub $member: $type,)* }
        )*

        /// The shared structures in the order of their declaration.
        pub fn layouts() -> Vec<Layout> {
            vec![$(Layout {
                name: stringify!($name),
                members: vec![$(Member {
                    name: stringify!($member),
                    rust_type: stringify!($type),
                    offset: std::mem::offset_of!($name, $member),
                }),*],
                size: size_of::<$name>(),
            }),*]
        }
    };
}

constants! {
    /// The most lights of a scene.
    pub const MAX_LIGHTS: u32 = 5;
}

structures! {
    /// Where and how bright one light is.
    pub struct Light {
        /// The direction towards it in eye space, a unit vector; the last component is 0.
        pub direction: Vec4,
        /// Its colour, linear; the last component is 0.
        pub color: Vec4,
    }

    /// How a scene is lit.
    pub struct Lighting {
        /// The lights; those beyond `count` are dark.
        pub lights: [Light; MAX_LIGHTS as usize],
        /// The colour of the light from everywhere; the last component is 0.
        pub ambient: Vec4,
        /// How many lights there are, in the first component; the others are 0.
        pub count: UVec4,
    }
}

/// The GLSL text of everything shared.
pub fn glsl() -> String {
    let constants = constants()
        .into_iter()
        .map(|(name, value)| format!("const uint {name} = {value}u;\n"));
    let structures = layouts().into_iter().map(|layout| {
        let members: String = layout
            .members
            .iter()
            .map(|member| format!("    {};\n", declaration(member)))
            .collect();
        format!("struct {} {{\n{members}}};\n", layout.name)
    });
    constants.chain(structures).collect()
}

/// `vec4 color` or `Light lights[MAX_LIGHTS]`.
fn declaration(member: &Member) -> String {
    let array = member
        .rust_type
        .strip_prefix('[')
        .and_then(|rest| rest.strip_suffix(']')?.split_once(';'));
    match array {
        Some((element, count)) => {
            let count = count.trim().trim_end_matches("as usize").trim();
            format!("{} {}[{count}]", glsl_type(element.trim()), member.name)
        }
        None => format!("{} {}", glsl_type(member.rust_type), member.name),
    }
}

fn glsl_type(rust_type: &str) -> String {
    match rust_type {
        "f32" => "float".to_owned(),
        "u32" => "uint".to_owned(),
        "i32" => "int".to_owned(),
        "Vec2" | "Vec4" | "UVec4" | "IVec4" | "Mat4" => rust_type.to_lowercase(),
        structure => structure.to_owned(),
    }
}
