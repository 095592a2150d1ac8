//! The `gpu` module on the device at hand, under the validation layer: any message fails a test.

mod bounds;
mod copies;
mod depths;
mod devices;
mod draws;
mod mixing;
mod order;
mod stores;
mod support;
