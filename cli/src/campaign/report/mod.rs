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
    fs::File,
    io::Read as _,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, bail};
use clap::Args;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use wbqp::suggestion::suggestion;
use wbqp_campaign::{
    Campaign, Plan,
    table::{Description, Table},
};
use wbqp_measures::number;
use wbqp_terminal::say;

use crate::output::{self, Existing};
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
    /// Replaces a file that is there; an older page of a campaign is replaced without
    #[arg(long)]
    force: bool,
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
        let out = match &self.out {
            Some(out) => out.clone(),
            None => self.table.with_extension("html"),
        };
        // Before the work; what the plan names is known later.
        let named = [Some(&self.table), self.plan.as_ref(), self.indices.as_ref()];
        output::refuse_input(&out, named.into_iter().flatten().map(PathBuf::as_path))?;
        let existing = Existing::of_force(self.force).or_own(&out, is_page);
        output::refuse_existing(&out, existing)?;
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
                let indices = read.with_context(|| path.display().to_string())?;
                check_indices(&indices, about, &factors)
                    .with_context(|| path.display().to_string())?;
                Some(indices)
            }
            None => None,
        };
        let campaign = self.campaign(about)?;
        let files = campaign.iter().flat_map(Campaign::files);
        output::refuse_input(&out, files.map(PathBuf::as_path))?;
        let beside = out.parent().unwrap_or(Path::new(""));
        let page = Page {
            about,
            runs: lines.count(),
            findings: &findings,
            plan: self.plan.as_deref().unwrap_or(Path::new("PLAN")),
            beside,
            indices: indices.as_ref(),
            matters: &matters(campaign.as_ref(), &findings),
        };
        let page = page.markup().into_string();
        output::write(&out, &page, existing)?;
        say!("{}", out.display());
        Ok(())
    }

    /// The plan's campaign, if a plan is named.
    ///
    /// # Errors
    /// A plan that is refused, or is not the table's.
    fn campaign(&self, about: &Description) -> Result<Option<Campaign>> {
        let Some(plan) = &self.plan else {
            return Ok(None);
        };
        let campaign = Campaign::new(Plan::from_file(plan)?)?;
        if campaign.fingerprint() != about.fingerprint {
            bail!(
                "{}: the plan, or what it names, is not what the table {} was made with",
                plan.display(),
                self.table.display()
            );
        }
        Ok(Some(campaign))
    }
}

/// What matters in the ticks of the plan's runs; or why that is not known: the page is as good without.
fn matters(campaign: Option<&Campaign>, findings: &[Findings]) -> Result<Vec<Matters>, String> {
    let Some(campaign) = campaign else {
        return Err(
            "With --plan and the plan's file, this says which weights and gains decide what the robot does where a \
             run goes worst."
                .to_owned(),
        );
    };
    let found = matters::of(campaign, findings);
    found.map_err(|error| format!("Not known: {error:#}."))
}

/// Refuses indices of what the table does not have: they are of another campaign.
fn check_indices(indices: &Indices, about: &Description, factors: &[String]) -> Result<()> {
    let factors: Vec<&str> = factors.iter().map(String::as_str).collect();
    let measures: Vec<&str> = about.measures.iter().map(|m| m.name.as_str()).collect();
    let of_factors = indices.values().flat_map(BTreeMap::keys);
    let of_measures = indices.keys().map(|name| ("measure", name, &measures));
    for (kind, name, known) in of_measures.chain(of_factors.map(|name| ("factor", name, &factors)))
    {
        if !known.contains(&name.as_str()) {
            bail!(
                "the table has no {kind} `{name}`{}; are these the indices of another campaign?",
                suggestion(name, known)
            );
        }
    }
    Ok(())
}

/// What the title of every page begins with.
const TITLE: &str = "wbqp: campaign ";

/// The most of a file that its title is looked for in, bytes.
const HEAD: u64 = 1024;

/// Whether a file is a page that this wrote before.
fn is_page(file: &Path) -> bool {
    let mut head = Vec::new();
    let read =
        wbqp::input::open(file).and_then(|file: File| file.take(HEAD).read_to_end(&mut head));
    let head = String::from_utf8_lossy(&head);
    read.is_ok() && head.starts_with("<!DOCTYPE html>") && head.contains(&format!("<title>{TITLE}"))
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
                    title { (TITLE) (about.name) }
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
