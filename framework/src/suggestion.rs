//! The words in which an unknown name is refused, the same in every message: what was probably meant, and what there
//! is.
//!
//! ```
//! use wbqp::suggestion::suggestion;
//! assert_eq!(
//!     format!("there is no joint `elbov`{}", suggestion("elbov", &["elbow", "wrist"])),
//!     "there is no joint `elbov`; did you mean `elbow`? (known: elbow, wrist)",
//! );
//! ```

/// `; did you mean …?` if one of the names is near, and the list of what there is.
pub fn suggestion(name: &str, known: &[&str]) -> String {
    format!("{} (known: {})", hint(name, known), list(known))
}

/// `; did you mean …?`, or nothing if no name is near.
pub(crate) fn hint(name: &str, known: &[&str]) -> String {
    did_you_mean(name, known).map_or_else(String::new, |near| format!("; did you mean `{near}`?"))
}

/// The names, or `none`.
pub(crate) fn list(known: &[&str]) -> String {
    if known.is_empty() {
        return "none".to_owned();
    }
    let (shown, rest) = known.split_at(known.len().min(LISTED));
    let more = match rest.len() {
        0 => String::new(),
        n => format!(", … and {n} more"),
    };
    format!("{}{more}", shown.join(", "))
}

/// The nearest of the known names, if it is near enough to have been meant.
pub fn did_you_mean<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    // A distance takes time with the length of both; nobody means a short name with a long one.
    if name.len() > COMPARED {
        return None;
    }
    let most = 1 + name.len() / 4;
    let letters = Letters::of(name);
    let nearest = known
        .iter()
        // A long list has few that are worth a comparison.
        .filter(|k| letters.differences(k) <= most)
        .map(|k| (strsim::damerau_levenshtein(name, k), *k))
        .min();
    if let Some((distance, nearest)) = nearest
        && distance <= most
    {
        return Some(nearest);
    }
    // A part of a name, or too much of it.
    let mut related = known.iter().filter(|k| {
        name.len() >= PART && k.len() >= PART && (k.contains(name) || name.contains(**k))
    });
    related.next().copied()
}

/// The characters of a name: how many, and which, each in one of 64 classes.
struct Letters {
    count: usize,
    classes: u64,
}

impl Letters {
    fn of(name: &str) -> Self {
        let none = Self {
            count: 0,
            classes: 0,
        };
        name.chars().fold(none, |all, letter| Self {
            count: all.count + 1,
            classes: all.classes | 1 << (u32::from(letter) % 64),
        })
    }

    /// A number that the distance of two names is never below.
    fn differences(&self, name: &str) -> usize {
        let other = Self::of(name);
        let own = (self.classes & !other.classes).count_ones();
        let others = (other.classes & !self.classes).count_ones();
        self.count
            .abs_diff(other.count)
            .max(own.max(others) as usize)
    }
}

/// Bytes from which on a part of a name says which is meant.
const PART: usize = 4;

/// Names that a message lists.
const LISTED: usize = 50;

/// Bytes of a name that is still compared.
const COMPARED: usize = 200;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_far_was_not_meant() {
        assert_eq!(suggestion("wrist", &["elbow"]), " (known: elbow)");
        assert_eq!(suggestion("x", &[]), " (known: none)");
        assert_eq!(
            hint("force", &["arm", "contact_force"]),
            "; did you mean `contact_force`?"
        );
        assert_eq!(hint("arm", &["arm_roll"]), "");
        assert_eq!(hint(&"a".repeat(1000), &["a"]), "");
    }

    #[test]
    fn long_lists_are_cut() {
        let names: Vec<String> = (0..60).map(|i| format!("link{i}")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        assert!(list(&names).ends_with("link49, … and 10 more"));
    }
}
