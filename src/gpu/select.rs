//! Which device to use.

use std::fmt;
use std::str::FromStr;

use super::{DeviceInfo, GpuError};

/// A user's choice of device.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum DeviceSelector {
    /// The best: a discrete one before an integrated, a virtual, and the host's processor; one that lacks nothing before
    /// one that does.
    #[default]
    Default,
    /// By its place in the list.
    Index(usize),
    /// The first whose name contains this, upper and lower case alike.
    Name(String),
    /// By its UUID.
    Uuid([u8; 16]),
}

impl DeviceSelector {
    /// The device of `devices` that this selects.
    ///
    /// # Errors
    /// [`GpuError::NoDevice`] or [`GpuError::NoSuchDevice`].
    pub fn choose<'a>(&self, devices: &'a [DeviceInfo]) -> Result<&'a DeviceInfo, GpuError> {
        if devices.is_empty() {
            return Err(GpuError::NoDevice);
        }
        let chosen = match self {
            Self::Default => devices
                .iter()
                .min_by_key(|device| (!device.missing.is_empty(), device.kind)),
            Self::Index(index) => devices.get(*index),
            Self::Name(part) => devices.iter().find(|device| contains(&device.name, part)),
            Self::Uuid(uuid) => devices.iter().find(|device| device.uuid == *uuid),
        };
        chosen.ok_or_else(|| self.not_among(devices))
    }

    fn not_among(&self, devices: &[DeviceInfo]) -> GpuError {
        let found: Vec<_> = devices
            .iter()
            .map(|device| format!("{} {:?}", device.index, device.name))
            .collect();
        GpuError::NoSuchDevice {
            asked: self.to_string(),
            found: found.join(", "),
        }
    }
}

fn contains(name: &str, part: &str) -> bool {
    name.to_lowercase().contains(&part.to_lowercase())
}

impl FromStr for DeviceSelector {
    type Err = GpuError;

    /// `default`, an index, `uuid:` and 32 hexadecimal digits (dashes allowed), or a part of a name.
    fn from_str(text: &str) -> Result<Self, GpuError> {
        let bad = || GpuError::BadSelector(text.to_owned());
        if let Some(digits) = text.strip_prefix("uuid:") {
            return parse_uuid(digits).map(Self::Uuid).ok_or_else(bad);
        }
        match text.trim() {
            "" => Err(bad()),
            "default" => Ok(Self::Default),
            word => Ok(word.parse().map_or_else(|_| Self::Name(word.to_owned()), Self::Index)),
        }
    }
}

fn parse_uuid(text: &str) -> Option<[u8; 16]> {
    let digits = text.replace('-', "");
    let hexadecimal = digits.len() == 32 && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    let number = hexadecimal.then(|| u128::from_str_radix(&digits, 16).ok())?;
    number.map(u128::to_be_bytes)
}

impl fmt::Display for DeviceSelector {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Default => out.write_str("default"),
            Self::Index(index) => write!(out, "number {index}"),
            Self::Name(part) => write!(out, "named {part:?}"),
            Self::Uuid(uuid) => write!(out, "uuid:{:032x}", u128::from_be_bytes(*uuid)),
        }
    }
}
