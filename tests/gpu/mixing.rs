//! Blending, in values whose every product and sum is exact in 32-bit floats.

use vcsg::gpu::{Blend, Format, Load, Recording};

use crate::support::{float_target, on_device, pass, quad, quad_pipeline, shader, texels_after};

const FORMAT: Format = Format::R32G32B32A32_SFLOAT;

fn after(targets: &'static [(Format, Option<Blend>)], start: [f32; 4], colors: &[[f32; 4]]) -> [f32; 4] {
    let mut result = [f32::NAN; 4];
    on_device(|device| {
        let target = float_target(device, 4);
        let pipeline = quad_pipeline(device, shader("color.frag"), |desc| desc.color_targets = targets);
        let draws = colors.iter().map(|&color| quad(&pipeline, None, color)).collect();
        let mut recording = Recording::new();
        recording.render(pass(&target, Load::Clear(start), draws));
        let seen = texels_after::<[f32; 4]>(device, &recording, &target);
        assert!(seen.iter().all(|texel| *texel == seen[0]), "all pixels are alike");
        result = seen[0];
    });
    result
}

#[test]
fn replacing_takes_the_last() {
    assert_eq!(
        after(&[(FORMAT, None)], [9.0; 4], &[[1.0; 4], [0.5, -2.0, 3.0, 0.25]]),
        [0.5, -2.0, 3.0, 0.25]
    );
}

#[test]
fn over_is_premultiplied() {
    let colors = [[0.5, 0.25, 0.0, 0.5], [0.25, 0.0, 0.5, 0.75]];
    // (0, 0, 1, 1) → c₁ + ½t = (½, ¼, ½, 1) → c₂ + ¼t = (⅜, 1⁄16, ⅝, 1).
    assert_eq!(
        after(&[(FORMAT, Some(Blend::Over))], [0.0, 0.0, 1.0, 1.0], &colors),
        [0.375, 0.0625, 0.625, 1.0]
    );
}

#[test]
fn under_shows_where_light_still_passes() {
    let colors = [[0.5, 0.25, 0.0, 0.5], [0.25, 0.0, 0.5, 0.75]];
    // (0, 0, ½, ½) → t + ½c₁ = (¼, ⅛, ½, ¾) → t + ¼c₂ = (5⁄16, ⅛, ⅝, 15⁄16).
    assert_eq!(
        after(&[(FORMAT, Some(Blend::Under))], [0.0, 0.0, 0.5, 0.5], &colors),
        [0.3125, 0.125, 0.625, 0.9375]
    );
}

#[test]
fn adding_sums_alpha_too() {
    let colors = [[0.5, 1.0, -2.0, 0.5], [0.25, 8.0, 0.5, 0.75]];
    assert_eq!(
        after(&[(FORMAT, Some(Blend::Add))], [1.0, 0.0, 0.0, 0.5], &colors),
        [1.75, 9.0, -1.5, 1.75]
    );
}

#[test]
fn max_and_min_go_by_component() {
    let colors = [[0.5, 1.0, -2.0, 0.5], [0.25, 8.0, 0.5, 0.75]];
    assert_eq!(
        after(&[(FORMAT, Some(Blend::Max))], [0.375, 2.0, -9.0, 2.0], &colors),
        [0.5, 8.0, 0.5, 2.0]
    );
    assert_eq!(
        after(&[(FORMAT, Some(Blend::Min))], [0.375, 2.0, -1.0, 2.0], &colors),
        [0.25, 1.0, -2.0, 0.5]
    );
}

#[test]
fn draws_keep_their_order_over_many_layers() {
    // Twenty layers of alpha ½ need 21 mantissa bits: exact, and different for any other order.
    let colors: Vec<[f32; 4]> = (0..20u8)
        .map(|layer| [f32::from(layer % 2) / 2.0, 0.0, 0.0, 0.5])
        .collect();
    let expected = colors.iter().fold(0.0, |below, color| color[0] + 0.5 * below);
    let seen = after(&[(FORMAT, Some(Blend::Over))], [0.0; 4], &colors);
    assert_eq!(seen, [expected, 0.0, 0.0, 1.0 - 0.5f32.powi(20)]);
}
