//! Measures of a plan's own: expressions over the channels of a run.

use exmex::{Express, FlatEx};
use toml::Spanned;
use wbqp_measures::{Columns, MeasureError, Recording, Row, Series};

use super::{
    file::{Gaps, MeasureKeys, Reduction, Time},
    window::{Channel, Otherwise, Window},
};

/// A number from the channels of a run.
#[derive(Clone, Debug)]
pub struct Measure {
    name: String,
    /// Index among the variant's cases.
    pub(crate) case: usize,
    /// Name, topic and field of each signal, in the order of their names.
    signals: Vec<Signal>,
    expression: Compiled,
    reduce: Reduction,
    gaps: Gaps,
    from: Option<Compiled>,
    until: Option<Compiled>,
    unit: String,
    at_most: Option<f64>,
    at_least: Option<f64>,
    /// Where it begins in the plan.
    start: usize,
}

/// What a run has of a measure.
#[derive(Clone, Debug)]
pub(crate) struct Measured {
    pub(crate) row: Row,
    pub(crate) gaps: Gaps,
    /// Share of the window's ticks whose value is their own; of a measure that may do without, see [`Gaps`].
    pub(crate) covered: Option<f64>,
    pub(crate) lacks: Option<Lack>,
}

/// Why a measure has no value.
#[derive(Clone, Debug)]
pub(crate) struct Lack {
    /// In words.
    pub(crate) why: String,
    /// What would be done about it, in words.
    pub(crate) remedy: &'static str,
}

/// Of a window with gaps.
const REMEDY: &str = "a tick without a solution has no references, tasks and planned forces: give the measure another \
    window, or `gaps = \"hold\"` (the last value goes on) or `gaps = \"skip\"` (such ticks are left out); the table \
    then says which share of the window is there";

impl From<Row> for Measured {
    fn from(row: Row) -> Self {
        Self {
            row,
            gaps: Gaps::NoValue,
            covered: None,
            lacks: None,
        }
    }
}

#[derive(Clone, Debug)]
struct Signal {
    name: String,
    topic: String,
    /// A JSON pointer.
    field: String,
}

/// The longest expression, bytes.
const LONGEST: usize = 1000;

/// An expression with the names in it, in the order in which it takes their values.
#[derive(Clone, Debug)]
pub(crate) struct Compiled {
    expression: FlatEx<f64>,
    names: Vec<String>,
}

impl Compiled {
    pub(crate) fn new(text: &str) -> Result<Self, String> {
        if text.len() > LONGEST {
            return Err(format!("is longer than {LONGEST} bytes"));
        }
        let parsed = exmex::parse::<f64>(text);
        let expression = parsed.map_err(|error| format!("`{text}`: {error}"))?;
        let names = expression.var_names().to_vec();
        Ok(Self { expression, names })
    }

    fn at_time(time: &Time) -> Result<Self, String> {
        match time {
            Time::Number(t) if t.is_finite() => Self::new(&t.to_string()),
            Time::Number(t) => Err(format!("{t} is no time")),
            Time::Expression(text) => Self::new(text),
        }
    }

    /// Its value with the marks of a run.
    pub(crate) fn time(&self, run: &dyn Recording) -> Result<f64, MeasureError> {
        let values = self.names.iter().map(|name| run.mark(name));
        let values = values.collect::<Result<Vec<f64>, _>>()?;
        Ok(self.expression.eval(&values).unwrap_or(f64::NAN))
    }
}

impl Measure {
    pub(super) fn new(entry: &Spanned<MeasureKeys>) -> Result<Self, String> {
        let keys = entry.get_ref();
        let refuse = |what: String| format!("measure `{}`: {what}", keys.name);
        if keys.case == 0 {
            return Err(refuse("cases are counted from 1".to_owned()));
        }
        let mut signals = Vec::new();
        for (name, channel) in &keys.signals {
            let (topic, field) = channel
                .strip_prefix('/')
                .and_then(|_| channel.split_once('.'))
                .ok_or_else(|| {
                    refuse(format!(
                        "signal `{name}`: `{channel}` must be a topic and a field, as `/contact/tip.measured.z`"
                    ))
                })?;
            signals.push(Signal {
                name: name.clone(),
                topic: topic.to_owned(),
                field: format!("/{}", field.replace('.', "/")),
            });
        }
        let text = match (&keys.expression, signals.as_slice()) {
            (Some(text), [_, ..]) => text.clone(),
            (None, [only]) => only.name.clone(),
            (_, []) => return Err(refuse("has no signal".to_owned())),
            (None, _) => {
                return Err(refuse("wants an `expression` of its signals".to_owned()));
            }
        };
        let expression = Compiled::new(&text).map_err(&refuse)?;
        let known: Vec<&str> = signals.iter().map(|s| s.name.as_str()).collect();
        if let Some(name) = expression
            .names
            .iter()
            .find(|n| !known.contains(&n.as_str()))
        {
            let hint = wbqp::suggestion::suggestion(name, &known);
            return Err(refuse(format!("there is no signal `{name}`{hint}")));
        }
        if let Some(unused) = known
            .iter()
            .find(|n| !expression.names.iter().any(|m| m == *n))
        {
            return Err(refuse(format!(
                "signal `{unused}` is not in the expression `{text}`; a name of a constant or a function cannot be a \
                 signal's"
            )));
        }
        if let Reduction::Quantile(p) = keys.reduce
            && !(0.0..=1.0).contains(&p)
        {
            return Err(refuse(format!("a quantile is between 0 and 1, not at {p}")));
        }
        for bound in [keys.at_most, keys.at_least].into_iter().flatten() {
            if bound.is_nan() {
                return Err(refuse("a bound is not a number".to_owned()));
            }
        }
        if let (Some(most), Some(least)) = (keys.at_most, keys.at_least)
            && most < least
        {
            return Err(refuse(format!(
                "nothing is at most {most} and at least {least}: `at_most` must not be below `at_least`"
            )));
        }
        let time = |time: &Option<Time>| {
            let compiled = time.as_ref().map(Compiled::at_time);
            compiled.transpose().map_err(&refuse)
        };
        Ok(Self {
            name: keys.name.clone(),
            case: keys.case - 1,
            signals,
            expression,
            reduce: keys.reduce,
            gaps: keys.gaps,
            from: time(&keys.from)?,
            until: time(&keys.until)?,
            unit: keys.unit.clone(),
            at_most: keys.at_most,
            at_least: keys.at_least,
            start: entry.span().start,
        })
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Where it begins in the plan.
    pub(crate) fn start(&self) -> usize {
        self.start
    }

    /// What becomes of ticks of its window in which a signal has no value.
    pub fn gaps(&self) -> Gaps {
        self.gaps
    }

    /// Measures a run.
    ///
    /// # Errors
    /// [`MeasureError`] if the run lacks a topic or a mark.
    pub(crate) fn measured(&self, run: &Columns) -> Result<Measured, MeasureError> {
        let tolerance = match (self.at_least, self.at_most) {
            (Some(low), Some(high)) => format!("{low} … {high} {}", self.unit),
            (Some(low), None) => format!("≥ {low} {}", self.unit),
            (None, Some(high)) => format!("≤ {high} {}", self.unit),
            (None, None) => "informative".to_owned(),
        };
        let window = self.window(run)?;
        let (value, lacks) = match self.reduced(&window) {
            Some(value) => (Some(value), None),
            None => (None, Some(Self::lack(&window, run))),
        };
        let what = ("", self.unit.as_str());
        let tolerance = tolerance.trim_end();
        let row = if self.at_least.is_none() && self.at_most.is_none() {
            Row::informative(&self.name, what, None, value, tolerance)
        } else {
            let low = self.at_least.unwrap_or(f64::NEG_INFINITY);
            let high = self.at_most.unwrap_or(f64::INFINITY);
            let holds = |x: f64| (low..=high).contains(&x);
            Row::judged(&self.name, what, None, value, tolerance, holds)
        };
        Ok(Measured {
            row,
            gaps: self.gaps,
            covered: (self.gaps != Gaps::NoValue).then(|| window.covered()),
            lacks,
        })
    }

    /// Its number, if the window has what that takes.
    fn reduced(&self, window: &Window) -> Option<f64> {
        let is_whole = window.values.len() == window.ticks;
        let is_enough = match (self.gaps, self.reduce) {
            (Gaps::Skip, _) => true,
            (_, Reduction::Last) => window.has_last,
            _ => is_whole,
        };
        is_enough
            .then(|| reduced(self.reduce, &window.values))
            .flatten()
    }

    /// Why there is no number.
    fn lack(window: &Window, run: &Columns) -> Lack {
        if let Some(why) = window.lack() {
            return Lack {
                why,
                remedy: REMEDY,
            };
        }
        let end = run.times().last().copied().unwrap_or(0.0);
        let [from, until] = window.ends;
        Lack {
            why: format!(
                "there is nothing in its window, from {from} s until {until} s, of a run until {end:.3} s"
            ),
            remedy: "give it another one, with `from` and `until`",
        }
    }

    /// Which case of a variant it is of, by position.
    pub fn case(&self) -> usize {
        self.case
    }

    /// The time in a run at which what is measured is most of what is looked for, s: the largest value for `max`, the
    /// smallest for `min`, the last for `last`, and else the one that is farthest from zero.
    ///
    /// # Errors
    /// [`MeasureError`] if the run lacks a topic or a mark.
    pub fn moment(&self, run: &Columns) -> Result<Option<f64>, MeasureError> {
        let window = self.window(run)?;
        let size = |y: f64| match self.reduce {
            Reduction::Max => y,
            Reduction::Min => -y,
            Reduction::Last => 0.0,
            _ => y.abs(),
        };
        let samples = window.values.samples();
        let most = samples.max_by(|a, b| size(a.1).total_cmp(&size(b.1)));
        Ok(most.map(|(t, _)| t))
    }

    /// What is measured, in every tick of its window.
    fn window(&self, run: &Columns) -> Result<Window, MeasureError> {
        let mut channels = Vec::new();
        for name in &self.expression.names {
            // Every name is a signal's: that was checked.
            let Some(signal) = self.signals.iter().find(|s| s.name == *name) else {
                continue;
            };
            let series = run.series(&signal.topic, &signal.field)?;
            if series.y.iter().all(|y| y.is_nan()) {
                return Err(MeasureError::Field {
                    topic: signal.topic.clone(),
                    field: signal.field.clone(),
                });
            }
            let channel = format!("{}{}", signal.topic, signal.field.replace('/', "."));
            channels.push(Channel {
                called: format!("`{name}` ({channel})"),
                series,
            });
        }
        let time = |time: &Option<Compiled>, otherwise: f64| {
            let time = time.as_ref().map(|t| t.time(run)).transpose();
            time.map(|time| time.unwrap_or(otherwise))
        };
        let ends = [
            time(&self.from, f64::NEG_INFINITY)?,
            time(&self.until, f64::INFINITY)?,
        ];
        let otherwise = match self.gaps {
            Gaps::Hold => Otherwise::Last,
            Gaps::NoValue | Gaps::Skip => Otherwise::Nothing,
        };
        let compute = |values: &[f64]| {
            let value = self.expression.expression.eval(values);
            value.unwrap_or(f64::NAN)
        };
        Ok(Window::of(run.times(), &channels, otherwise, ends, compute))
    }
}

fn reduced(reduction: Reduction, series: &Series) -> Option<f64> {
    match reduction {
        Reduction::Mean => series.mean(),
        Reduction::Rms => series.rmse(0.0),
        Reduction::Max => series.max(),
        Reduction::Min => series.min(),
        Reduction::MaxAbs => series.map(f64::abs).max(),
        Reduction::Last => series.samples().last().map(|(_, y)| y),
        Reduction::Share => series.fraction(|y| y > 0.0),
        Reduction::Quantile(p) => series.quantile(p),
    }
}
