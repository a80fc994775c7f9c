//! Names of joints or links, and regular expressions for them.

use std::collections::{BTreeMap, HashMap};

use regex::RegexBuilder;
use wbqp::{robot::RobotError, suggestion::suggestion};

use super::refuse;
use crate::urdf::SUGGESTED;

/// Largest size of a compiled expression, bytes; with names of at most some hundred characters its use is bounded too.
const LARGEST: usize = 1 << 18;
/// Expressions of an option, at most: each takes milliseconds to compile if it is as large as it may be.
const MOST: usize = 200;

/// The names that options can mean.
pub(crate) struct Names<'a> {
    /// In messages.
    robot: &'a str,
    /// `moving joint` or `link`.
    kind: &'static str,
    pub(crate) known: Vec<&'a str>,
    /// Names of several of them together, by index: a planar joint's.
    groups: BTreeMap<&'a str, Vec<usize>>,
    /// Each name's place in `known`: options may be as many as names.
    places: HashMap<&'a str, usize>,
}

impl<'a> Names<'a> {
    pub(crate) fn new(
        robot: &'a str,
        kind: &'static str,
        known: Vec<&'a str>,
        groups: BTreeMap<&'a str, Vec<usize>>,
    ) -> Self {
        let mut places = HashMap::new();
        for (index, name) in known.iter().enumerate() {
            places.entry(*name).or_insert(index);
        }
        Self {
            robot,
            kind,
            known,
            groups,
            places,
        }
    }

    /// Those that a key of an option means, by index: the one of that name, or all that an expression matches as a
    /// whole.
    ///
    /// `told` is how many were wrong before: of many, the right name is looked for of the first alone.
    pub(crate) fn matching(
        &self,
        option: &str,
        key: &str,
        told: usize,
    ) -> Result<Vec<usize>, RobotError> {
        if let Some(index) = self.places.get(key) {
            return Ok(vec![*index]);
        }
        if let Some(group) = self.groups.get(key) {
            return Ok(group.clone());
        }
        let Self {
            robot,
            kind,
            known,
            groups,
            places: _,
        } = self;
        let suggestion = |key: &str| {
            if told < SUGGESTED {
                suggestion(key, known)
            } else {
                String::new()
            }
        };
        if is_plain(key) {
            let hint = suggestion(key);
            let what = format!("robot `{robot}` has no {kind} `{key}`{hint}");
            return Err(refuse(option, what));
        }
        let expression = RegexBuilder::new(&format!("^(?:{key})$"))
            .size_limit(LARGEST)
            .build();
        match expression {
            Ok(expression) => {
                let matches =
                    |i: &usize| known.get(*i).is_some_and(|name| expression.is_match(name));
                let mut found: Vec<usize> = (0..known.len()).filter(matches).collect();
                let groups = groups.iter().filter(|(name, _)| expression.is_match(name));
                found.extend(groups.flat_map(|(_, group)| group));
                found.sort_unstable();
                found.dedup();
                if !found.is_empty() {
                    return Ok(found);
                }
                let hint = suggestion(key);
                Err(refuse(
                    option,
                    format!(
                        "robot `{robot}` has no {kind} whose whole name the expression `{key}` matches{hint}"
                    ),
                ))
            }
            Err(error) => {
                let reason = error.to_string();
                let reason = reason.lines().last().unwrap_or_default().to_owned();
                Err(refuse(
                    option,
                    format!("`{key}` is neither a {kind} nor a regular expression: {reason}"),
                ))
            }
        }
    }

    /// Says that an option has too many expressions.
    fn refuse_many<'k>(
        &self,
        option: &str,
        keys: impl Iterator<Item = &'k String>,
    ) -> Option<RobotError> {
        let is_name = |key: &str| self.places.contains_key(key) || self.groups.contains_key(key);
        let expressions = keys.filter(|key| !is_name(key) && !is_plain(key));
        let count = expressions.count();
        (count > MOST).then(|| {
            let what = format!(
                "has {count} regular expressions, may have {MOST}: name each {} instead",
                self.kind
            );
            refuse(option, what)
        })
    }

    /// Whether each is in a list.
    pub(crate) fn listed(
        &self,
        option: &str,
        list: &[String],
        errors: &mut Vec<RobotError>,
    ) -> Vec<bool> {
        let mut listed = vec![false; self.known.len()];
        if let Some(error) = self.refuse_many(option, list.iter()) {
            errors.push(error);
            return listed;
        }
        for key in list {
            match self.matching(option, key, errors.len()) {
                Ok(found) => found.into_iter().for_each(|i| listed[i] = true),
                Err(error) => errors.push(error),
            }
        }
        listed
    }

    /// The value that a table has for each.
    pub(crate) fn values<T: Copy + PartialEq>(
        &self,
        option: &str,
        table: &BTreeMap<String, T>,
        errors: &mut Vec<RobotError>,
    ) -> Vec<Option<T>> {
        if let Some(error) = self.refuse_many(option, table.keys()) {
            errors.push(error);
            return vec![None; self.known.len()];
        }
        let mut values: Vec<Option<(T, &str)>> = vec![None; self.known.len()];
        let is_name = |key: &String| self.places.contains_key(key.as_str());
        for (key, &value) in table.iter().filter(|(key, _)| !is_name(key)) {
            let found = match self.matching(option, key, errors.len()) {
                Ok(found) => found,
                Err(error) => {
                    errors.push(error);
                    continue;
                }
            };
            for i in found {
                let name = self.known[i];
                match values[i] {
                    Some((other, by)) if other != value && !table.contains_key(name) => {
                        errors.push(refuse(
                            option,
                            format!(
                                "expressions `{by}` and `{key}` both match {} `{name}`, with different values; give it \
                                 a value of its own",
                                self.kind
                            ),
                        ));
                    }
                    _ => values[i] = Some((value, key)),
                }
            }
        }
        for (value, name) in values.iter_mut().zip(&self.known) {
            if let Some(&own) = table.get(*name) {
                *value = Some((own, name));
            }
        }
        values.into_iter().map(|value| Some(value?.0)).collect()
    }
}

/// Whether it means nothing but itself as an expression.
fn is_plain(key: &str) -> bool {
    regex::escape(key).replace("\\-", "-") == key
}
