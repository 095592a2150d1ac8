//! Constants and structures that Rust and GLSL share.
//!
//! Each is written once, here: the compiler sees the Rust text, and `build.rs`, which includes this file, hands the GLSL
//! text of [`glsl`] to shaders as `#include "interface.glsl"`. A test reflects the compiled shaders and compares every
//! offset and size. GLSL's std140 and std430 agree with `repr(C)` where vectors of 3 are avoided and structures are padded
//! to 16 bytes.

/// Four floats.
pub type Vec4 = [f32; 4];

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
            #[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
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
    /// The most lights of a frame.
    pub const MAX_LIGHTS: u32 = 5;
    /// The most vertices of a slice polygon.
    pub const MAX_VERTICES: u32 = 6;
    /// Entries of a transfer table.
    pub const TABLE_LEN: u32 = 4096;
    /// What lets less than one part in so many of the light pass hides all that is behind it.
    pub const HIDES_ALL_BUT: u32 = 1024;
    /// Edge in pixels of the tiles of which is said whether a pixel in them is open.
    pub const OPEN_TILE: u32 = 8;
    /// Texels are values, in a lit target with normals beside them.
    pub const TEXELS_VALUES: u32 = 0;
    /// Texels are value times coverage, and coverage.
    pub const TEXELS_MIXED: u32 = 1;
    /// Texels are colour times opacity and coverage, and opacity times coverage.
    pub const TEXELS_COLORS: u32 = 2;
    /// Emission and absorption.
    pub const MODE_COMPOSITE: u32 = 0;
    /// Largest value.
    pub const MODE_MIP: u32 = 1;
    /// Smallest value.
    pub const MODE_MINIP: u32 = 2;
    /// Mean value.
    pub const MODE_AVERAGE: u32 = 3;
    /// Emission alone.
    pub const MODE_ADDITIVE: u32 = 4;
    /// Absorption alone.
    pub const MODE_XRAY: u32 = 5;
    /// A mesh is lit at its vertices.
    pub const MESH_GOURAUD: u32 = 0;
    /// A mesh is lit at each pixel.
    pub const MESH_PHONG: u32 = 1;
    /// A mesh shows its depth in millimetres.
    pub const MESH_DEPTH: u32 = 2;
    /// A triangle is lit as flat where corners without a normal weigh more than one part in so many, and where the mean normal is
    /// shorter than that.
    pub const FLAT_ABOVE: u32 = 1024;
}

structures! {
    /// All that is the same for everything of one kind in a frame.
    pub struct FrameData {
        /// The rows of the map to the eye frame, millimetres: from lattice coordinates for slices, from the world for meshes.
        pub eye_from_model: [Vec4; 3],
        /// Normalised device coordinates for each millimetre (parallel) or for each unit of slope, along x and y; then factor and
        /// summand of the depth that is tested, see `src/render/depths.rs`.
        pub lens: Vec4,
        /// Depth at which the depth cue begins, one over the depth that it spans, and its strength; then the thickness of a slab in the
        /// unit lengths that opacities of colours hold for.
        pub cue: Vec4,
        /// Ambient, diffuse and specular factors.
        pub material: Vec4,
        /// Unit vectors towards the lights in the frame of the normals, and their intensities.
        pub lights: [Vec4; MAX_LIGHTS as usize],
        /// Unit vectors half way between each light and the viewer.
        pub half_ways: [Vec4; MAX_LIGHTS as usize],
    }

    /// A drawn box.
    pub struct BoxData {
        /// Its first corner in lattice coordinates, and the depth of its nearest corner in millimetres.
        pub origin: Vec4,
        /// Its edges in lattice coordinates.
        pub size: Vec4,
        /// Texture coordinates of its first corner.
        pub texture_origin: Vec4,
        /// Texture coordinates that its edges span.
        pub texture_size: Vec4,
    }

    /// One slice polygon.
    pub struct SliceData {
        /// Index of its box.
        pub box_index: u32,
        /// Depth behind the box's nearest corner, millimetres.
        pub t_mm: f32,
        /// Index of its first moving vertex.
        pub first_vertex: u32,
    }

    /// What distinguishes one mesh from another.
    pub struct MeshData {
        /// Red, green and blue of all of it.
        pub rgb: Vec4,
    }

    /// What is pushed for a rectangle of the frame.
    pub struct RectData {
        /// Its left, top, right and bottom, in parts of the frame's width and height.
        pub ends: Vec4,
    }

    /// A polygon vertex that moves along an edge of the unit box.
    pub struct MovingVertexData {
        /// Where it is at the depth of the nearest corner.
        pub base: Vec4,
        /// How far it moves for each millimetre of depth.
        pub slope: Vec4,
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
