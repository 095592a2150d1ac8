//! Arrays in large pages.
//!
//! *Practice.* The system hands out memory page by page, each when it is first written. For an array of many megabytes that costs
//! as much as many a computation of what is written, so such an array asks for pages of 2 MiB. They are zeros to begin with, and
//! no thread has to write those. Where the system has no large pages to give, ordinary ones take their place.

use std::fmt;
use std::marker::PhantomData;
use std::ops::{Deref, DerefMut, Range};
use std::sync::Arc;

use bytemuck::Pod;
use memmap2::MmapMut;

/// Bytes of a large page.
const LARGE: usize = 2 << 20;

/// Bytes from which an array has pages of its own.
const MANY: usize = 1 << 18;

/// Values one after another, in large pages if they are many.
///
/// ```
/// use vcsg::array::Array;
///
/// let mut numbers = Array::<u32>::zeroed(3);
/// numbers[1] = 7;
/// numbers.to_mut().push(8);
/// assert_eq!(numbers, [0, 7, 0, 8]);
/// ```
pub struct Array<T> {
    /// All values, unless there are pages.
    few: Vec<T>,
    many: Option<Pages<T>>,
}

impl<T: Pod> Array<T> {
    /// `len` zeros.
    pub fn zeroed(len: usize) -> Self {
        match Pages::zeroed(len) {
            Some(pages) => Self {
                few: Vec::new(),
                many: Some(pages),
            },
            None => vec![T::zeroed(); len].into(),
        }
    }

    /// Keeps the first `len` values, if there are more.
    pub fn truncate(&mut self, len: usize) {
        match &mut self.many {
            Some(pages) => pages.truncate(len),
            None => self.few.truncate(len),
        }
    }

    /// The values as a vector, which can grow. Those in pages of their own move.
    pub fn to_mut(&mut self) -> &mut Vec<T> {
        if let Some(pages) = self.many.take() {
            self.few = pages.values().to_vec();
        }
        &mut self.few
    }
}

/// Memory of its own.
struct Pages<T> {
    map: MmapMut,
    /// The bytes of the map that hold values.
    used: Range<usize>,
    of: PhantomData<T>,
}

impl<T: Pod> Pages<T> {
    /// `len` zeros; `None` if they are few, or the system has no memory to give in this way.
    fn zeroed(len: usize) -> Option<Self> {
        let bytes = len.checked_mul(size_of::<T>())?;
        if bytes < MANY {
            return None;
        }
        let map = MmapMut::map_anon(bytes.checked_add(LARGE)?).ok()?;
        let start = map.as_ptr().align_offset(LARGE);
        // What does not fill a page stays in ordinary ones, so that no more memory is taken than is asked for.
        advise_large(&map, start..start + bytes / LARGE * LARGE);
        Some(Self {
            map,
            used: start..start + bytes,
            of: PhantomData,
        })
    }

    fn values(&self) -> &[T] {
        bytemuck::cast_slice(&self.map[self.used.clone()])
    }

    fn values_mut(&mut self) -> &mut [T] {
        bytemuck::cast_slice_mut(&mut self.map[self.used.clone()])
    }

    fn truncate(&mut self, len: usize) {
        let end = self.used.start.saturating_add(len.saturating_mul(size_of::<T>()));
        self.used.end = self.used.end.min(end);
    }
}

/// Asks for large pages. Refused, the memory is as good, but slower to get.
#[cfg(target_os = "linux")]
fn advise_large(map: &MmapMut, bytes: Range<usize>) {
    let _ = map.advise_range(memmap2::Advice::HugePage, bytes.start, bytes.len());
}

#[cfg(not(target_os = "linux"))]
fn advise_large(_: &MmapMut, _: Range<usize>) {}

impl<T: Pod> Deref for Array<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        self.many.as_ref().map_or(&self.few, Pages::values)
    }
}

impl<T: Pod> DerefMut for Array<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        self.many.as_mut().map_or(&mut self.few, Pages::values_mut)
    }
}

impl<T> Default for Array<T> {
    fn default() -> Self {
        Vec::new().into()
    }
}

impl<T> From<Vec<T>> for Array<T> {
    fn from(few: Vec<T>) -> Self {
        Self { few, many: None }
    }
}

impl<T> FromIterator<T> for Array<T> {
    fn from_iter<I: IntoIterator<Item = T>>(values: I) -> Self {
        Vec::from_iter(values).into()
    }
}

impl<'a, T: Pod> IntoIterator for &'a Array<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<T: Pod> Clone for Array<T> {
    fn clone(&self) -> Self {
        let mut clone = Self::zeroed(self.len());
        clone.copy_from_slice(self);
        clone
    }
}

impl<T: Pod + fmt::Debug> fmt::Debug for Array<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(f)
    }
}

impl<T: Pod + PartialEq, Other: AsRef<[T]> + ?Sized> PartialEq<Other> for Array<T> {
    fn eq(&self, other: &Other) -> bool {
        **self == *other.as_ref()
    }
}

impl<T: Pod> AsRef<[T]> for Array<T> {
    fn as_ref(&self) -> &[T] {
        self
    }
}

/// Values that lie in an array beside those of others, and keep it.
#[derive(Clone)]
pub struct Part<T> {
    array: Arc<Array<T>>,
    range: Range<usize>,
}

impl<T: Pod> Part<T> {
    /// The values of `array` in `range`, which it has.
    pub fn new(array: &Arc<Array<T>>, range: Range<usize>) -> Self {
        let len = array.len();
        assert!(
            range.start <= range.end && range.end <= len,
            "{range:?} of {len} values"
        );
        Self {
            array: array.clone(),
            range,
        }
    }
}

impl<T: Pod> Deref for Part<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.array[self.range.clone()]
    }
}

impl<T: Pod + fmt::Debug> fmt::Debug for Part<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(f)
    }
}

impl<T: Pod + PartialEq> PartialEq for Part<T> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lengths below and above what makes pages of their own and large ones, and the values there.
    fn arrays() -> impl Iterator<Item = (Vec<[u32; 3]>, Array<[u32; 3]>)> {
        let (many, page) = (MANY / 12, LARGE / 12);
        [0, 1, many, many + 1, page, page + 1, 2 * page, 3 * page + 5]
            .into_iter()
            .map(|len| {
                let values: Vec<_> = (0..len as u32).map(|n| [n, n + 1, 7]).collect();
                let mut array = Array::zeroed(len);
                assert!(array.iter().all(|v| *v == [0; 3]), "{len}");
                array.copy_from_slice(&values);
                (values, array)
            })
    }

    #[test]
    fn values_are_those_of_a_vector() {
        for (mut values, mut array) in arrays() {
            assert!(array == values && array.clone() == values, "{}", values.len());
            assert_eq!(array.many.is_some(), size_of_val(&values[..]) >= MANY);
            for len in [values.len() + 1, values.len() / 2, 0] {
                values.truncate(len);
                array.truncate(len);
                assert!(array == values, "cut at {len}");
            }
        }
    }

    #[test]
    fn a_vector_of_the_values_grows() {
        for (mut values, mut array) in arrays() {
            values.push([9; 3]);
            array.to_mut().push([9; 3]);
            assert!(array == values && array.many.is_none(), "{}", values.len());
        }
    }

    #[test]
    fn parts_lie_in_their_array() {
        let array = Arc::new((0..6).collect::<Array<u32>>());
        assert_eq!(Part::new(&array, 2..5).to_vec(), [2, 3, 4]);
        assert!(Part::new(&array, 6..6).is_empty());
    }
}
