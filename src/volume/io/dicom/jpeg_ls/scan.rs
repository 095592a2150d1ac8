//! A scan's lines, of one component or of several.

use super::bits::{Bits, Damaged};
use super::contexts::{REGULAR, Regular, RunEnd};
use super::parameters::Parameters;

/// Bits of a run's length, as runs get longer (A.2.1, J).
const RUN_BITS: [u32; 32] = [
    0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7, 8, 9, 10, 11, 12, 13, 14, 15,
];

/// A line, with a sample more at either end.
type Line = Vec<i32>;

/// What decodes the lines of a scan.
pub(super) struct Scan<'a> {
    pub bits: Bits<'a>,
    parameters: &'a Parameters,
    regular: Vec<Regular>,
    run_ends: [RunEnd; 2],
    /// Which of [`RUN_BITS`] the next run has, in lines of each component.
    run_indices: Vec<usize>,
    /// The lines above and those in hand, of each component.
    above: Vec<Line>,
    here: Vec<Line>,
}

impl<'a> Scan<'a> {
    /// Of lines of so many samples of each of `components`.
    pub(super) fn new(bits: Bits<'a>, parameters: &'a Parameters, width: usize, components: usize) -> Self {
        let lines = vec![vec![0; width + 2]; components];
        Self {
            bits,
            parameters,
            regular: vec![Regular::new(parameters); REGULAR],
            run_ends: [0, 1].map(|kind| RunEnd::new(kind, parameters)),
            run_indices: vec![0; components],
            above: lines.clone(),
            here: lines,
        }
    }

    /// The next line of each component, one after the other.
    pub(super) fn by_line(&mut self) -> Result<impl Iterator<Item = &[i32]>, Damaged> {
        self.begin();
        for component in 0..self.here.len() {
            self.line(component)?;
        }
        Ok(self.lines())
    }

    /// The same, whose samples of a pixel are together.
    pub(super) fn by_sample(&mut self) -> Result<impl Iterator<Item = &[i32]>, Damaged> {
        self.begin();
        let end = self.here[0].len() - 1;
        let mut x = 1;
        while x < end {
            match (0..self.here.len()).all(|c| self.is_flat(c, x)) {
                true => x = self.run_of_pixels(x, end)?,
                false => {
                    for component in 0..self.here.len() {
                        self.sample(component, x)?;
                    }
                    x += 1;
                }
            }
        }
        Ok(self.lines())
    }

    fn lines(&self) -> impl Iterator<Item = &[i32]> {
        self.here.iter().map(|line| &line[1..line.len() - 1])
    }

    /// Goes on to the next line: to the left of it is what was above that, to the right above what was last.
    fn begin(&mut self) {
        std::mem::swap(&mut self.above, &mut self.here);
        for (above, here) in self.above.iter_mut().zip(&mut self.here) {
            let last = above.len() - 1;
            above[last] = above[last - 1];
            here[0] = above[1];
        }
    }

    fn line(&mut self, component: usize) -> Result<(), Damaged> {
        let end = self.here[component].len() - 1;
        let mut x = 1;
        while x < end {
            match self.is_flat(component, x) {
                true => x = self.run(component, x, end)?,
                false => {
                    self.sample(component, x)?;
                    x += 1;
                }
            }
        }
        Ok(())
    }

    /// The samples to the left, above, above to the left and above to the right.
    #[inline]
    fn around(&self, component: usize, x: usize) -> [i32; 4] {
        let (above, here) = (&self.above[component], &self.here[component]);
        [here[x - 1], above[x], above[x - 1], above[x + 1]]
    }

    #[inline]
    fn is_flat(&self, component: usize, x: usize) -> bool {
        let [a, b, c, d] = self.around(component, x);
        [d - b, b - c, c - a].iter().all(|g| g.abs() <= self.parameters.near)
    }

    /// A sample by its context (A.4 to A.6).
    #[inline]
    fn sample(&mut self, component: usize, x: usize) -> Result<(), Damaged> {
        let [a, b, c, d] = self.around(component, x);
        let level = |gradient| self.parameters.quantized(gradient);
        let context = 81 * level(d - b) + 9 * level(b - c) + level(c - a);
        let sign = if context < 0 { -1 } else { 1 };
        // The median of both and of the plane through all three.
        let edge = (a + b - c).clamp(a.min(b), a.max(b));
        let context = &mut self.regular[context.unsigned_abs() as usize];
        let prediction = (edge + sign * context.correction).clamp(0, self.parameters.most);
        let error = sign * context.error(&mut self.bits, self.parameters)?;
        self.here[component][x] = self.parameters.sample(prediction, error);
        Ok(())
    }

    /// How many samples the next run has, `left` at most (A.7.1).
    fn run_length(&mut self, component: usize, left: usize) -> Result<usize, Damaged> {
        let index = &mut self.run_indices[component];
        let mut length = 0;
        while self.bits.number(1)? == 1 {
            let whole = 1 << RUN_BITS[*index];
            if whole <= left - length {
                *index = (*index + 1).min(31);
            }
            length = left.min(length + whole);
            if length == left {
                return Ok(length);
            }
        }
        length += self.bits.number(RUN_BITS[*index])? as usize;
        if length < left { Ok(length) } else { Err(Damaged) }
    }

    /// A run and the sample that ends it, unless the line does; where the line goes on.
    fn run(&mut self, component: usize, from: usize, end: usize) -> Result<usize, Damaged> {
        let x = from + self.run_length(component, end - from)?;
        let value = self.here[component][from - 1];
        self.here[component][from..x].fill(value);
        if x == end {
            return Ok(end);
        }
        let above = self.above[component][x];
        let is_alike = (value - above).abs() <= self.parameters.near;
        let context = &mut self.run_ends[usize::from(is_alike)];
        let run_bits = RUN_BITS[self.run_indices[component]];
        let error = context.error(&mut self.bits, self.parameters, run_bits)?;
        self.here[component][x] = match is_alike {
            true => self.parameters.sample(value, error),
            false => self.after_run(value, above, error),
        };
        self.run_indices[component] = self.run_indices[component].saturating_sub(1);
        Ok(x + 1)
    }

    /// A sample that ends a run of `value` under another one.
    fn after_run(&self, value: i32, above: i32, error: i32) -> i32 {
        let sign = if above < value { -1 } else { 1 };
        self.parameters.sample(above, sign * error)
    }

    /// A run of all components, which ends for all at one pixel.
    fn run_of_pixels(&mut self, from: usize, end: usize) -> Result<usize, Damaged> {
        let x = from + self.run_length(0, end - from)?;
        for line in &mut self.here {
            let value = line[from - 1];
            line[from..x].fill(value);
        }
        if x == end {
            return Ok(end);
        }
        let run_bits = RUN_BITS[self.run_indices[0]];
        for component in 0..self.here.len() {
            let (value, above) = (self.here[component][x - 1], self.above[component][x]);
            let error = self.run_ends[0].error(&mut self.bits, self.parameters, run_bits)?;
            self.here[component][x] = self.after_run(value, above, error);
        }
        self.run_indices[0] = self.run_indices[0].saturating_sub(1);
        Ok(x + 1)
    }
}
