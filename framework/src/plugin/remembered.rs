//! What a plug-in remembers from tick to tick, as numbers: so that a tick can be computed again as if it were the first
//! time.

/// What a plug-in remembers from tick to tick, number by number.
///
/// [`Task::remembered`](super::Task::remembered) shows all of it, in the same order each time; whether it is counted,
/// written down or put back is none of the plug-in's business.
///
/// ```
/// use wbqp::plugin::Remembered;
///
/// struct Filter {
///     force: f64,
///     first: Option<f64>,
/// }
///
/// fn remembered(filter: &mut Filter, numbers: &mut Remembered<'_>) {
///     numbers.number(&mut filter.force);
///     numbers.maybe(&mut filter.first);
/// }
/// ```
#[derive(Debug)]
pub struct Remembered<'a> {
    storage: Storage<'a>,
    at: usize,
    is_known: bool,
}

#[derive(Debug)]
enum Storage<'a> {
    None,
    Written(&'a mut [u64]),
    Read(&'a [u64]),
}

impl Remembered<'_> {
    /// A number.
    pub fn number(&mut self, number: &mut f64) {
        let mut bits = number.to_bits();
        self.pass(&mut bits);
        *number = f64::from_bits(bits);
    }

    /// Several numbers; as many each time.
    pub fn numbers<'n>(&mut self, numbers: impl IntoIterator<Item = &'n mut f64>) {
        for number in numbers {
            self.number(number);
        }
    }

    /// Whether something is so.
    pub fn flag(&mut self, flag: &mut bool) {
        let mut bits = u64::from(*flag);
        self.pass(&mut bits);
        *flag = bits != 0;
    }

    /// A number that may be absent.
    pub fn maybe(&mut self, number: &mut Option<f64>) {
        self.option(number, 0.0, Self::number);
    }

    /// Something that may be absent; `blank` is any value of it, and `show` shows what is inside.
    pub fn option<T: Copy>(
        &mut self,
        value: &mut Option<T>,
        blank: T,
        show: impl FnOnce(&mut Self, &mut T),
    ) {
        let mut is_there = value.is_some();
        self.flag(&mut is_there);
        let mut inside = value.unwrap_or(blank);
        show(self, &mut inside);
        *value = is_there.then_some(inside);
    }

    /// Says that there is more than can be shown.
    pub fn unknown(&mut self) {
        self.is_known = false;
    }

    fn pass(&mut self, bits: &mut u64) {
        match &mut self.storage {
            Storage::None => {}
            Storage::Written(out) => match out.get_mut(self.at) {
                Some(out) => *out = *bits,
                None => self.is_known = false,
            },
            Storage::Read(from) => match from.get(self.at) {
                Some(from) => *bits = *from,
                None => self.is_known = false,
            },
        }
        self.at += 1;
    }
}

/// Room for what one plug-in remembers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Memo {
    /// None if the plug-in does not say what it remembers.
    bits: Option<Vec<u64>>,
}

impl Memo {
    /// Of the size that a plug-in needs, which shows what it remembers.
    pub(crate) fn of(show: impl FnOnce(&mut Remembered<'_>)) -> Self {
        let mut count = Remembered {
            storage: Storage::None,
            at: 0,
            is_known: true,
        };
        show(&mut count);
        Self {
            bits: count.is_known.then(|| vec![0; count.at]),
        }
    }

    /// Whether the plug-in says what it remembers.
    pub(crate) fn is_known(&self) -> bool {
        self.bits.is_some()
    }

    /// Writes down what is shown.
    pub(crate) fn save(&mut self, show: impl FnOnce(&mut Remembered<'_>)) {
        if let Some(bits) = &mut self.bits {
            pass(Storage::Written(bits), show);
        }
    }

    /// Puts it back.
    pub(crate) fn restore(&self, show: impl FnOnce(&mut Remembered<'_>)) {
        if let Some(bits) = &self.bits {
            pass(Storage::Read(bits), show);
        }
    }
}

fn pass(storage: Storage<'_>, show: impl FnOnce(&mut Remembered<'_>)) {
    show(&mut Remembered {
        storage,
        at: 0,
        is_known: true,
    });
}

#[cfg(test)]
mod tests {
    use super::{Memo, Remembered};

    #[derive(Clone, Debug, PartialEq)]
    struct State {
        terms: [f64; 2],
        first: Option<f64>,
        is_at_limit: bool,
    }

    fn show(state: &mut State, numbers: &mut Remembered<'_>) {
        numbers.numbers(&mut state.terms);
        numbers.maybe(&mut state.first);
        numbers.flag(&mut state.is_at_limit);
    }

    #[test]
    fn what_was_written_down_comes_back() {
        let mut state = State {
            terms: [0.1, -0.0],
            first: None,
            is_at_limit: true,
        };
        let before = state.clone();
        let mut memo = Memo::of(|numbers| show(&mut state, numbers));
        memo.save(|numbers| show(&mut state, numbers));
        assert_eq!(state, before);
        state.terms = [3.0, 4.0];
        (state.first, state.is_at_limit) = (Some(5.0), false);
        memo.restore(|numbers| show(&mut state, numbers));
        assert_eq!(state, before);
        assert!(state.terms[1].is_sign_negative());
    }

    #[test]
    fn who_does_not_say_is_left_alone() {
        let mut memo = Memo::of(|numbers| {
            numbers.flag(&mut true);
            numbers.unknown();
        });
        assert!(!memo.is_known());
        let mut number = 1.0;
        memo.save(|numbers| numbers.number(&mut number));
        memo.restore(|numbers| numbers.number(&mut number));
        assert_eq!(number, 1.0);
    }
}
