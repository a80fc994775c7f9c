//! Saving: what is loaded, saved, loaded and saved again is the same text; and loading never panics.

use wbqp::{
    config::ControllerConfig,
    plugin::{Entry, Hardness, PerRow},
    settings::Settings,
    toml,
};

use crate::plugins::{HEAD, load};

const FULL: &str = r#"
# Everything at once.
[controller]
rate = 1_000
formulation = "explicit"
regularisation = 1e-12
velocity_leak = 0.25

[robot]
type = "test.robot"
file = 'C:\robots\"a".urdf'

[solver]
type = "clarabel"
tolerance = 1e-10

[[contact]]
name = "wall"
frame = "tip"
kind = "normal"
surface.normal = [-1, 0, 0]
surface.x_axis = [0, 1, 0]
force_max = 1e14
active = true

[[contact]]
name = "Boden unter \"links\""
frame = "foot"
kind = "point"
[contact.surface]
normal = [0, 0, 1]
x_axis = [1, 0, 0]
origin = [0.1, -2e-7, 1e10]

[[task]]
gain = 0.1
hardness = "hard"
type = "test.hold"
name = "first"
frames = ["a", "ü\n\tx"]

[[task]]
name = "second"
type = "test.follow"
weight = [1, 2.5, 0]
transition = 0.5
active = false
[task.reference]
type = "test.ramp"
to = [1, 2]
duration = 0.3333333333333333

[[task]]
name = "third"
type = "test.many"
weight = 3
hardness = { exact = 7 }
list = [{ type = "test.ramp", to = [], duration = 1 }]
[task.map]
"a key" = { type = "test.ramp", to = [-0.0], duration = 1 }
b = { type = "test.ramp", to = [1], duration = 1 }

[[task]]
name = "fourth"
type = "test.hold"
weight = 0
gain = 2
nested = { a = 1, b = 2, c = 3 }

[[constraint]]
name = "soft"
type = "test.limit"
weight = 1e3
hardness = "soft"
upper = 4

[[constraint]]
name = "hard"
type = "test.limit"
upper = -4
"#;

fn saved(source: &str) -> String {
    match load(source) {
        Ok(config) => config.to_toml().expect("can be written"),
        Err(errors) => panic!("{errors}\n{source}"),
    }
}

#[test]
fn load_save_load_save_is_byte_equal() {
    for source in [HEAD, FULL] {
        let once = saved(source);
        assert_eq!(once, saved(&once));
    }
}

#[test]
fn saved_text_is_flat_and_in_the_order_people_write() {
    let text = saved(FULL);
    let expected = "[[task]]
name = \"second\"
type = \"test.follow\"
weight = [1.0, 2.5, 0.0]
active = false
transition = 0.5
reference = { type = \"test.ramp\", to = [1.0, 2.0], duration = 0.3333333333333333 }
";
    assert!(text.contains(expected), "{text}");
    assert!(
        text.ends_with("[[constraint]]\nname = \"hard\"\ntype = \"test.limit\"\nupper = -4.0\n")
    );
}

#[test]
fn a_configuration_made_in_code_loads_again() {
    let parts = load(FULL).expect("loads");
    let mut config = ControllerConfig::new(Settings::at_rate(400.0), parts.robot);
    config.tasks = parts.tasks;
    for task in &mut config.tasks {
        task.weight = PerRow::Each(vec![1e-3, 1e100]);
        task.hardness = Hardness::Hard;
    }
    let constraint = parts.constraints.into_iter().next().expect("has one");
    config.constraints = vec![Entry::new(
        "c",
        2.0,
        Hardness::Exact(0.5),
        constraint.plugin,
    )];
    let text = config.to_toml().expect("can be written");
    let again = load(&text).expect("loads");
    assert_eq!(again.tasks[0].weight, config.tasks[0].weight);
    assert_eq!(again.constraints[0].hardness, Hardness::Exact(0.5));
    assert_eq!(again.to_toml().expect("can be written"), text);
}

/// All numbers of a text that is a table, by their bits.
fn numbers(text: &str) -> Vec<u64> {
    fn collect(value: &toml::Value, into: &mut Vec<u64>) {
        match value {
            toml::Value::Float(number) => into.push(number.to_bits()),
            toml::Value::Array(values) => values.iter().for_each(|value| collect(value, into)),
            toml::Value::Table(table) => table.values().for_each(|value| collect(value, into)),
            _ => {}
        }
    }
    let mut all = Vec::new();
    let table: toml::Table = toml::from_str(text).expect("is TOML");
    table.values().for_each(|value| collect(value, &mut all));
    all
}

/// The nearest numbers that are refused and the furthest that are taken, with what is said of the former. HEAD has
/// 250 Hz.
#[test]
fn the_furthest_numbers_that_are_taken_come_back_to_the_bit() {
    const CONTACT: &str = "[[contact]]\nname = 'c'\nframe = 'f'\nkind = 'point'\n";
    const SURFACE: &str = "surface.normal = [0, 0, 1]\nsurface.x_axis = [1, 0, 0]\n";
    const HOLD: &str = "[[task]]\nname = 't'\ntype = 'test.hold'\ngain = 1\n";
    const MANY: &str = "[[task]]\nname = 't'\ntype = 'test.many'\nweight = 1\n";
    const RAMP: &str = "[[task]]\nname = 't'\ntype = 'test.follow'\nweight = 1\n";
    let contact = |key: &str| format!("{HEAD}{CONTACT}{SURFACE}{key}\n");
    let hold = |key: &str| format!("{HEAD}{HOLD}{key}\n");
    let tiny = f64::from_bits(1);
    let no_robot = "no robot has more than";
    for (text, taken, beyond) in [
        (contact("force_max = @"), [tiny, 1e14], no_robot),
        (contact("free_force_limit = @"), [tiny, 1e14], no_robot),
        (contact("friction = @"), [tiny, 1e12], no_robot),
        (contact("offset = [@, 0, -0.0]"), [-1e10, 1e10], no_robot),
        (
            contact("surface.origin = [0.1, @, 0]"),
            [-1e10, 1e10],
            no_robot,
        ),
        (
            contact("transition = @"),
            [1e-9, 3.2e13],
            "shorter than any",
        ),
        (
            hold("weight = @"),
            [1e-100, 1e100],
            "products with it are no numbers",
        ),
        (
            hold("weight = [1, @]"),
            [1e-100, 1e100],
            "products with it are no numbers",
        ),
        (
            hold("weight = 1\ntransition = @"),
            [1e-9, 3.2e13],
            "longer than any run",
        ),
        (
            format!("{HEAD}{MANY}damping = @\n"),
            [tiny, 5e8],
            "a loop at 250 Hz",
        ),
        (
            format!("{HEAD}{MANY}stiffness = @\n"),
            [tiny, 2.5e11],
            "a loop at 250 Hz",
        ),
        // Without a unit there is nothing to say about a number.
        (
            format!("{HEAD}{RAMP}reference = {{ type = 'test.ramp', to = [@], duration = 1 }}\n"),
            [-f64::MAX, f64::MAX],
            "",
        ),
        (
            hold("weight = 1\nnested = { a = @, b = 0, c = 0 }"),
            [tiny, f64::MAX],
            "",
        ),
    ] {
        let with = |number: f64| text.replace('@', &format!("{number:e}"));
        for number in taken.into_iter().chain([0.1 * taken[1], 1.0 / 3.0]) {
            let once = saved(&with(number));
            let found = numbers(&once);
            assert!(found.contains(&number.to_bits()), "{number:e}:\n{once}");
            assert_eq!(once, saved(&once));
        }
        let mut said = String::new();
        for number in [taken[0].next_down(), taken[1].next_up()] {
            // The smallest positive number has none beside it but zero.
            if number == 0.0 || number.is_infinite() {
                continue;
            }
            let errors = load(&with(number)).expect_err(&with(number)).to_string();
            assert!(errors.contains(&format!(": is {number:e}")), "{errors}");
            said += &errors;
        }
        assert!(said.contains(beyond), "{said}");
    }
}

/// No number of a file means these; what is made in code is taken at its word until it comes from a file.
#[test]
fn numbers_without_a_meaning_are_refused_in_words() {
    for (old, new, said) in [
        (
            "force_max = 1e14",
            "force_max = inf",
            "contact[0] `wall`: force_max: is inf",
        ),
        (
            "-2e-7, 1e10]",
            "-2e-7, 1e300]",
            "surface.origin[2]: is 1e300 m: no robot has more than 1e4",
        ),
        (
            "weight = 3\n",
            "weight = 1.7976931348623157e308\n",
            "task[2] `third` (test.many): weight: is 1.7976931348623157e308",
        ),
    ] {
        assert!(FULL.contains(old), "{old}");
        let errors = load(&FULL.replacen(old, new, 1)).expect_err(new);
        assert!(errors.to_string().contains(said), "{errors}");
    }
    let mut config = load(FULL).expect("loads");
    config.tasks[0].weight = PerRow::Each(vec![1e-3, f64::MAX]);
    let text = config.to_toml().expect("can be written");
    let errors = load(&text).expect_err("has no meaning").to_string();
    assert!(
        errors.contains("weight: is 1.7976931348623157e308"),
        "{errors}"
    );
}

/// Knuth's generator: the same inputs everywhere.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 33) as usize % n.max(1)
    }
}

/// Every mutated file loads or has errors, and each error has a place in the file. What loads can be saved.
#[test]
fn mutated_files_do_not_panic() {
    let pieces = [
        "\"",
        "'",
        "[",
        "]",
        "[[",
        "]]",
        "{",
        "}",
        "=",
        ",",
        ".",
        "\n",
        "#",
        "-1",
        "nan",
        "inf",
        "true",
        "\"x\"",
        "[]",
        "{}",
        "1e999",
        "99999999999999999999",
        "1979-05-27",
        "ä",
        "\u{0}",
        "\r\n",
        "name",
        "type",
        "level = 1\n",
        "[[task]]\n",
        "[task.reference]\n",
        "weight = ",
        "hardness = {exact = 1}\n",
        "\"\"\"",
        "test.ramp",
    ];
    let mut random = Random(7);
    let (mut loaded, mut refused) = (0, 0);
    for _ in 0..6000 {
        let mut text: Vec<char> = FULL.chars().collect();
        for _ in 0..=random.below(3) {
            let at = random.below(text.len());
            let end = (at + random.below(12)).min(text.len());
            match random.below(3) {
                0 => drop(text.drain(at..end)),
                1 => {
                    let copy: Vec<char> = text[at..end].to_vec();
                    let to = random.below(text.len());
                    text.splice(to..to, copy).for_each(drop);
                }
                _ => {
                    let piece = pieces[random.below(pieces.len())];
                    text.splice(at..end.min(at + random.below(3)), piece.chars())
                        .for_each(drop);
                }
            }
        }
        let text: String = text.into_iter().collect();
        match load(&text) {
            Ok(config) => {
                loaded += 1;
                let once = config.to_toml().expect("can be written");
                assert_eq!(once, saved(&once));
            }
            Err(errors) => {
                refused += 1;
                assert!(errors.iter().count() > 0);
                let lines = text.matches('\n').count() + 1;
                for error in &errors {
                    let (line, column) = error
                        .place
                        .as_ref()
                        .and_then(|place| place.position)
                        .unwrap_or((1, 1));
                    assert!(
                        (1..=lines).contains(&line) && column >= 1,
                        "{error}\n{text}"
                    );
                    assert!(
                        !error.to_string().contains("internal error"),
                        "{error}\n{text}"
                    );
                }
            }
        }
    }
    assert!(
        loaded > 100 && refused > 1000,
        "{loaded} loaded, {refused} refused"
    );
}
