//! The problem of a controller's last tick, as a person reads it.

use std::fmt;

use wbqp::{Controller, qp::RowId};

/// Displays variables, rows and active set of the last problem by name. Numbers in SI units; rows as their owners wrote
/// them, before variables were substituted; `*` marks what is at a limit and pushes against it.
#[derive(Clone, Copy, Debug)]
pub struct ProblemTable<'c> {
    controller: &'c Controller,
    matrices: Matrices,
}

/// Whether the coefficients are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Matrices {
    /// Names, limits, values and multipliers alone.
    #[default]
    Hidden,
    /// The cost's and the rows' coefficients too.
    Shown,
}

impl<'c> ProblemTable<'c> {
    /// The problem of the last tick that had one.
    pub fn new(controller: &'c Controller, matrices: Matrices) -> Self {
        Self {
            controller,
            matrices,
        }
    }

    fn row_name(&self, row: RowId) -> (String, &'c str) {
        self.controller.row(row).map_or_else(
            || (format!("row {}", row.index()), ""),
            |info| (info.to_string(), info.unit.as_str()),
        )
    }
}

impl fmt::Display for ProblemTable<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (qp, solution) = (self.controller.problem(), self.controller.solution());
        let (n, m) = (qp.n(), qp.m());
        writeln!(
            f,
            "problem: {n} variables, {m} rows; objective {:.9e}",
            qp.objective(&solution.x[..n])
        )?;
        let table = self.controller;
        let variables = qp.vars().iter().map(|&var| {
            table.variable(var).map_or_else(
                || (format!("variable {}", var.index()), ""),
                |info| (info.to_string(), info.unit.as_str()),
            )
        });
        let lines: Vec<Line<'_>> = variables
            .enumerate()
            .map(|(j, (name, unit))| Line {
                name,
                unit,
                lower: qp.lower()[j],
                value: solution.x[j],
                upper: qp.upper()[j],
                multiplier: solution.z[j],
            })
            .collect();
        write_lines(f, "variables", &lines)?;
        let lines: Vec<Line<'_>> = (0..m)
            .map(|i| {
                let (name, unit) = self.row_name(qp.rows()[i]);
                let terms = qp.row(i).iter().zip(&solution.x);
                let value: f64 = terms.map(|(a, x)| a * x).sum();
                let constant = table.row_constant(i);
                Line {
                    name,
                    unit,
                    lower: qp.row_lower()[i] + constant,
                    value: value + constant,
                    upper: qp.row_upper()[i] + constant,
                    multiplier: solution.y[i],
                }
            })
            .collect();
        write_lines(f, "rows", &lines)?;
        let report = self.controller.report();
        writeln!(f, "\nactive set: {} of the limits", report.active.len())?;
        for active in &report.active {
            let (name, unit) = self.row_name(active.row);
            let (side, multiplier) = (active.side.as_str(), active.multiplier);
            writeln!(
                f,
                "  {name}, {side} limit, multiplier {multiplier:.6e} 1/{unit}"
            )?;
        }
        if self.matrices == Matrices::Shown {
            write_matrix(
                f,
                "H (cost ½ xᵀ H x + gᵀ x), one row per variable",
                qp.h(),
                n,
            )?;
            write_matrix(f, "g", qp.g(), n)?;
            writeln!(f, "\nA, one line per row")?;
            for i in 0..m {
                write_row(f, qp.row(i))?;
            }
        }
        Ok(())
    }
}

struct Line<'a> {
    name: String,
    unit: &'a str,
    lower: f64,
    value: f64,
    upper: f64,
    multiplier: f64,
}

fn write_lines(f: &mut fmt::Formatter<'_>, title: &str, lines: &[Line<'_>]) -> fmt::Result {
    let width = |text: &str| text.chars().count();
    let name_width = lines.iter().map(|l| width(&l.name)).max().unwrap_or(0);
    let name_width = name_width.max(width(title));
    let unit_width = lines
        .iter()
        .map(|l| width(l.unit))
        .max()
        .unwrap_or(0)
        .max(4);
    writeln!(
        f,
        "\n  {title:name_width$}  {:unit_width$}  {:>13}  {:>15}  {:>13}  {:>13}",
        "unit", "lower", "value", "upper", "multiplier"
    )?;
    for line in lines {
        let mark = if line.multiplier == 0.0 { ' ' } else { '*' };
        writeln!(
            f,
            "{mark} {:name_width$}  {:unit_width$}  {:>13}  {:>15.9}  {:>13}  {:>13}",
            line.name,
            line.unit,
            short(line.lower),
            line.value,
            short(line.upper),
            if line.multiplier == 0.0 {
                String::new()
            } else {
                format!("{:.4e}", line.multiplier)
            },
        )?;
    }
    Ok(())
}

fn short(limit: f64) -> String {
    if limit.is_infinite() {
        String::new()
    } else {
        format!("{limit:.6}")
    }
}

fn write_matrix(f: &mut fmt::Formatter<'_>, title: &str, a: &[f64], n: usize) -> fmt::Result {
    writeln!(f, "\n{title}")?;
    a.chunks(n.max(1)).try_for_each(|row| write_row(f, row))
}

fn write_row(f: &mut fmt::Formatter<'_>, row: &[f64]) -> fmt::Result {
    let numbers: Vec<String> = row.iter().map(|a| format!("{a:.6e}")).collect();
    writeln!(f, "  {}", numbers.join(" "))
}
