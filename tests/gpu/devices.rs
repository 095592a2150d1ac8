//! Finding, choosing and refusing devices.

use vcsg::gpu::{Device, DeviceInfo, DeviceSelector, Format, GpuError, Requirements};

use crate::support::{REQUIREMENTS, on_device};

fn chosen<'a>(devices: &'a [DeviceInfo], text: &str) -> Result<&'a DeviceInfo, GpuError> {
    text.parse::<DeviceSelector>()?.choose(devices)
}

#[test]
fn a_device_is_chosen_by_index_name_and_uuid() {
    on_device(|device| {
        let devices = device.instance().devices(&REQUIREMENTS).expect("a list");
        let first = &devices[0];
        assert_eq!(chosen(&devices, "0"), Ok(first));
        assert_eq!(chosen(&devices, &first.name.to_uppercase()), Ok(first));
        assert_eq!(chosen(&devices, &format!("uuid:{}", first.uuid_text())), Ok(first));
        assert_eq!(chosen(&devices, "default").map(|device| device.missing.len()), Ok(0));
        let error = chosen(&devices, "no such thing")
            .expect_err("nobody is called so")
            .to_string();
        assert!(
            error.contains("no such thing") && error.contains(&first.name),
            "{error}"
        );
        assert!(chosen(&devices, "99").is_err());
        assert!(matches!(chosen(&devices, "uuid:12"), Err(GpuError::BadSelector(_))));
        assert_eq!(chosen(&[], "0"), Err(GpuError::NoDevice));
    });
}

#[test]
fn a_device_that_lacks_something_is_refused_by_its_name() {
    on_device(|device| {
        let needs = Requirements {
            sampled_linear: &[Format::R8_UNORM, Format::R32_UINT],
            blended: &[Format::BC1_RGBA_UNORM_BLOCK],
            image_dimension_3d: 1 << 20,
            ..REQUIREMENTS
        };
        let refused = Device::open(device.instance(), &DeviceSelector::Default, &needs);
        let Some(GpuError::Lacking { missing, .. }) = refused.err() else {
            panic!("no device has all of this")
        };
        let has = device.info().limits.image_dimension_3d;
        assert_eq!(
            missing.first(),
            Some(&format!("maxImageDimension3D 1048576 (it has {has})"))
        );
        assert!(
            missing.contains(&"linear filtering of R32_UINT".to_owned()),
            "{missing:?}"
        );
        assert!(
            missing.contains(&"blending of BC1_RGBA_UNORM_BLOCK".to_owned()),
            "{missing:?}"
        );
        assert!(!missing.iter().any(|lack| lack.contains("R8_UNORM")), "{missing:?}");
    });
}

#[test]
fn a_device_says_what_it_is() {
    on_device(|device| {
        let info = device.info();
        assert!(!info.name.is_empty() && !info.driver.is_empty() && info.api_version.starts_with("1."));
        assert!(info.limits.image_dimension_3d >= 2048 && info.limits.push_bytes >= 128);
        assert_eq!(info.uuid_text().len(), 36);
    });
}
