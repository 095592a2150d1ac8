//! Volume files.
