//! Transfer-function presets for CT and MR.
