//! One node of a scene file, held against the grammar and read in the types that the tree needs.

use glam::DVec3;
use kdl::{KdlEntry, KdlNode, KdlValue};
use miette::SourceSpan;

use super::error::{Problem, SceneError};
use super::grammar::{self, Children, Rule};
use super::source::Source;
use super::suggest::nearest;

type Result<T> = std::result::Result<T, SceneError>;

/// A node that its rule allows: known properties, each at most once, and the right number of arguments.
#[derive(Clone, Copy)]
pub(super) struct Element<'a> {
    node: &'a KdlNode,
    rule: &'static Rule,
    source: &'a Source,
}

impl<'a> Element<'a> {
    /// The node, if one of `groups` knows it.
    pub fn new(node: &'a KdlNode, groups: &[&'static [Rule]], source: &'a Source) -> Result<Self> {
        let name = node.name().value();
        let mut rules = groups.iter().flat_map(|group| group.iter());
        let Some(rule) = rules.clone().find(|rule| rule.name == name) else {
            let known: Vec<_> = rules.by_ref().map(|rule| rule.name).collect();
            let problem = Problem::UnknownNode {
                found: name.into(),
                nearest: nearest(name, &known),
                known,
            };
            return Err(SceneError::at(source, node.name().span(), problem));
        };
        let element = Self { node, rule, source };
        element.check_properties()?;
        element.check_arguments()?;
        element.check_children()?;
        Ok(element)
    }

    fn check_properties(&self) -> Result<()> {
        let named = |e: &'a KdlEntry| e.name().map(|name| (e, name.value()));
        let entries = self.node.entries();
        for (i, (entry, name)) in entries.iter().enumerate().filter_map(|(i, e)| Some((i, named(e)?))) {
            let known = self.rule.properties;
            if !known.contains(&name) {
                let problem = Problem::UnknownProperty {
                    node: self.rule.name,
                    found: name.into(),
                    nearest: nearest(name, known),
                    known,
                };
                return Err(self.error_at(entry, problem));
            }
            // At most as many known properties as the rule has can come before the second of a kind: no quadratic cost.
            if entries[..i]
                .iter()
                .filter_map(named)
                .any(|(_, earlier)| earlier == name)
            {
                return Err(self.error_at(entry, Problem::Twice { name: name.into() }));
            }
        }
        Ok(())
    }

    fn check_arguments(&self) -> Result<()> {
        let found = self.arguments().count();
        if found == self.rule.arguments {
            return Ok(());
        }
        let problem = Problem::Arguments {
            node: self.rule.name,
            wanted: self.rule.arguments,
            found,
            example: self.rule.example,
        };
        match self.arguments().nth(self.rule.arguments) {
            Some(surplus) => Err(self.error_at(surplus, problem)),
            None => Err(self.error(problem)),
        }
    }

    fn check_children(&self) -> Result<()> {
        if self.rule.children != Children::None || self.node.children().is_none() {
            return Ok(());
        }
        let node = self.rule.name;
        Err(self.error(Problem::NoChildren { node }))
    }

    pub fn name(&self) -> &'static str {
        self.rule.name
    }

    pub fn source(&self) -> &'a Source {
        self.source
    }

    /// The children, each held against the grammar.
    pub fn children(&self) -> impl Iterator<Item = Result<Element<'a>>> + use<'a> {
        let groups = grammar::inside(self.rule.children);
        let source = self.source;
        let nodes = self.node.children().map_or(&[][..], |document| document.nodes());
        nodes.iter().map(move |node| Element::new(node, groups, source))
    }

    /// The line of the node's name, from 1.
    pub fn line(&self) -> usize {
        self.source.place(self.node.name().span().offset()).0
    }

    /// An error at the node's name.
    pub fn error(&self, problem: Problem) -> SceneError {
        SceneError::at(self.source, self.node.name().span(), problem)
    }

    fn error_at(&self, entry: &KdlEntry, problem: Problem) -> SceneError {
        SceneError::at(self.source, entry.span(), problem)
    }

    /// An error at property `key`, or at the node when it has none.
    pub fn error_of(&self, key: &str, problem: Problem) -> SceneError {
        let span = self.find(key).map_or_else(|| self.node.name().span(), KdlEntry::span);
        SceneError::at(self.source, span, problem)
    }

    /// An error at argument `index`.
    pub fn error_of_argument(&self, index: usize, problem: Problem) -> SceneError {
        let entry = self.arguments().nth(index);
        SceneError::at(self.source, entry.map_or_else(|| self.span(), KdlEntry::span), problem)
    }

    fn span(&self) -> SourceSpan {
        self.node.name().span()
    }

    fn arguments(&self) -> impl Iterator<Item = &'a KdlEntry> + use<'a> {
        self.node.entries().iter().filter(|e| e.name().is_none())
    }

    fn find(&self, key: &str) -> Option<&'a KdlEntry> {
        debug_assert!(self.rule.properties.contains(&key), "{key} is not in the grammar");
        let is_key = |e: &&KdlEntry| e.name().is_some_and(|name| name.value() == key);
        self.node.entries().iter().find(is_key)
    }

    /// Whether nodes of this kind may have property `key`.
    pub fn allows(&self, key: &str) -> bool {
        self.rule.properties.contains(&key)
    }

    /// Property `key`, if it is there.
    pub fn get(&self, key: &'static str) -> Option<Value<'a>> {
        self.find(key).map(|entry| Value {
            entry,
            name: key,
            source: self.source,
        })
    }

    /// Property `key`, which must be there.
    pub fn require(&self, key: &'static str) -> Result<Value<'a>> {
        let node = self.rule.name;
        let missing = || self.error(Problem::MissingProperty { node, property: key });
        self.get(key).ok_or_else(missing)
    }

    /// Argument `index`, counted from 0, below the rule's number of arguments.
    pub fn argument(&self, index: usize) -> Value<'a> {
        let entry = self.arguments().nth(index).expect("the number of arguments is checked");
        Value {
            entry,
            name: self.rule.name,
            source: self.source,
        }
    }
}

/// A property's value or an argument.
#[derive(Clone, Copy)]
pub(super) struct Value<'a> {
    entry: &'a KdlEntry,
    name: &'static str,
    source: &'a Source,
}

impl<'a> Value<'a> {
    /// An error: this value is not what is `wanted`.
    pub fn bad(&self, wanted: impl Into<String>) -> SceneError {
        let problem = Problem::BadValue {
            name: self.name.into(),
            found: self.entry.value().to_string(),
            wanted: wanted.into(),
        };
        self.error(problem)
    }

    /// An error at this value.
    pub fn error(&self, problem: Problem) -> SceneError {
        SceneError::at(self.source, self.entry.span(), problem)
    }

    /// The value as it is.
    pub fn value(&self) -> &'a KdlValue {
        self.entry.value()
    }

    /// Any finite number.
    pub fn number(self) -> Result<f64> {
        let number = match self.entry.value() {
            KdlValue::Integer(i) => *i as f64,
            KdlValue::Float(f) => *f,
            _ => f64::NAN,
        };
        if number.is_finite() {
            Ok(number)
        } else {
            Err(self.bad("a finite number"))
        }
    }

    /// A finite number that single precision holds.
    pub fn single(self) -> Result<f32> {
        let single = self.number()? as f32;
        if single.is_finite() {
            Ok(single)
        } else {
            Err(self.bad("at most 3.4e38 in size"))
        }
    }

    /// A number above 0.
    pub fn positive(self) -> Result<f64> {
        let number = self.number()?;
        if number > 0.0 {
            Ok(number)
        } else {
            Err(self.bad("above 0"))
        }
    }

    /// A number in the closed range `lo..hi`.
    pub fn within(self, lo: f64, hi: f64) -> Result<f64> {
        let number = self.number()?;
        if (lo..=hi).contains(&number) {
            Ok(number)
        } else {
            Err(self.bad(format!("in {lo}..{hi}")))
        }
    }

    /// A whole number in the closed range `lo..hi`.
    pub fn whole(self, lo: u32, hi: u32) -> Result<u32> {
        match self.entry.value() {
            KdlValue::Integer(i) if (lo.into()..=hi.into()).contains(i) => Ok(*i as u32),
            _ => Err(self.bad(format!("a whole number in {lo}..{hi}"))),
        }
    }

    /// `#true` or `#false`.
    pub fn boolean(self) -> Result<bool> {
        self.entry.value().as_bool().ok_or_else(|| self.bad("#true or #false"))
    }

    /// A string.
    pub fn string(self) -> Result<&'a str> {
        self.entry.value().as_string().ok_or_else(|| self.bad("a string"))
    }

    /// Exactly `N` finite numbers in a string, parted by spaces or commas.
    pub fn numbers<const N: usize>(self) -> Result<[f64; N]> {
        let bad = || self.bad(format!("a string of {N} finite numbers"));
        let text = self.entry.value().as_string().ok_or_else(bad)?;
        let words = text.split([' ', '\t', '\n', ',']).filter(|word| !word.is_empty());
        let mut numbers = [f64::NAN; N];
        let mut count = 0;
        for word in words {
            let number: f64 = word.parse().map_err(|_| bad())?;
            *numbers.get_mut(count).ok_or_else(bad)? = number;
            count += 1;
        }
        if count == N && numbers.iter().all(|n| n.is_finite()) {
            Ok(numbers)
        } else {
            Err(bad())
        }
    }

    /// Any number of finite numbers in a string, parted by spaces or commas.
    pub fn row(self) -> Result<Vec<f32>> {
        let words = self
            .string()?
            .split([' ', '\t', '\n', ','])
            .filter(|word| !word.is_empty());
        let finite = |word: &str| word.parse().ok().filter(|n: &f32| n.is_finite());
        let numbers: Option<Vec<f32>> = words.map(finite).collect();
        numbers.ok_or_else(|| self.bad("a string of finite numbers"))
    }

    /// Three finite numbers in a string.
    pub fn vector(self) -> Result<DVec3> {
        self.numbers().map(DVec3::from_array)
    }

    /// A vector longer than 0, made one long.
    pub fn direction(self) -> Result<DVec3> {
        self.vector()?
            .try_normalize()
            .ok_or_else(|| self.bad("a direction, not of length 0"))
    }

    /// What `choices` gives for the string.
    pub fn one_of<T: Clone>(self, choices: &[(&'static str, T)]) -> Result<T> {
        let found = self.entry.value().as_string().unwrap_or_default();
        let choice = choices.iter().find(|(name, _)| *name == found);
        choice.map(|(_, value)| value.clone()).ok_or_else(|| {
            let names: Vec<_> = choices.iter().map(|(name, _)| *name).collect();
            self.bad(format!("one of {}", names.join(", ")))
        })
    }

    /// `"#rrggbb"` as display-referred RGB in [0, 1].
    pub fn color(self) -> Result<[f32; 3]> {
        crate::projection::rgb_from_hex(self.string()?).ok_or_else(|| self.bad("a colour like \"#f0e0d0\""))
    }
}
