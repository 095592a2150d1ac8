//! Scenes of several files, their limits, and a loader that is asked once.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use tempfile::TempDir;
use vcsg::math::Interval;
use vcsg::model::{Admitted, Node};
use vcsg::scene::{MAX_DEPTH, NoVolumes, Problem, Scene, SceneError, VolumeLoader, VolumeRequest};
use vcsg::volume::io::{ByteOrder, ReadOptions};
use vcsg::volume::{Bricks, Grid, Voxels};

fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    folder
}

fn load(folder: &TempDir) -> Result<Scene, SceneError> {
    Scene::load(&folder.path().join("main.kdl"), &mut NoVolumes)
}

fn parse(text: &str) -> Result<Scene, SceneError> {
    Scene::parse("test.kdl", text, Path::new("."), &mut NoVolumes)
}

#[test]
fn an_included_scene_is_one_node_and_is_read_once() {
    let folder = folder(&[
        (
            "main.kdl",
            "scene { include \"parts/a.kdl\"; translate \"9 0 0\" { include \"parts/../parts/a.kdl\" } }",
        ),
        (
            "parts/a.kdl",
            "scene { include \"b.kdl\"; define n { sphere radius=3 }; use n }\nview azimuth=50\n",
        ),
        ("parts/b.kdl", "scene { sphere radius=2 }"),
    ]);
    let scene = load(&folder).unwrap();
    // Two spheres and their union, the translation, the union of both.
    assert_eq!(scene.model.nodes().len(), 5, "{:?}", scene.model.nodes());
    assert_eq!(scene.view.azimuth_deg, 0.0, "only the tree is taken");
}

#[test]
fn includes_that_double_at_each_level_stay_small() {
    let texts: Vec<(String, String)> = (0..60)
        .map(|i| {
            let name = if i == 0 { "main.kdl".into() } else { format!("f{i}.kdl") };
            let next = format!("include \"f{}.kdl\"", i + 1);
            (name, format!("scene {{ {next}; translate \"1 0 0\" {{ {next} }} }}"))
        })
        .chain([("f60.kdl".into(), "scene { sphere radius=1 }".into())])
        .collect();
    let files: Vec<_> = texts.iter().map(|(name, text)| (&name[..], &text[..])).collect();
    assert_eq!(load(&folder(&files)).unwrap().model.nodes().len(), 121);
}

#[test]
fn a_cycle_of_includes_names_its_files() {
    let folder = folder(&[
        ("main.kdl", "scene {\n include \"a.kdl\"\n}"),
        ("a.kdl", "scene {\n  include \"b.kdl\"\n}"),
        ("b.kdl", "scene {\n   include \"a.kdl\"\n}"),
    ]);
    let error = load(&folder).unwrap_err();
    assert!(error.file().ends_with("b.kdl"), "{error}");
    assert_eq!(error.place(), Some((2, 12)));
    assert!(error.to_string().contains("a.kdl → b.kdl → a.kdl"), "{error}");
    fs::write(folder.path().join("b.kdl"), "scene { include \"main.kdl\" }").unwrap();
    let error = load(&folder).unwrap_err();
    assert!(
        error.to_string().contains("main.kdl → a.kdl → b.kdl → main.kdl"),
        "{error}"
    );
}

#[test]
fn an_error_in_an_included_file_is_placed_there() {
    let folder = folder(&[
        ("main.kdl", "scene { include \"a.kdl\" }"),
        ("a.kdl", "\nscene {\n  spere radius=1\n}"),
    ]);
    let error = load(&folder).unwrap_err();
    assert!(error.file().ends_with("a.kdl"));
    assert_eq!(error.place(), Some((3, 3)));
}

#[test]
fn includes_count_towards_the_depth() {
    let names: Vec<String> = (0..=MAX_DEPTH).map(|i| format!("f{i}.kdl")).collect();
    let mut files: Vec<(String, String)> = (0..MAX_DEPTH)
        .map(|i| (names[i].clone(), format!("scene {{ include \"{}\" }}", names[i + 1])))
        .collect();
    files.push((names[MAX_DEPTH].clone(), "scene { sphere radius=1 }".into()));
    files.push(("main.kdl".into(), "scene { include \"f0.kdl\" }".into()));
    let files: Vec<_> = files.iter().map(|(name, text)| (&name[..], &text[..])).collect();
    let error = load(&folder(&files)).unwrap_err();
    assert_eq!(*error.problem(), Problem::TooDeep { limit: MAX_DEPTH });
}

#[test]
fn a_nest_of_thirty_thousand_is_refused_with_its_place() {
    let text = "union {\n".repeat(30_000) + "sphere radius=1\n" + &"}\n".repeat(30_000);
    let error = parse(&format!("scene {{\n{text}}}\n")).unwrap_err();
    assert_eq!(*error.problem(), Problem::TooDeep { limit: MAX_DEPTH });
    // One brace is `scene`'s own, on line 1.
    assert_eq!(error.place(), Some((MAX_DEPTH + 1, 7)));
}

#[test]
fn the_deepest_nest_is_read_on_a_test_thread() {
    let levels = MAX_DEPTH - 1;
    let text = "mirror normal=\"1 0 0\" {\n".repeat(levels) + "sphere radius=1\n" + &"}\n".repeat(levels);
    let scene = parse(&format!("scene {{\n{text}}}\n")).unwrap();
    assert_eq!(scene.model.nodes().len(), MAX_DEPTH);
}

#[test]
fn fifty_thousand_siblings_are_read() {
    let text: String = (0..50_000)
        .map(|i| format!("    sphere radius=2 center=\"{i} 0 0\" // part\n"))
        .collect();
    let scene = parse(&format!("scene {{\n{text}}}\n")).unwrap();
    assert_eq!(scene.model.nodes().len(), 2 * 50_000 - 1);
}

#[test]
fn files_that_are_no_text_are_refused() {
    let folder = folder(&[("dir.kdl/x", "")]);
    let refuse = |name: &str| {
        Scene::load(&folder.path().join(name), &mut NoVolumes)
            .unwrap_err()
            .to_string()
    };
    assert!(refuse("none.kdl").contains("cannot read"), "{}", refuse("none.kdl"));
    assert!(refuse("dir.kdl").contains("cannot read"), "{}", refuse("dir.kdl"));
    fs::write(folder.path().join("bin.kdl"), [b'a', 0xff, 0xfe]).unwrap();
    assert!(
        refuse("bin.kdl").contains("byte 1 is not UTF-8"),
        "{}",
        refuse("bin.kdl")
    );
}

/// Gives an empty volume for every path that does not contain `bad`, and remembers what it was asked.
#[derive(Default)]
struct Recorder(Vec<VolumeRequest>);

impl VolumeLoader for Recorder {
    fn load(&mut self, request: &VolumeRequest) -> Result<Arc<Bricks>, String> {
        self.0.push(request.clone());
        match request.path.to_string_lossy().contains("bad") {
            true => Err(format!("{}: unknown type", request.path.display())),
            false => Ok(Arc::new(bricks())),
        }
    }
}

fn bricks() -> Bricks {
    let grid = Grid::new([1; 3], DAffine3::IDENTITY, Voxels::U8(vec![7]));
    Bricks::new(&grid.unwrap())
}

#[test]
fn a_volume_is_loaded_once_relative_to_its_file() {
    let folder = folder(&[
        (
            "main.kdl",
            "scene { volume \"a.nrrd\"; volume \"a.nrrd\" inside=\"5..\"; include \"sub/b.kdl\" }",
        ),
        (
            "sub/b.kdl",
            "scene { volume \"b.raw\" dims=\"4 5 6\" type=\"u16\" spacing=\"1 1 2\" endian=\"big\" }",
        ),
    ]);
    let mut recorder = Recorder::default();
    let scene = Scene::load(&folder.path().join("main.kdl"), &mut recorder).unwrap();
    let asked: Vec<_> = recorder.0.iter().map(|r| r.path.clone()).collect();
    assert_eq!(
        asked,
        [folder.path().join("a.nrrd"), folder.path().join("sub").join("b.raw")]
    );
    let raw = recorder.0[1].options.raw.unwrap();
    assert_eq!((raw.dims, raw.order), ([4, 5, 6], ByteOrder::Big));
    assert_eq!(raw.world_from_index, DAffine3::from_scale(DVec3::new(1.0, 1.0, 2.0)));
    let window = |node: &Node| match node {
        Node::Volume(leaf) => Some((leaf.window.lo, leaf.window.hi)),
        _ => None,
    };
    let windows: Vec<_> = scene.model.nodes().iter().filter_map(window).collect();
    assert_eq!(windows[1], (5.0, f32::INFINITY));
    assert_eq!(windows.len(), 3);
}

#[test]
fn many_masks_of_one_volume_share_its_voxels() {
    let organs: String = (1..=9)
        .map(|label| format!("volume \"ct.nrrd\" mask=\"labels.nrrd\" label={label}; "))
        .collect();
    let text = format!("scene {{ {organs} mask \"labels.nrrd\" label=\"2..4\" value=30; mask \"ct.nrrd\" }}");
    let mut recorder = Recorder::default();
    let scene = Scene::parse("t.kdl", &text, Path::new("/d"), &mut recorder).unwrap();
    assert_eq!(recorder.0.len(), 2, "each file once");
    let (mut scans, mut masks) = (Vec::new(), Vec::new());
    for node in scene.model.nodes() {
        match node {
            Node::Volume(leaf) => scans.push(&leaf.bricks),
            Node::Mask(leaf) => masks.push(leaf),
            _ => {}
        }
    }
    assert_eq!((scans.len(), masks.len()), (9, 11));
    assert!(scans.iter().all(|bricks| Arc::ptr_eq(bricks, scans[0])));
    assert!(
        masks[..10]
            .iter()
            .all(|mask| Arc::ptr_eq(&mask.bricks, &masks[0].bricks))
    );
    assert!(Arc::ptr_eq(&masks[10].bricks, scans[0]), "a scan may be a mask too");
    let three = Admitted::Within(Interval::point(3.0));
    assert_eq!((masks[2].admitted, masks[2].value), (three, 1.0));
    let window = Admitted::Within(Interval::new(2.0, 4.0));
    assert_eq!((masks[9].admitted, masks[9].value), (window, 30.0));
    assert_eq!(masks[10].admitted, Admitted::NotZero);
}

#[test]
fn a_volume_that_fails_says_where_it_was_asked_for() {
    let text = "scene {\n    volume \"bad.nrrd\"\n}";
    let error = Scene::parse("t.kdl", text, Path::new("/d"), &mut Recorder::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "t.kdl:2:12: cannot load the volume /d/bad.nrrd: unknown type"
    );
}

#[test]
fn a_bare_volume_is_a_scene() {
    let path = Path::new("/data/a \"b\".nii.gz");
    let scene = Scene::open(path, &ReadOptions::default(), &mut Recorder::default()).unwrap();
    assert_eq!(scene.model.nodes().len(), 1);
    let again = Scene::parse("again", scene.to_text(), Path::new("/"), &mut Recorder::default()).unwrap();
    assert_eq!(again.model.nodes().len(), 1);
    let error = Scene::open(Path::new("bad.nrrd"), &ReadOptions::default(), &mut Recorder::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "bad.nrrd: cannot load the volume bad.nrrd: unknown type"
    );
}

#[test]
fn every_example_of_the_document_is_a_scene() {
    let text = include_str!("../docs/SCENE.md");
    let examples: Vec<_> = text
        .split("```kdl\n")
        .skip(1)
        .map(|rest| rest.split("```").next().unwrap())
        .collect();
    assert!(examples.len() >= 5);
    for example in examples {
        Scene::parse("docs/SCENE.md", example, Path::new("."), &mut Recorder::default()).unwrap();
    }
}

#[test]
fn every_scene_of_the_assets_is_read() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/scenes");
    let scenes: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|suffix| suffix == "kdl"))
        .collect();
    assert!(scenes.len() >= 3);
    for path in scenes {
        Scene::load(&path, &mut Recorder::default()).unwrap();
    }
}

/// A grey PNG of 2 x 2 pixels.
fn grey_png(depth: png::BitDepth, color: png::ColorType, pixels: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 2);
    encoder.set_color(color);
    encoder.set_depth(depth);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(pixels).unwrap();
    writer.finish().unwrap();
    bytes
}

#[test]
fn a_picture_is_a_table_of_two_values() {
    use vcsg::model::ValueRule;
    let lut = "lut first=\"0..1\" second=\"0..1\" image=\"t.png\" values=\"-1..1\"";
    let folder = folder(&[(
        "main.kdl",
        &format!("scene {{ {lut}; sphere radius=1; sphere radius=2 }}"),
    )]);
    let grey = png::ColorType::Grayscale;
    let wide = [0u16, 65535, 13107, 0].map(u16::to_be_bytes).concat();
    for (depth, pixels) in [
        (png::BitDepth::Eight, vec![0, 255, 51, 0]),
        (png::BitDepth::Sixteen, wide),
    ] {
        fs::write(folder.path().join("t.png"), grey_png(depth, grey, &pixels)).unwrap();
        let scene = load(&folder).unwrap();
        let Some(Node::Combine(c)) = scene.model.nodes().last() else {
            panic!("{:?}", scene.model.nodes());
        };
        let ValueRule::Table(table) = &c.rule else {
            panic!("{:?}", c.rule);
        };
        assert_eq!(table.values(), [-1.0, 1.0, 0.2 - 0.8, -1.0], "the top row first");
    }
    let coloured = grey_png(png::BitDepth::Eight, png::ColorType::Rgb, &[0; 12]);
    fs::write(folder.path().join("t.png"), coloured).unwrap();
    assert!(load(&folder).unwrap_err().to_string().contains("must be a grey PNG"));
    fs::write(folder.path().join("t.png"), "no picture").unwrap();
    assert!(load(&folder).unwrap_err().to_string().contains("cannot read the table"));
}
