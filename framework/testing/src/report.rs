//! What failed, in words.

use std::fmt;

use wbqp::error::BindError;

/// What a plug-in is checked for; see the table of the [module](crate).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Check {
    /// The way through a file and back.
    Form,
    /// Unknown keys are refused.
    UnknownKeys,
    /// The JSON Schema.
    Schema,
    /// The plug-in does not panic.
    Panic,
    /// What the rows mean is stated where nothing can be assumed.
    RowSemantics,
    /// What is declared is what is written.
    Layout,
    /// Numbers that are numbers.
    Finite,
    /// Coefficients depend on the configuration alone.
    Coefficients,
    /// Nothing is allocated.
    Allocation,
    /// Coefficients are the derivative of the error.
    Jacobian,
    /// The bias `J̇v` is taken into account.
    Bias,
    /// The feedback has the right sign.
    Feedback,
}

impl fmt::Display for Check {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Form => "form",
            Self::UnknownKeys => "unknown keys",
            Self::Schema => "schema",
            Self::Panic => "panic",
            Self::RowSemantics => "meaning",
            Self::Layout => "layout",
            Self::Finite => "finite",
            Self::Coefficients => "coefficients",
            Self::Allocation => "allocation",
            Self::Jacobian => "jacobian",
            Self::Bias => "bias",
            Self::Feedback => "feedback",
        })
    }
}

/// A check that failed.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Failure {
    /// Which check.
    pub check: Check,
    /// On which robot; empty if it is about no robot.
    pub robot: String,
    /// Where first, and how.
    pub message: String,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.robot.as_str() {
            "" => write!(f, "{}: {}", self.check, self.message),
            robot => write!(f, "{} on `{robot}`: {}", self.check, self.message),
        }
    }
}

/// All checks that failed, one line each.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub struct Failures {
    /// The plug-in, such as ``task `posture` ``.
    pub plugin: String,
    /// One per check and robot, in the order of the checks.
    pub list: Vec<Failure>,
}

impl fmt::Display for Failures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = self.list.len();
        let s = if count == 1 { "" } else { "s" };
        write!(f, "{} fails {count} check{s}", self.plugin)?;
        for failure in &self.list {
            write!(f, "\n  {failure}")?;
        }
        Ok(())
    }
}

/// What a plug-in has passed on.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Passed {
    /// The robots it was tested on.
    pub robots: Vec<String>,
    /// The robots that it refused, with the reason.
    pub refused: Vec<(String, BindError)>,
}

/// Collects what fails: of each check on each robot the first failure.
pub(crate) struct Report {
    plugin: String,
    state: Option<usize>,
    list: Vec<Failure>,
    passed: Passed,
}

impl Report {
    pub(crate) fn new(kind: &str) -> Self {
        Self {
            plugin: kind.to_owned(),
            state: None,
            list: Vec::new(),
            passed: Passed {
                robots: Vec::new(),
                refused: Vec::new(),
            },
        }
    }

    /// Names the plug-in.
    pub(crate) fn named(&mut self, tag: &str) {
        self.plugin.push_str(&format!(" `{tag}`"));
    }

    /// Failures are about this random state from now on.
    pub(crate) fn state(&mut self, index: usize) {
        self.state = Some(index);
    }

    pub(crate) fn accepted(&mut self, robot: &str) {
        self.state = None;
        self.passed.robots.push(robot.to_owned());
    }

    pub(crate) fn refused(&mut self, robot: &str, error: BindError) {
        self.passed.refused.push((robot.to_owned(), error));
    }

    pub(crate) fn fail(&mut self, check: Check, robot: &str, message: impl Into<String>) {
        if self
            .list
            .iter()
            .any(|f| f.check == check && f.robot == robot)
        {
            return;
        }
        let message = match self.state {
            Some(state) if !robot.is_empty() => format!("state {state}: {}", message.into()),
            _ => message.into(),
        };
        self.list.push(Failure {
            check,
            robot: robot.to_owned(),
            message,
        });
    }

    pub(crate) fn finish(mut self) -> Result<Passed, Failures> {
        if self.passed.robots.is_empty()
            && (self.list.is_empty() || !self.passed.refused.is_empty())
        {
            let reasons = self.passed.refused.iter();
            let reasons: Vec<_> = reasons
                .map(|(robot, error)| format!("`{robot}`: {error}"))
                .collect();
            let message = format!("no robot is accepted: {}", reasons.join("; "));
            self.state = None;
            self.fail(Check::Layout, "", message);
        }
        if self.list.is_empty() {
            return Ok(self.passed);
        }
        self.list.sort_by_key(|failure| failure.check);
        Err(Failures {
            plugin: self.plugin,
            list: self.list,
        })
    }
}
