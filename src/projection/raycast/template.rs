//! A box's template: the pixels of a tile that it covers, and for each the interval of covered sampling points (VCSG §3.3.1,
//! figure 2).

use super::rays::{TILE, TileRays};

/// The intervals of covered sampling points of a row of a tile.
pub struct Intervals {
    /// The first covered sampling point of each pixel.
    pub begin: [i32; TILE],
    /// The first one behind the covered ones; not above `begin` where none is covered.
    pub end: [i32; TILE],
}

/// A box of the lattice as rays meet it.
pub struct Template {
    /// Its low corner.
    pub low: [f64; 3],
    /// Its high corner.
    pub high: [f64; 3],
}

impl Template {
    /// The covered sampling points of row `row` of a tile.
    #[inline(always)]
    pub fn row(&self, rays: &TileRays, row: usize) -> Intervals {
        let mut intervals = Intervals {
            begin: [0; TILE],
            end: [0; TILE],
        };
        for column in 0..TILE {
            let [enter, leave] = rays.interval(row * TILE + column, &self.low, &self.high);
            intervals.begin[column] = enter as i32;
            intervals.end[column] = leave as i32;
        }
        intervals
    }
}
