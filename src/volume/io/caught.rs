//! Codecs of others that panic on damaged data, stopped at the door.
//!
//! *Practice.* Their authors did not promise never to panic, and nothing of theirs outlives the call. Rust tells of a panic on stderr
//! before anybody can catch it, unless the program's hook, which is the whole process', asks [`is_caught`] first.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    /// How many of this thread's calls would catch a panic.
    static CALLS: Cell<usize> = const { Cell::new(0) };
}

/// Counts a call for as long as it lasts.
struct Call;

impl Call {
    fn begin() -> Self {
        CALLS.set(CALLS.get() + 1);
        Self
    }
}

impl Drop for Call {
    fn drop(&mut self) {
        CALLS.set(CALLS.get() - 1);
    }
}

/// What `decode` gives, or that it gave up.
pub(super) fn caught<T>(decode: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    let _call = Call::begin();
    catch_unwind(AssertUnwindSafe(decode)).unwrap_or_else(|_| Err("its codec gave up".to_owned()))
}

/// Whether a panic on this thread is one that becomes an error of the file.
pub fn is_caught() -> bool {
    CALLS.get() > 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error() {
        assert!(!is_caught());
        assert_eq!(caught(|| Ok(is_caught())), Ok(true));
        // `resume_unwind` asks no hook, so that the test is silent.
        let nested = || caught(|| std::panic::resume_unwind(Box::new(()))).or_else(|_: String| Ok(is_caught()));
        assert_eq!(caught(nested), Ok(true));
        assert!(!is_caught());
    }
}
