//! Compiles the shaders to SPIR-V and writes a Rust module with a constant for each.

use std::path::{Path, PathBuf};
use std::{env, fs};

#[path = "src/interface.rs"]
mod interface;

fn main() {
    println!("cargo::rerun-if-changed=src/interface.rs");
    let folders = [
        ("shaders", "shaders.rs"),
        ("tests/shaders", "test_shaders.rs"),
        ("benches/shaders", "bench_shaders.rs"),
    ];
    let result = folders
        .into_iter()
        .try_for_each(|(folder, module)| compile_folder(folder, module));
    if let Err(text) = result {
        text.lines().for_each(|line| println!("cargo::error={line}"));
    }
}

/// Compiles every shader of `folder` into the Rust module `module` of OUT_DIR: a constant each, and a list of all.
fn compile_folder(folder: &str, module: &str) -> Result<(), String> {
    println!("cargo::rerun-if-changed={folder}");
    let (mut text, mut list) = (String::new(), String::new());
    for path in shaders_in(Path::new(folder))? {
        let (file, name) = names(&path)?;
        text += &constant(&path, &name, &compile(&path)?);
        list += &format!("({file:?}, {name}), ");
    }
    text +=
        &format!("/// Every shader: its file's name and its SPIR-V.\npub const ALL: &[(&str, &[u32])] = &[{list}];\n");
    let out = env::var("OUT_DIR").map_err(|error| format!("OUT_DIR: {error}"))?;
    let out = Path::new(&out).join(module);
    fs::write(&out, text).map_err(|error| format!("{}: {error}", out.display()))
}

/// The shaders of a folder in the order of their names; none if there is no folder.
fn shaders_in(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Ok(Vec::new());
    };
    let paths: Result<Vec<_>, _> = entries.map(|entry| entry.map(|entry| entry.path())).collect();
    let mut paths = paths.map_err(|error| format!("{}: {error}", folder.display()))?;
    paths.retain(|path| stage(path).is_some());
    paths.sort();
    Ok(paths)
}

fn stage(path: &Path) -> Option<shaderc::ShaderKind> {
    match path.extension()?.to_str()? {
        "vert" => Some(shaderc::ShaderKind::Vertex),
        "frag" => Some(shaderc::ShaderKind::Fragment),
        "comp" => Some(shaderc::ShaderKind::Compute),
        _ => None,
    }
}

fn compile(path: &Path) -> Result<Vec<u32>, String> {
    let name = path.display().to_string();
    let source = fs::read_to_string(path).map_err(|error| format!("{name}: {error}"))?;
    let kind = stage(path).ok_or_else(|| format!("{name}: not a shader"))?;
    let compiler = shaderc::Compiler::new().map_err(|error| error.to_string())?;
    let options = options().map_err(|error| error.to_string())?;
    let spirv = compiler.compile_into_spirv(&source, kind, &name, "main", Some(&options));
    spirv
        .map(|spirv| spirv.as_binary().to_vec())
        .map_err(|error| error.to_string())
}

fn options() -> Result<shaderc::CompileOptions<'static>, shaderc::Error> {
    let mut options = shaderc::CompileOptions::new()?;
    options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_3 as u32);
    options.set_optimization_level(shaderc::OptimizationLevel::Performance);
    // Keeps the names, by which a test finds the shared structures; devices skip them.
    options.set_generate_debug_info();
    options.set_warnings_as_errors();
    options.set_include_callback(|wanted, _, from, _| include(wanted).map_err(|error| format!("{from}: {error}")));
    Ok(options)
}

/// What `#include "wanted"` stands for: the generated interface, or a file of `shaders/include`.
fn include(wanted: &str) -> Result<shaderc::ResolvedInclude, String> {
    let path = Path::new("shaders/include").join(wanted);
    let content = match wanted {
        "interface.glsl" => interface::glsl(),
        _ => fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?,
    };
    Ok(shaderc::ResolvedInclude {
        resolved_name: path.display().to_string(),
        content,
    })
}

/// `slices.vert` and `SLICES_VERT`.
fn names(path: &Path) -> Result<(String, String), String> {
    let file = path
        .file_name()
        .and_then(|name| name.to_str())
        .ok_or_else(|| format!("{}: odd name", path.display()))?;
    Ok((file.to_owned(), file.replace(['.', '-'], "_").to_uppercase()))
}

fn constant(path: &Path, name: &str, spirv: &[u32]) -> String {
    let words: String = spirv.iter().map(|word| format!("{word:#x},")).collect();
    format!(
        "/// The SPIR-V of `{}`.\npub const {name}: &[u32] = &[{words}];\n",
        path.display()
    )
}
