//! What is refused, and what the message says.

use tempfile::tempdir;
use vcsg::volume::io;

use crate::file::{EXPLICIT, Elements, File, JPEG_LS, RLE, Value};

/// What spoils a slice, and what the message says of it.
type Case<'a> = (&'a dyn Fn(&mut File), &'a str);

/// The message for a slice that `change` spoils.
fn refusal(change: impl Fn(&mut File)) -> String {
    let folder = tempdir().unwrap();
    let mut file = File::slice(1, 0.0);
    change(&mut file);
    let path = file.write(folder.path(), "bad.dcm");
    let message = io::read(&path).expect_err("it is refused").to_string();
    assert!(message.contains("bad.dcm"), "{message}");
    message
}

#[test]
fn bad_files_are_refused_with_what_is_wrong() {
    let cases: [Case; 14] = [
        (
            &|f| f.text((0x8, 0x8), "CS", "ORIGINAL\\PRIMARY\\M\\MOSAIC"),
            "Siemens mosaic",
        ),
        (
            &|f| f.frames[0].truncate(20),
            "declares 24 bytes of data, the file has 20",
        ),
        (&|f| f.us((0x28, 0x10), 65535), "declares 524280 bytes"),
        (&|f| f.text((0x28, 0x8), "IS", "100000"), "declares 2400000 bytes"),
        (
            &|f| f.text((0x28, 0x8), "IS", "2147483647"),
            "2147483647 frames are not believed",
        ),
        (&|f| f.us((0x28, 0x10), 0), "4 columns and 0 rows"),
        (&|f| f.us((0x28, 0x100), 12), "samples of 12 bits"),
        (&|f| f.us((0x28, 0x2), 5), "pixels of 5 samples"),
        (&|f| f.syntax = "1.2.840.10008.1.2.4.100", "1.2.840.10008.1.2.4.100"),
        (&|f| f.syntax = "1.2.3.4", "`1.2.3.4` is not known"),
        (
            &|f| f.text((0x20, 0x37), "DS", "1\\0\\0\\1\\0\\0"),
            "do not span a plane",
        ),
        (&|f| f.text((0x28, 0x30), "DS", "1e-300\\1e-300"), "singular"),
        (&|f| f.syntax = RLE, "cannot be decompressed"),
        (&|f| f.syntax = JPEG_LS, "cannot be decompressed"),
    ];
    for (change, part) in cases {
        let message = refusal(change);
        assert!(message.contains(part), "{part}: {message}");
    }
}

#[test]
fn a_stream_of_another_size_is_refused_before_it_is_decoded() {
    let message = refusal(|f| {
        f.syntax = JPEG_LS;
        let info = charls::FrameInfo {
            width: 4000,
            height: 4000,
            bits_per_sample: 8,
            component_count: 1,
        };
        f.frames = vec![charls::CharLS::default().encode(info, 0, &vec![0; 16_000_000]).unwrap()];
    });
    assert!(
        message.contains("4000 x 4000 x 1, its header says 4 x 3 x 1"),
        "{message}"
    );
}

#[test]
fn compressed_pixels_that_cannot_fill_the_image_are_refused() {
    let message = refusal(|f| {
        f.syntax = RLE;
        f.us((0x28, 0x10), 10_000);
        f.us((0x28, 0x11), 10_000);
    });
    assert!(message.contains("more than 24 compressed bytes can hold"), "{message}");
}

#[test]
fn sequences_nest_only_so_deep() {
    let nested = |inner| Elements::from([((0x9, 0x1001), Value::Items(vec![inner]))]);
    let message = refusal(|f| {
        let deep = (0..200).fold(Elements::new(), |inner, _| nested(inner));
        f.elements.extend(deep);
        f.syntax = EXPLICIT;
    });
    assert!(message.contains("nest more than 64 deep"), "{message}");
}
