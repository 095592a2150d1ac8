//! Binary glTF 2.0: the triangles of the scene, each node's where its transforms put it.
//!
//! Format: Khronos, glTF 2.0 specification (2021). It is in metres with +Y up and +Z to the front; read are millimetres in LPS.
//! What would change the triangles and is not read is refused by name: other primitives than lists of triangles, sparse or
//! outside data, skins, required extensions.

use glam::{DAffine3, DMat3, DVec3};
use serde_json::Value;

use super::TriangleMesh;
use super::bytes::Cursor;
use super::error::Fault;
use super::gltf::Document;
use crate::math::affine;
use crate::voxelize::mesh::weld::MAX_TRIANGLES;

/// From metres, up along y and to the front along z: x is left, y posterior, z superior.
const WORLD_FROM_GLTF: DMat3 = DMat3::from_cols(
    DVec3::new(1000.0, 0.0, 0.0),
    DVec3::new(0.0, 0.0, 1000.0),
    DVec3::new(0.0, -1000.0, 0.0),
);

/// Reads a whole file.
pub fn read(file: &[u8]) -> Result<TriangleMesh, Fault> {
    let (json, binary, at) = chunks(file)?;
    let root = serde_json::from_slice(json).map_err(|error| Fault::new(format!("its JSON: {error}")).byte(20))?;
    let document = Document::new(&root, binary).map_err(|fault| fault.byte(20))?;
    let mut scene = Scene {
        document,
        mesh: TriangleMesh::default(),
    };
    scene.read().map_err(|fault| match fault.position {
        None => fault.byte(20),
        // Places in the binary data count from its beginning.
        Some(_) => fault.after(at),
    })?;
    Ok(scene.mesh)
}

/// The document, the binary data, and where that begins.
fn chunks(file: &[u8]) -> Result<(&[u8], &[u8], usize), Fault> {
    let mut cursor = Cursor::new(file);
    if cursor.take(4, "the header")? != b"glTF" {
        return Err(Fault::new("the file does not begin with `glTF`").byte(0));
    }
    let version = cursor.u32("the header")?;
    if version != 2 {
        return Err(Fault::new(format!("glTF {version} is not read, only 2")).byte(4));
    }
    let length = cursor.u32("the header")?;
    if length as usize != file.len() {
        let what = format!("{length} bytes are declared, and the file has {}", file.len());
        return Err(Fault::new(what).byte(8));
    }
    let json = chunk(&mut cursor, *b"JSON")?;
    let mut binary: &[u8] = &[];
    if cursor.left() > 0 {
        binary = chunk(&mut cursor, *b"BIN\0")?;
    }
    Ok((json, binary, cursor.at() - binary.len()))
}

fn chunk<'a>(cursor: &mut Cursor<'a>, wanted: [u8; 4]) -> Result<&'a [u8], Fault> {
    let (at, length) = (cursor.at(), cursor.u32("a chunk")?);
    if cursor.array::<4>("a chunk")? != wanted {
        let name = String::from_utf8_lossy(&wanted[..3]).into_owned();
        return Err(Fault::new(format!("the chunk is not `{name}`")).byte(at + 4));
    }
    cursor.take(length as usize, "a chunk")
}

struct Scene<'a> {
    document: Document<'a>,
    mesh: TriangleMesh,
}

impl Scene<'_> {
    fn read(&mut self) -> Result<(), Fault> {
        let mut is_seen = vec![false; self.document.count("nodes")];
        let mut waiting: Vec<(usize, DAffine3)> = Vec::new();
        let world_from_gltf = DAffine3::from_mat3(WORLD_FROM_GLTF);
        for node in self.document.scene_nodes()? {
            waiting.push((node, world_from_gltf));
        }
        while let Some((n, world_from_parent)) = waiting.pop() {
            let node = self.document.item("nodes", n)?;
            // A node has one parent, so that there are no loops.
            if std::mem::replace(&mut is_seen[n], true) {
                return Err(Fault::new(format!("node {n} has several parents")));
            }
            if node.get("skin").is_some() {
                return Err(Fault::new(format!("node {n} has a skin, which is not read")));
            }
            let world_from_node = world_from_parent * parent_from_node(node, n)?;
            for child in self.document.numbers(node, "children")? {
                waiting.push((child, world_from_node));
            }
            if let Some(mesh) = self.document.number(node, "mesh")? {
                self.read_mesh(mesh, &world_from_node)?;
            }
        }
        Ok(())
    }

    fn read_mesh(&mut self, n: usize, world_from_node: &DAffine3) -> Result<(), Fault> {
        let mesh = self.document.item("meshes", n)?;
        let primitives = mesh.get("primitives").and_then(Value::as_array);
        for primitive in primitives.into_iter().flatten() {
            self.read_primitive(primitive, n, world_from_node)?;
        }
        Ok(())
    }

    fn read_primitive(&mut self, primitive: &Value, mesh: usize, world_from_node: &DAffine3) -> Result<(), Fault> {
        let mode = self.document.number(primitive, "mode")?.unwrap_or(TRIANGLES);
        if mode != TRIANGLES {
            return Err(Fault::new(format!(
                "mesh {mesh} has primitives of mode {mode}; only triangles (4) are read"
            )));
        }
        let Some(accessor) = self.document.number(&primitive["attributes"], "POSITION")? else {
            return Ok(());
        };
        let positions = self.document.positions(accessor)?;
        let indices = match self.document.number(primitive, "indices")? {
            Some(accessor) => Some(self.document.indices(accessor)?),
            None => None,
        };
        let corners = indices.as_ref().map_or(positions.count, |indices| indices.count);
        if corners % 3 != 0 || self.mesh.triangles.len() + corners / 3 > MAX_TRIANGLES {
            let what = format!("mesh {mesh} has {corners} corners, which is no number of triangles that is read");
            return Err(Fault::new(what));
        }
        let position = |n: usize| {
            let vertex = match &indices {
                Some(indices) => indices.index(n)?,
                None => n,
            };
            Some(affine::point(world_from_node, positions.vector(vertex)?))
        };
        let outside = || Fault::new(format!("mesh {mesh} has a corner that is no vertex"));
        let mirrors = world_from_node.matrix3.determinant() < 0.0;
        for n in (0..corners).step_by(3) {
            // A node takes of a shared list of vertices what it uses: each triangle has its own.
            let order = if mirrors { [n, n + 2, n + 1] } else { [n, n + 1, n + 2] };
            let [a, b, c] = order.map(|n| position(n).ok_or_else(outside));
            let corners = [self.mesh.push(a?)?, self.mesh.push(b?)?, self.mesh.push(c?)?];
            self.mesh.triangles.push(corners);
        }
        Ok(())
    }
}

/// The mode of a list of triangles.
const TRIANGLES: usize = 4;

/// A node's `matrix`, or its `translation`, `rotation` and `scale`.
fn parent_from_node(node: &Value, n: usize) -> Result<DAffine3, Fault> {
    let bad = |key: &str| Fault::new(format!("node {n} has a `{key}` that is none"));
    let numbers = |key: &str, defaults: &[f64]| match node.get(key) {
        None => Ok(defaults.to_vec()),
        Some(value) => {
            let list = value.as_array().ok_or_else(|| bad(key))?;
            let numbers: Vec<f64> = list.iter().filter_map(Value::as_f64).collect();
            if numbers.len() == defaults.len() {
                Ok(numbers)
            } else {
                Err(bad(key))
            }
        }
    };
    if node.get("matrix").is_some() {
        let m = numbers("matrix", &[0.0; 16])?;
        if [m[3], m[7], m[11], m[15]] != [0.0, 0.0, 0.0, 1.0] {
            return Err(bad("matrix"));
        }
        let column = |n: usize| DVec3::new(m[n], m[n + 1], m[n + 2]);
        return Ok(DAffine3 {
            matrix3: DMat3::from_cols(column(0), column(4), column(8)),
            translation: column(12),
        });
    }
    let translation = DVec3::from_slice(&numbers("translation", &[0.0; 3])?);
    let scale = DVec3::from_slice(&numbers("scale", &[1.0; 3])?);
    let rotation = glam::DQuat::from_slice(&numbers("rotation", &[0.0, 0.0, 0.0, 1.0])?);
    // Of length 1 but for the digits that the file gives.
    let length = rotation.length();
    if !(0.99..1.01).contains(&length) {
        return Err(bad("rotation"));
    }
    Ok(DAffine3::from_scale_rotation_translation(
        scale,
        rotation / length,
        translation,
    ))
}
