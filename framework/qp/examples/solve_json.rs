//! Solves the problems on standard input, one JSON object per line, and prints one line of JSON for each.
//!
//! ```text
//! {"n":1, "m":0, "H":[2.0], "g":[-2.0], "A":[], "row_lower":[], "row_upper":[], "lower":["-inf"], "upper":[0.5]}
//! {"status":"optimal","x":[0.5],"y":[],"z":[1.0],"iterations":2,"microseconds":3.1}
//! ```
//! `H` (n × n) and `A` (m × n) are row-major; numbers that JSON lacks are the strings "inf", "-inf" and "nan". Every
//! problem is solved from a cold start, with at most `max_iterations` if it has that key. `x` is the ray if the status
//! is `unbounded`; `y` and `z` are the certificate if it is `infeasible`. A line that is no problem has the status
//! `invalid` and a `message`.

use std::{
    io::{self, BufRead, Write},
    time::Instant,
};

use serde_json::{Value, json};
use wbqp_qp::{ActiveSet, Budget, Qp, QpSolver, Solution, Status};

fn main() -> io::Result<()> {
    let mut out = io::stdout().lock();
    for line in io::stdin().lock().split(b'\n') {
        let line = line?;
        if line.trim_ascii().is_empty() {
            continue;
        }
        let answer = match solve(&line) {
            Ok(answer) => answer,
            Err(message) => json!({
                "status": Status::Invalid.as_str(), "x": [], "y": [], "z": [],
                "iterations": 0, "microseconds": 0.0, "message": message,
            }),
        };
        writeln!(out, "{answer}")?;
        out.flush()?;
    }
    Ok(())
}

fn solve(line: &[u8]) -> Result<Value, String> {
    let problem: Value = serde_json::from_slice(line).map_err(|error| error.to_string())?;
    let list = |key: &str| -> Result<Vec<f64>, String> {
        let list = problem[key]
            .as_array()
            .ok_or(format!("`{key}` is no list"))?;
        let number = |value| number(value).ok_or(format!("`{key}` holds {value}, no number"));
        list.iter().map(number).collect()
    };
    let [h, g, a] = [list("H")?, list("g")?, list("A")?];
    let rows = (list("row_lower")?, list("row_upper")?);
    let bounds = (list("lower")?, list("upper")?);
    for (key, found) in [("n", g.len()), ("m", rows.0.len())] {
        let stated = problem.get(key).map_or(Some(found as u64), Value::as_u64);
        if stated != Some(found as u64) {
            return Err(format!(
                "`{key}` is {}, but the lists have {found}",
                problem[key]
            ));
        }
    }
    let qp = Qp::dense(&h, &g, &a, (&rows.0, &rows.1), (&bounds.0, &bounds.1))
        .map_err(|error| error.to_string())?;
    let mut solver = ActiveSet::default();
    if let Some(cap) = problem.get("max_iterations") {
        let number = cap.as_u64().and_then(|cap| u32::try_from(cap).ok());
        let number =
            number.ok_or_else(|| format!("`max_iterations` is {cap}, no number of them"))?;
        solver.max_iterations = Some(number);
    }
    solver
        .bind(qp.capacity())
        .map_err(|error| error.to_string())?;
    let mut solution = Solution::new(qp.capacity());
    let start = Instant::now();
    let status = solver
        .solve(&qp, Budget::Configured, &mut solution)
        .map_err(|error| error.to_string())?;
    let microseconds = start.elapsed().as_secs_f64() * 1e6;
    let mut answer = json!({
        "status": status.as_str(), "x": solution.x, "y": solution.y, "z": solution.z,
        "iterations": solution.iterations, "microseconds": microseconds,
    });
    if let Some(defect) = solution.defect {
        answer["message"] = defect.to_string().into();
    }
    Ok(answer)
}

fn number(value: &Value) -> Option<f64> {
    match value.as_str() {
        None => value.as_f64(),
        Some("inf" | "+inf" | "Infinity") => Some(f64::INFINITY),
        Some("-inf" | "-Infinity") => Some(f64::NEG_INFINITY),
        Some("nan" | "NaN") => Some(f64::NAN),
        Some(_) => None,
    }
}
