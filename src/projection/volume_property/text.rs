//! 3D Slicer's older `.vp`: nine lines of numbers. Interpolation; shading; diffuse, ambient, specular and specular power; then opacity,
//! gradient opacity and colour, each as the count of its numbers and these: value and opacity, or value, red, green and blue.

use super::{GRADIENT_OPACITY, Node, Parts, Reading, Wrong, changes, check, check_count, material};

/// The property in `text`.
pub(super) fn read(text: &str) -> Result<Reading, Wrong> {
    let mut lines = text.lines();
    let lines: [Line; 9] = std::array::from_fn(|n| Line {
        number: n + 1,
        text: lines.next(),
    });
    let [_, shade, diffuse, ambient, specular, power, opacity, gradient, color] = lines;
    let numbers = [
        ambient.number()?,
        diffuse.number()?,
        specular.number()?,
        power.number()?,
    ];
    let material = match shade.number()? != 0.0 {
        true => Some(material(numbers).map_err(|reason| Wrong::at(ambient.number, reason))?),
        false => None,
    };
    let gradient: Vec<Node<1>> = gradient.nodes("gradient opacity")?;
    Parts {
        color: color.nodes("colour")?,
        opacity: opacity.nodes("opacity")?,
        // It is not in the file, and 1 where nobody says otherwise.
        unit_mm: 1.0,
        material,
        left_out: if changes(&gradient) {
            vec![GRADIENT_OPACITY]
        } else {
            Vec::new()
        },
    }
    .reading()
}

/// A line of the file.
#[derive(Clone, Copy)]
struct Line<'a> {
    number: usize,
    text: Option<&'a str>,
}

impl<'a> Line<'a> {
    fn fails(&self, reason: impl Into<String>) -> Wrong {
        Wrong::at(self.number, reason)
    }

    fn words(&self) -> Result<impl Iterator<Item = &'a str>, Wrong> {
        let missing = || self.fails("the file ends here; a .vp file has nine lines");
        Ok(self.text.ok_or_else(missing)?.split_whitespace())
    }

    fn parsed(&self, word: Option<&str>) -> Result<f64, Wrong> {
        let number = word.and_then(|word| word.parse().ok()).filter(|n: &f64| n.is_finite());
        number.ok_or_else(|| self.fails(format!("`{}` is not a finite number", word.unwrap_or_default())))
    }

    fn number(&self) -> Result<f64, Wrong> {
        self.parsed(self.words()?.next())
    }

    /// A function's nodes; equal values one after the other are a step.
    fn nodes<const N: usize>(&self, what: &str) -> Result<Vec<Node<N>>, Wrong> {
        let mut words = self.words()?;
        let count = self.parsed(words.next())?;
        let numbers = words
            .map(|word| self.parsed(Some(word)))
            .collect::<Result<Vec<_>, _>>()?;
        if count != numbers.len() as f64 || numbers.len() % (N + 1) != 0 {
            let wanted = format!(
                "{what}: the line says {count} numbers and has {}, of {} a point",
                numbers.len(),
                N + 1
            );
            return Err(self.fails(wanted));
        }
        let points = numbers.chunks_exact(N + 1);
        check_count(what, points.len()).map_err(|reason| self.fails(reason))?;
        let mut nodes: Vec<Node<N>> = Vec::with_capacity(points.len());
        for (i, point) in points.enumerate() {
            let node = Node {
                x: nodes
                    .last()
                    .filter(|last| (last.x as f32) == point[0] as f32)
                    .map_or(point[0], |last| last.x.next_up()),
                y: std::array::from_fn(|c| point[c + 1]),
                midpoint: 0.5,
                sharpness: 0.0,
            };
            check(what, i + 1, &node).map_err(|reason| self.fails(reason))?;
            nodes.push(node);
        }
        Ok(nodes)
    }
}
