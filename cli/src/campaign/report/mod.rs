//! `wbqp campaign report`: a page of what a campaign found.

mod figures;
mod findings;
mod lines;
mod matters;
mod reasons;
mod section;
mod statistics;

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, bail};
use clap::Args;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use wbqp_campaign::{
    Campaign, Plan,
    table::{Description, Table},
};
use wbqp_measures::number;
use wbqp_terminal::say;

use findings::Findings;
use lines::Lines;
use matters::Matters;

const STYLE: &str = include_str!("style.css");

/// Writes a page: which share of the runs holds, which factor breaks what, and the worst runs
#[derive(Args, Debug)]
pub(super) struct Arguments {
    /// The table of a campaign, or of one of its shards
    #[arg(value_name = "TABLE")]
    table: PathBuf,
    /// The page; default: beside the table
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// The plan's file: for what matters in the ticks of its runs, and the commands that do one again
    #[arg(long, value_name = "PLAN")]
    plan: Option<PathBuf>,
    /// Sobol's indices as the Python package writes them: measure, factor, first-order and total index
    #[arg(long, value_name = "JSON")]
    indices: Option<PathBuf>,
}

/// By measure and factor: first-order and total index.
type Indices = BTreeMap<String, BTreeMap<String, [f64; 2]>>;

impl Arguments {
    pub(super) fn run(&self) -> Result<()> {
        let lines = Lines::read(Table::open(&self.table)?)?;
        let about = lines.description();
        let factors: Vec<String> = about.factors.iter().map(|f| f.name.clone()).collect();
        let variants = 0..about.variants.len();
        let findings: Vec<Findings> = variants
            .map(|variant| Findings::of(&lines.of(variant), &factors, &about.measures))
            .collect::<Result<_>>()?;
        let indices: Option<Indices> = match &self.indices {
            Some(path) => {
                let text = wbqp::input::read_text(path);
                let text = text.with_context(|| path.display().to_string())?;
                let read = wbqp::serde_json::from_str(&text);
                Some(read.with_context(|| path.display().to_string())?)
            }
            None => None,
        };
        let out = match &self.out {
            Some(out) => out.clone(),
            None => self.table.with_extension("html"),
        };
        let beside = out.parent().unwrap_or(Path::new(""));
        let page = Page {
            about,
            runs: lines.count(),
            findings: &findings,
            plan: self.plan.as_deref().unwrap_or(Path::new("PLAN")),
            beside,
            indices: indices.as_ref(),
            matters: &self.matters(about, &findings)?,
        };
        let page = page.markup().into_string();
        fs::write(&out, page).with_context(|| out.display().to_string())?;
        say!("{}", out.display());
        Ok(())
    }

    /// What matters in the ticks of the plan's runs; or why that is not known: the page is as good without.
    ///
    /// # Errors
    /// A plan that was named and is refused, or is not the table's.
    fn matters(
        &self,
        about: &Description,
        findings: &[Findings],
    ) -> Result<Result<Vec<Matters>, String>> {
        let Some(plan) = &self.plan else {
            return Ok(Err(
                "With --plan and the plan's file, this says which weights and gains decide what the robot does where a \
                 run goes worst."
                    .to_owned(),
            ));
        };
        let campaign = Campaign::new(Plan::from_file(plan)?)?;
        if campaign.fingerprint() != about.fingerprint {
            bail!(
                "{}: the plan, or what it names, is not what the table {} was made with",
                plan.display(),
                self.table.display()
            );
        }
        let found = matters::of(&campaign, findings);
        Ok(found.map_err(|error| format!("Not known: {error:#}.")))
    }
}

/// What is on the page.
struct Page<'a> {
    about: &'a Description,
    runs: usize,
    /// By variant.
    findings: &'a [Findings],
    /// The plan's file.
    plan: &'a Path,
    /// The page's folder.
    beside: &'a Path,
    indices: Option<&'a Indices>,
    matters: &'a Result<Vec<Matters>, String>,
}

impl Page<'_> {
    fn markup(&self) -> Markup {
        let about = self.about;
        html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    title { "wbqp: campaign " (about.name) }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    h1 { "Campaign " (about.name) }
                    p.lead {
                        (self.runs) " runs of " (about.points) " points in " (about.variants.len())
                        " variants. A run holds if it reaches its end and every measure that counts is within what is \
                         accepted. One that is refused was never simulated, and is in no share. Intervals are \
                         Wilson's, with a confidence of 95 %."
                    }
                    (section::overview(self.findings))
                    @for found in self.findings {
                        (section::section(found, about, self.plan, self.beside))
                    }
                    (matters::section(self.matters))
                    @if let Some(indices) = self.indices { (indices_section(indices)) }
                    h2 { "Plan" }
                    pre { (about.plan) }
                    footer {
                        "wbqp " (env!("CARGO_PKG_VERSION")) ", fingerprint "
                        code { (about.fingerprint.chars().take(16).collect::<String>()) }
                        ". The same plan gives the same table on every machine and in any number of shards."
                    }
                }
            }
        }
    }
}

fn indices_section(indices: &Indices) -> Markup {
    html! {
        h2 { "Sobol's indices" }
        p { "Share of a measure's variance that a factor explains alone (first order), and with all others (total)." }
        @for (measure, factors) in indices {
            h3 { (measure) }
            div.scroll { table {
                thead { tr { th { "factor" } th { "first order" } th { "total" } } }
                tbody { @for (factor, [first, total]) in factors {
                    tr { td { (factor) } td.number { (number(*first)) } td.number { (number(*total)) } }
                } }
            } }
        }
    }
}
