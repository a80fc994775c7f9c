//! Texts that nobody would write: changed files and junk, from a seed.

use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Values that may stand where a file has another.
const VALUES: &[&str] = &[
    "0",
    "-1",
    "1",
    "1e-320",
    "1e300",
    "-1e300",
    "1e9",
    "1e400",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551616",
    "4294967295",
    "4294967296",
    "0x7fffffffffffffff",
    "nan",
    "inf",
    "-inf",
    "true",
    "1979-05-27T07:32:00Z",
    "\"\"",
    "\"tip\"",
    "\"ä🦀\"",
    "\"\\u0000\"",
    "\"tool\"",
    "\"arm_roll\"",
    "[]",
    "{}",
    "[1]",
    "[0, 0, 0]",
    "[nan, nan, nan]",
    "[1e300, 1e300, 1e300]",
    "[[1]]",
    "[\"x\", 1]",
    "{ type = \"hold\" }",
    "{ type = \"hold\", value = [] }",
    "{ type = \"min_jerk\", to = [0, 0, 0], duration = 1e-300 }",
    "{ type = \"waypoints\", points = [] }",
    "{ exact = 1e300 }",
    "\"hard\"",
    "\"soft\"",
];

/// Pieces of text that break a file.
const PIECES: &[&str] = &[
    "",
    "\n",
    "\r",
    "\"",
    "'''",
    "]",
    "}",
    "=",
    "#",
    ".",
    ",",
    "\0",
    "\u{feff}",
    "[[task]]",
    "[[task.reference]]",
    "[task]",
    "[robot]",
    "[[constraint]]",
    "[[contact]]",
    "[controller]",
    "<",
    "/>",
    "&amp;",
    "&x;",
    "<!--",
    "<link name=\"x\"/>",
    "continuous",
    "floating",
    "fixed",
    "0 0 0",
    "1 2",
];

/// Keys that a line may get.
const KEYS: &[&str] = &[
    "name",
    "type",
    "weight",
    "kp",
    "kd",
    "ki",
    "reference",
    "contact",
    "frame",
    "kind",
    "hardness",
    "transition",
    "active",
    "level",
    "sides",
    "options",
    "file",
    "rotors",
    "joints",
    "rate",
    "hover",
    "points",
    "value",
    "mass",
    "xyz",
    "rpy",
    "axis",
    "limit",
];

/// A text changed in one to four places; `other` is a text to take lines from.
pub fn mutated(text: &str, other: &str, rng: &mut ChaCha8Rng) -> String {
    let mut text = text.to_owned();
    // Mostly one: deeper checks are reached.
    for _ in 0..[1, 1, 1, 1, 2, 2, 3, 4][rng.random_range(0..8)] {
        text = changed(&text, other, rng);
    }
    text
}

fn changed(text: &str, other: &str, rng: &mut ChaCha8Rng) -> String {
    let piece = pick(PIECES, rng);
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    if lines.is_empty() {
        return piece.to_owned();
    }
    let i = rng.random_range(0..lines.len());
    let line = lines[i].clone();
    match rng.random_range(0..16) {
        // The file stays well-formed.
        0..=3 => {
            if let Some((key, _)) = line.split_once('=') {
                lines[i] = format!("{key}= {}", pick(VALUES, rng));
            }
        }
        4..=6 => {
            let word = word(&line, rng);
            lines[i].replace_range(word, pick(VALUES, rng));
        }
        7 => {
            let word = word(&line, rng);
            lines[i].replace_range(word, piece);
        }
        8 => {
            if let Some((_, value)) = line.split_once('=') {
                lines[i] = format!("{} ={value}", pick(KEYS, rng));
            }
        }
        9 => drop(lines.remove(i)),
        10 => lines.insert(rng.random_range(0..=i), line),
        11 => {
            let j = rng.random_range(0..lines.len());
            lines.swap(i, j);
        }
        12 => {
            let theirs: Vec<&str> = other.lines().collect();
            if !theirs.is_empty() {
                let from = rng.random_range(0..theirs.len());
                let until = (from + rng.random_range(1..8)).min(theirs.len());
                let taken = theirs[from..until].iter().map(|line| (*line).to_owned());
                lines.splice(i..i, taken);
            }
        }
        13 => {
            let at = boundary(&line, rng);
            lines[i].insert_str(at, piece);
        }
        14 => {
            let at = boundary(&line, rng);
            lines[i].truncate(at);
        }
        // Depth costs stack in recursive parsers.
        _ => {
            let depth = 1 << rng.random_range(0..10);
            let (open, close) = [("[", "]"), ("{a=", "}"), ("(", ")")][rng.random_range(0..3)];
            let key = pick(KEYS, rng);
            let nested = format!("{key} = {}{}", open.repeat(depth), close.repeat(depth));
            lines.insert(i, nested);
        }
    }
    lines.join("\n") + "\n"
}

/// A text of arbitrary bytes. What is no UTF-8 becomes replacement characters: a file with it is refused before.
pub fn junk(rng: &mut ChaCha8Rng) -> String {
    const MARKS: &[u8] = b"[]{}=\"'#.,\n<>/&-+0123456789eEx_ ";
    let length = rng.random_range(0..400);
    let bytes: Vec<u8> = (0..length)
        .map(|_| match rng.random_range(0..3) {
            0 => rng.random(),
            1 => MARKS[rng.random_range(0..MARKS.len())],
            _ => rng.random_range(b' '..=b'~'),
        })
        .collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

fn pick<'a>(list: &[&'a str], rng: &mut ChaCha8Rng) -> &'a str {
    list[rng.random_range(0..list.len())]
}

fn boundary(line: &str, rng: &mut ChaCha8Rng) -> usize {
    let mut at = rng.random_range(0..=line.len());
    while !line.is_char_boundary(at) {
        at -= 1;
    }
    at
}

/// Start and end of a random word between quotes, blanks or brackets.
fn word(line: &str, rng: &mut ChaCha8Rng) -> std::ops::Range<usize> {
    let ends = |c: char| c.is_whitespace() || "\"<>/=[]{},".contains(c);
    let at = boundary(line, rng);
    let start = line[..at]
        .char_indices()
        .rfind(|(_, c)| ends(*c))
        .map_or(0, |(i, c)| i + c.len_utf8());
    let end = line[at..].find(ends).map_or(line.len(), |i| at + i);
    start..end
}
