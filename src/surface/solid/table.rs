//! What each cell contributes to a combination (LC87 §5.2, figure 7).
//!
//! *Changes from the paper.* Its table is for intersection. The others follow from `A − P = A ∩ ¬P` and
//! `A ∪ P = ¬(¬A ∩ ¬P)`; triangles of P are turned over where the solid lies outside P.

/// How a scan's solid A is combined with a cutter P.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// What is in both.
    Intersection,
    /// What is in the scan's solid but not in the cutter.
    Difference,
    /// What is in either.
    Union,
}

/// One of the two sides of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Inside,
    Outside,
}

impl Operation {
    /// The side of the cutter on which the scan's surface stays.
    pub(super) fn surface_stays(self) -> Side {
        match self {
            Self::Intersection => Side::Inside,
            Self::Difference | Self::Union => Side::Outside,
        }
    }

    /// The side of the scan's surface on which the cutter's surface stays.
    pub(super) fn cutter_stays(self) -> Side {
        match self {
            Self::Intersection | Self::Difference => Side::Inside,
            Self::Union => Side::Outside,
        }
    }

    /// Whether the solid lies outside the cutter where that bounds it.
    pub(super) fn turns_cutter(self) -> bool {
        self == Self::Difference
    }

    /// Whether what is on given sides of the scan's surface and the cutter belongs to the solid.
    pub(super) fn has(self, scan: Side, cutter: Side) -> bool {
        let (scan, cutter) = (scan == Side::Inside, cutter == Side::Inside);
        match self {
            Self::Intersection => scan && cutter,
            Self::Difference => scan && !cutter,
            Self::Union => scan || cutter,
        }
    }
}

/// One bit a cell: whether it lies inside a surface, on it, or outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Relations {
    pub inside: u64,
    pub on: u64,
    pub outside: u64,
}

impl Relations {
    /// The relations of `cells` to a surface, of which some and of which all corners are inside.
    pub fn new(some: u64, all: u64, cells: u64) -> Self {
        Self {
            inside: all & cells,
            on: some & !all & cells,
            outside: !some & cells,
        }
    }

    fn on_side(&self, side: Side) -> u64 {
        match side {
            Side::Inside => self.inside,
            Side::Outside => self.outside,
        }
    }
}

/// The entries of the truth table that are not empty, one bit a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Work {
    /// Triangles of the scan's surface.
    pub surface: u64,
    /// Triangles of the cutter's surface.
    pub cutter: u64,
    /// Clipped triangles of both.
    pub both: u64,
}

impl Work {
    /// What cells with these relations to the scan's surface and the cutter's contribute.
    pub fn new(operation: Operation, scan: Relations, cutter: Relations) -> Self {
        Self {
            surface: scan.on & cutter.on_side(operation.surface_stays()),
            cutter: scan.on_side(operation.cutter_stays()) & cutter.on,
            both: scan.on & cutter.on,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cell `3 s + p` is inside, outside or on the scan's surface for `s` of 0, 1 and 2, and so for `p` with the cutter.
    fn work(operation: Operation) -> [char; 9] {
        let scan = Relations::new(0b111_000_111, 0b111, 0x1ff);
        let cutter = Relations::new(0b101_101_101, 0b001_001_001, 0x1ff);
        let work = Work::new(operation, scan, cutter);
        [0, 1, 2, 3, 4, 5, 6, 7, 8].map(|n| {
            let has = |bits: u64| bits >> n & 1 == 1;
            match (has(work.surface), has(work.cutter), has(work.both)) {
                (false, false, false) => 'x',
                (true, false, false) => 'S',
                (false, true, false) => 'P',
                (false, false, true) => '*',
                _ => '?',
            }
        })
    }

    #[test]
    fn intersection_is_the_papers_table() {
        let table = [['x', 'x', 'P'], ['x', 'x', 'x'], ['S', 'x', '*']];
        assert_eq!(work(Operation::Intersection).as_slice(), table.as_flattened());
    }

    #[test]
    fn difference_and_union_are_its_complements() {
        let difference = [['x', 'x', 'P'], ['x', 'x', 'x'], ['x', 'S', '*']];
        let union = [['x', 'x', 'x'], ['x', 'x', 'P'], ['x', 'S', '*']];
        assert_eq!(work(Operation::Difference).as_slice(), difference.as_flattened());
        assert_eq!(work(Operation::Union).as_slice(), union.as_flattened());
    }
}
