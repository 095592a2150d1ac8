//! Rows of times: ours, VTK's, and how many times as fast ours are.

use crate::runs::{Ratios, Summary};

/// Rows whose names are at most so many letters.
pub struct Rows(pub usize);

impl Rows {
    /// Prints the head, and what stands `behind` the times.
    pub fn head(&self, behind: &str) {
        let width = self.0;
        println!(
            "{:<width$} {:>8} {:>8} {:>8} | {:>8} {:>8} {:>8} | {:>7} {:>6} {:>6}  {:<14} | {behind}",
            "", "median", "min", "CPU", "VTK med", "min", "CPU", "median", "min", "CPU", "bar"
        );
    }

    /// Prints the row of `what`.
    pub fn print(&self, what: &str, ours: &Summary, theirs: &Summary, faster: &Ratios, bar: &str, behind: &str) {
        let width = self.0;
        let times = |s: &Summary| format!("{:8.3} {:8.3} {:8.3}", s.median_s, s.min_s, s.cpu_min_s);
        println!(
            "{what:<width$} {} | {} | {:7.2} {:6.2} {:6.2}  {bar:<14} | {behind}",
            times(ours),
            times(theirs),
            faster.median,
            faster.min,
            faster.cpu
        );
    }
}
