//! What can be wrong with a scene file, and where: the one place that knows how errors are shown.

use std::fmt;
use std::path::PathBuf;

use miette::{Diagnostic, LabeledSpan, SourceCode, SourceSpan};

use super::source::Source;
use crate::model::LutError;
use crate::projection::TransferError;
use crate::projection::trace::{OpticsError, SourceError};

/// Why a scene cannot be read: a [`Problem`] and the place that has it.
///
/// Shown plainly it is one line, `file:line:column: problem`. As a [`miette::Diagnostic`] it also quotes the source line
/// and says what to do.
#[derive(Debug)]
pub struct SceneError(Box<Located>);

#[derive(Debug)]
struct Located {
    problem: Problem,
    source: Source,
    span: Option<SourceSpan>,
}

/// What is wrong, the place apart.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// The text is not KDL.
    #[error("{message}")]
    Syntax {
        /// What the parser met.
        message: String,
        /// What it advises.
        help: Option<String>,
    },
    /// The file cannot be read.
    #[error("cannot read {path}: {reason}")]
    Unreadable {
        /// Which file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// The text, with all that it includes, is too long.
    #[error("the scene's text is longer than {limit} bytes")]
    TooLong {
        /// The most that is read.
        limit: usize,
    },
    /// Nodes nest too deeply.
    #[error("nodes nest more than {limit} deep")]
    TooDeep {
        /// The deepest nesting.
        limit: usize,
    },
    /// A node's name that means nothing here.
    #[error("unknown node `{found}`")]
    UnknownNode {
        /// The name.
        found: String,
        /// What may be meant.
        nearest: Option<&'static str>,
        /// What is known here.
        known: Vec<&'static str>,
    },
    /// A property that the node does not have.
    #[error("`{node}` has no property `{found}`")]
    UnknownProperty {
        /// Whose.
        node: &'static str,
        /// The property.
        found: String,
        /// What may be meant.
        nearest: Option<&'static str>,
        /// What the node has.
        known: &'static [&'static str],
    },
    /// A property or a singleton node that is there twice.
    #[error("`{name}` is given twice")]
    Twice {
        /// Its name.
        name: String,
    },
    /// A property that must be there is not.
    #[error("`{node}` needs the property `{property}`")]
    MissingProperty {
        /// Whose.
        node: &'static str,
        /// The property.
        property: &'static str,
    },
    /// Too few or too many arguments.
    #[error("`{node}` takes {wanted} argument(s), and {found} are given")]
    Arguments {
        /// Whose.
        node: &'static str,
        /// How many it takes.
        wanted: usize,
        /// How many are there.
        found: usize,
        /// How it is written.
        example: &'static str,
    },
    /// Too few children.
    #[error("`{node}` needs {wanted}, and has {found}")]
    TooFewChildren {
        /// Whose.
        node: &'static str,
        /// What it needs.
        wanted: &'static str,
        /// How many are there.
        found: usize,
    },
    /// Children where there can be none.
    #[error("`{node}` has no children")]
    NoChildren {
        /// Whose.
        node: &'static str,
    },
    /// A value of the wrong kind, or out of its range.
    #[error("`{name}` is {found}; it must be {wanted}")]
    BadValue {
        /// Which value.
        name: String,
        /// What it is.
        found: String,
        /// What it may be.
        wanted: String,
    },
    /// Values and colours as operands of one node.
    #[error(
        "`{first}` on line {line} gives {gives}, and `{second}` gives {other}: values and colours cannot be combined"
    )]
    Mixed {
        /// The first operand.
        first: &'static str,
        /// Its line, from 1.
        line: usize,
        /// What it gives.
        gives: &'static str,
        /// The operand that differs from it.
        second: &'static str,
        /// What that gives.
        other: &'static str,
    },
    /// A rule for what the operands are not.
    #[error("the rule `{rule}` does not combine {gives}, which `{operand}` on line {line} gives")]
    RuleKind {
        /// The rule.
        rule: String,
        /// An operand.
        operand: &'static str,
        /// Its line, from 1.
        line: usize,
        /// What it gives.
        gives: &'static str,
    },
    /// Colours where only values can be.
    #[error("`{node}` takes values, and `{child}` on line {line} gives colours")]
    WantsValues {
        /// Which node.
        node: &'static str,
        /// Its child.
        child: &'static str,
        /// The child's line, from 1.
        line: usize,
    },
    /// Properties that exclude each other.
    #[error("{0}")]
    Conflict(&'static str),
    /// A transform that cannot be inverted.
    #[error("`{node}` squeezes space flat: the transform has no inverse")]
    Singular {
        /// Which node.
        node: &'static str,
    },
    /// A name that nothing above defines.
    #[error("nothing named `{name}` is defined above this line")]
    Undefined {
        /// The name.
        name: String,
    },
    /// A file that includes itself.
    #[error("`{path}` includes itself: {chain}")]
    IncludeCycle {
        /// The file.
        path: String,
        /// The way from the file back to it.
        chain: String,
    },
    /// A file of a transfer function cannot be read.
    #[error("{0}")]
    TransferFile(String),
    /// No preset has this name.
    #[error("unknown preset `{found}`")]
    UnknownPreset {
        /// The name.
        found: String,
        /// What may be meant.
        nearest: Option<&'static str>,
    },
    /// More lights than a frame can have.
    #[error("there are more than {limit} lights")]
    TooManyLights {
        /// The most.
        limit: usize,
    },
    /// A transfer function that cannot be.
    #[error("transfer function: {0}")]
    Transfer(TransferError),
    /// Optics that cannot be.
    #[error("{0}")]
    Optics(OpticsError),
    /// A light that cannot be.
    #[error("{0}")]
    Light(SourceError),
    /// A table that cannot be.
    #[error("the table cannot be: {0}")]
    Table(LutError),
    /// A picture that makes no table.
    #[error("cannot read the table {0}")]
    Picture(String),
    /// A volume that cannot be loaded.
    #[error("cannot load the volume {0}")]
    Volume(String),
    /// A mesh that cannot be loaded, or that bounds no solid.
    #[error("cannot load the mesh {0}")]
    Mesh(String),
    /// Landmarks that cannot be loaded.
    #[error("cannot load the landmarks {0}")]
    Landmarks(String),
    /// Landmarks that make no deformation, or one that cannot be.
    #[error("{0}")]
    Deformation(String),
    /// An edit of a node that is not there.
    #[error("there is no node at {0:?}")]
    NoNode(Vec<usize>),
    /// A track of a node that is not there.
    #[error("there is no `{wanted}` here")]
    NotThere {
        /// The name, and which one.
        wanted: String,
        /// The names that are there.
        there: Vec<String>,
    },
    /// No `scene` node.
    #[error("there is no `scene` node")]
    NoScene,
}

impl Problem {
    /// What the user can do about it.
    fn advice(&self) -> Option<String> {
        let meant = |nearest: &Option<&str>| nearest.map(|n| format!("did you mean `{n}`? "));
        match self {
            Self::Syntax { help, .. } => help.clone(),
            Self::Unreadable { .. } => Some("paths are relative to the folder of the scene file".into()),
            Self::TooLong { .. } => Some("split the scene, or put repeated parts in `define`".into()),
            Self::TooDeep { .. } => Some("give one node many children instead of nesting them one by one".into()),
            Self::UnknownNode { nearest, known, .. } => Some(format!(
                "{}known here: {}",
                meant(nearest).unwrap_or_default(),
                known.join(", ")
            )),
            Self::UnknownProperty { nearest, known, .. } if !known.is_empty() => Some(format!(
                "{}it has: {}",
                meant(nearest).unwrap_or_default(),
                known.join(", ")
            )),
            Self::Twice { .. } => Some("keep one of them".into()),
            Self::Arguments { example, .. } => Some(format!("write {example}")),
            Self::Undefined { .. } => Some("put `define \"name\" { … }` above the first `use \"name\"`".into()),
            Self::UnknownPreset { nearest, .. } => Some(format!(
                "{}the presets are listed in docs/PRESETS.md, and by `vcsg presets`",
                meant(nearest).unwrap_or_default()
            )),
            Self::Mixed { .. } => {
                Some("put `classify` round both, or round the operation instead of its operands".into())
            }
            Self::RuleKind { .. } => Some(
                "colours take first, second, over, plus, in, out, atop, xor; values first, second and all others"
                    .into(),
            ),
            Self::WantsValues { .. } => Some("put it inside `classify`, which makes colours of values".into()),
            Self::Singular { .. } => Some("no factor may be 0 and no two axes parallel".into()),
            Self::NotThere { there, .. } => Some(format!(
                "name a node by its way from the top, like `scene/union/sphere[2]`; there are: {}",
                there.join(", ")
            )),
            Self::NoScene => Some("write what is to be seen as `scene { … }`".into()),
            _ => None,
        }
    }
}

impl SceneError {
    pub(super) fn at(source: &Source, span: SourceSpan, problem: Problem) -> Self {
        Self(Box::new(Located {
            problem,
            source: source.clone(),
            span: Some(span),
        }))
    }

    /// A problem of a whole file.
    pub(super) fn of_file(name: &str, problem: Problem) -> Self {
        Self(Box::new(Located {
            problem,
            source: Source::new(name, ""),
            span: None,
        }))
    }

    /// What is wrong.
    pub fn problem(&self) -> &Problem {
        &self.0.problem
    }

    /// The file that has it.
    pub fn file(&self) -> &str {
        self.0.source.name()
    }

    /// The place in the source, if it can be shown.
    fn quoted_span(&self) -> Option<SourceSpan> {
        self.0.span.filter(|span| self.0.source.is_quotable(span.offset()))
    }

    /// Line and column, from 1; `None` when the file as a whole is at fault.
    pub fn place(&self) -> Option<(usize, usize)> {
        let span = self.0.span?;
        Some(self.0.source.place(span.offset()))
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place() {
            Some((line, column)) => {
                write!(f, "{}:{line}:{column}: {}", self.file(), self.problem())
            }
            None => write!(f, "{}: {}", self.file(), self.problem()),
        }
    }
}

impl std::error::Error for SceneError {}

impl Diagnostic for SceneError {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        let advice = self.problem().advice()?;
        Some(Box::new(advice))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.quoted_span().map(|_| self.0.source.quoted() as _)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let span = self.quoted_span()?;
        let label = LabeledSpan::new_with_span(Some("here".into()), span);
        Some(Box::new(std::iter::once(label)))
    }
}
