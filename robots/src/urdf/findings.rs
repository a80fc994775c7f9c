//! What the reader finds in a file: errors, and irregularities that are repaired, or refused in strict mode.

use wbqp::robot::{Diagnostic, RobotError, Severity, SourceLocation};

use crate::source::Source;

/// Everything that was found in a file, in the order in which it was.
pub(super) struct Findings<'a> {
    pub(super) source: &'a Source<'a>,
    /// Whether irregularities are errors.
    mode: Mode,
    errors: Vec<RobotError>,
    diagnostics: Vec<Diagnostic>,
    /// Irregularities of what options may give, with their element.
    doubts: Vec<(Vec<Quantity>, Diagnostic)>,
    /// Names that were left out as misspelt: where the file is refused, they may be why.
    slips: Vec<RobotError>,
    /// Wrong names for which a right one was looked for.
    suggested: usize,
}

/// Wrong names for which a right one is looked for: each search goes through all names.
pub(crate) const SUGGESTED: usize = 10;

/// What a file can leave open and an option can give.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    Range,
    Velocity,
    Effort,
    Damping,
    Friction,
    Inertia,
}

/// How a file is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    /// What other tools of the field read is read, with a diagnostic.
    Liberal,
    /// What the format and physics do not allow is refused.
    Strict,
}

/// An element in the file.
#[derive(Clone, Copy)]
pub(super) struct At<'e> {
    /// Byte offset.
    pub(super) offset: usize,
    /// What messages call it.
    pub(super) element: &'e str,
}

/// Something that is not as it should be and can be repaired.
pub(crate) struct Irregularity {
    pub(super) severity: Severity,
    /// What strict mode says; nothing if strict mode accepts it.
    pub(super) strict: Option<String>,
    pub(super) found: String,
    pub(super) done: String,
    pub(super) remedy: String,
    /// It is of no account if options give all of these, and there are any.
    pub(super) quantities: Vec<Quantity>,
}

impl Irregularity {
    /// Worth a look: the robot may not be what its owner thinks.
    pub(crate) fn warning(found: impl Into<String>, done: impl Into<String>) -> Self {
        Self {
            severity: Severity::Warning,
            strict: None,
            found: found.into(),
            done: done.into(),
            remedy: String::new(),
            quantities: Vec::new(),
        }
    }

    /// A habit of files that has one meaning.
    pub(crate) fn note(found: impl Into<String>, done: impl Into<String>) -> Self {
        Self {
            severity: Severity::Note,
            ..Self::warning(found, done)
        }
    }

    /// How to say otherwise.
    pub(crate) fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.remedy = remedy.into();
        self
    }

    /// Of no account if options give these.
    pub(super) fn unless_given(mut self, quantities: impl Into<Vec<Quantity>>) -> Self {
        self.quantities = quantities.into();
        self
    }

    /// What strict mode refuses it with.
    pub(crate) fn refused_as(mut self, strict: impl Into<String>) -> Self {
        self.strict = Some(strict.into());
        self
    }
}

impl<'a> Findings<'a> {
    pub(super) fn new(source: &'a Source<'a>, mode: Mode) -> Self {
        Self {
            source,
            mode,
            errors: Vec::new(),
            diagnostics: Vec::new(),
            doubts: Vec::new(),
            slips: Vec::new(),
            suggested: 0,
        }
    }

    pub(super) fn is_strict(&self) -> bool {
        self.mode == Mode::Strict
    }

    /// Whether a right name is to be looked for instead of another wrong one.
    pub(super) fn may_suggest(&mut self) -> bool {
        self.suggested += 1;
        self.suggested <= SUGGESTED
    }

    /// Something without meaning, in either mode.
    pub(super) fn refuse(&mut self, at: At<'_>, what: impl Into<String>) {
        let error = self.source.error(at.offset, at.element, what);
        self.errors.push(error);
    }

    /// The same about the file as a whole.
    pub(super) fn refuse_file(&mut self, offset: usize, what: impl Into<String>) {
        let place = self.source.place(offset);
        let what = what.into();
        self.errors.push(RobotError::Syntax { place, what });
    }

    /// An error that has its words already.
    pub(super) fn refuse_as(&mut self, error: RobotError) {
        self.errors.push(error);
    }

    /// Several of them.
    pub(super) fn refuse_all(&mut self, errors: Vec<RobotError>) {
        self.errors.extend(errors);
    }

    /// Something that is repaired, and said; in strict mode refused if it has words for that.
    pub(super) fn repair(&mut self, at: At<'_>, irregularity: Irregularity) {
        let place = self.source.place(at.offset);
        self.repair_elsewhere(place, at.element, irregularity);
    }

    /// A name that is left out as misspelt.
    pub(super) fn leave_out(&mut self, at: At<'_>, found: &str) {
        if self.is_strict() {
            self.refuse(at, found);
            return;
        }
        let slip = self.source.error(at.offset, at.element, found);
        self.slips.push(slip);
        self.repair(at, Irregularity::warning(found, "left out"));
    }

    /// The same of another file.
    pub(super) fn repair_elsewhere(
        &mut self,
        place: SourceLocation,
        element: &str,
        irregularity: Irregularity,
    ) {
        let Irregularity {
            severity,
            strict,
            found,
            done,
            remedy,
            quantities,
        } = irregularity;
        if self.is_strict()
            && let Some(what) = strict
        {
            self.refuse_elsewhere(place, element, what);
            return;
        }
        let diagnostic = Diagnostic {
            severity,
            place,
            element: element.to_owned(),
            found,
            done,
            remedy,
        };
        if quantities.is_empty() {
            self.diagnostics.push(diagnostic);
        } else {
            self.doubts.push((quantities, diagnostic));
        }
    }

    /// Something of another file without meaning.
    pub(super) fn refuse_elsewhere(
        &mut self,
        place: SourceLocation,
        element: &str,
        what: impl Into<String>,
    ) {
        self.errors.push(RobotError::Element {
            place,
            element: element.to_owned(),
            what: what.into(),
        });
    }

    /// What is doubtful of an element, by its label, is given otherwise.
    pub(super) fn drop_doubts(&mut self, element: &str) {
        self.doubts
            .retain(|(_, diagnostic)| diagnostic.element != element);
    }

    /// Decides what is of no account, when it is known what options give, by an element as messages call it.
    pub(super) fn settle(&mut self, is_given: impl Fn(&str, Quantity) -> bool) {
        for (quantities, diagnostic) in self.doubts.drain(..) {
            let element = &diagnostic.element;
            if !quantities
                .iter()
                .all(|&quantity| is_given(element, quantity))
            {
                self.diagnostics.push(diagnostic);
            }
        }
    }

    /// Stops if anything has no meaning.
    pub(super) fn stop_if_any(&mut self) -> Result<(), RobotError> {
        if self.errors.is_empty() {
            return Ok(());
        }
        let mut errors = std::mem::take(&mut self.slips);
        errors.append(&mut self.errors);
        match RobotError::of(errors) {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }

    /// What was repaired, in the order of the file.
    pub(super) fn into_diagnostics(mut self) -> Vec<Diagnostic> {
        self.diagnostics.sort_by_key(|d| d.place.position);
        self.diagnostics
    }
}
