//! A campaign as an array of jobs on a Slurm cluster.

use std::{
    env,
    fmt::Write as _,
    fs,
    num::{NonZeroU32, NonZeroU64, NonZeroUsize},
    path::{Path, PathBuf, absolute},
    process::Command,
};

use anyhow::{Context, Result, bail};
use clap::Args;
use wbqp_campaign::Plan;
use wbqp_terminal::{
    output::{self, Existing},
    say,
};

/// Writes and submits an array of Slurm jobs, one per shard, and a job that merges their tables
///
/// Every node must see this program, the plan and the directory at the same paths. A job that was killed or preempted
/// is queued again, and goes on where it was.
#[derive(Args, Debug)]
pub(super) struct Arguments {
    /// The plan
    #[arg(value_name = "PLAN")]
    plan: PathBuf,
    /// Number of shards, a job each
    #[arg(long, value_name = "N")]
    shards: NonZeroU32,
    /// Only the first runs of the plan
    #[arg(long, value_name = "N")]
    limit: Option<NonZeroU64>,
    /// Directory for scripts, tables and what the jobs say
    #[arg(long, value_name = "DIR", default_value = "out/campaign")]
    out: PathBuf,
    /// Cores of a job
    #[arg(long, value_name = "N", default_value = "1")]
    cpus: NonZeroUsize,
    /// Only write the scripts
    #[arg(long)]
    dry_run: bool,
    /// Options for sbatch, behind `--`: `-- --partition=long --time=4:00:00`
    #[arg(last = true, value_name = "SBATCH OPTION")]
    sbatch: Vec<String>,
}

impl Arguments {
    pub(super) fn run(&self) -> Result<()> {
        // What is wrong with the plan is better known before than from a hundred jobs.
        let plan = Plan::from_file(&self.plan)?;
        let out = absolute(&self.out)?;
        fs::create_dir_all(&out).with_context(|| out.display().to_string())?;
        let array = write(&out, "shards.sbatch", &self.shards_script(&plan, &out)?)?;
        let merge = write(&out, "merge.sbatch", &self.merge_script(&plan, &out)?)?;
        if self.dry_run {
            say!("scripts: {} and {}", array.display(), merge.display());
            return Ok(());
        }
        let job = submit(&array, &[])?;
        let after = format!("--dependency=afterok:{job}");
        let merge = submit(&merge, &[&after])?;
        let shards = self.shards;
        say!("submitted job {job} with {shards} shards, and job {merge} that merges their tables");
        Ok(())
    }

    fn shards_script(&self, plan: &Plan, out: &Path) -> Result<String> {
        let mut script = head(plan.name(), out, "shard-%a.log")?;
        let (shards, cpus) = (self.shards, self.cpus);
        writeln!(script, "#SBATCH --array=1-{shards}")?;
        writeln!(
            script,
            "#SBATCH --ntasks=1\n#SBATCH --cpus-per-task={cpus}\n#SBATCH --requeue"
        )?;
        for option in &self.sbatch {
            writeln!(script, "#SBATCH {option}")?;
        }
        let program = env::current_exe()?;
        let file = absolute(&self.plan)?;
        let limit = self
            .limit
            .map_or(String::new(), |n| format!(" --limit {n}"));
        writeln!(
            script,
            "exec {} campaign {} --shard \"$SLURM_ARRAY_TASK_ID/{shards}\" --jobs {cpus}{limit} --out {}",
            quoted(&program)?,
            quoted(&file)?,
            quoted(out)?
        )?;
        Ok(script)
    }

    fn merge_script(&self, plan: &Plan, out: &Path) -> Result<String> {
        let mut script = head(&format!("{}-merge", plan.name()), out, "merge.log")?;
        for option in &self.sbatch {
            writeln!(script, "#SBATCH {option}")?;
        }
        let table = out.join(format!("{}.parquet", one_word(plan.name())));
        let program = env::current_exe()?;
        let (program, directory, table) = (quoted(&program)?, quoted(out)?, quoted(&table)?);
        writeln!(
            script,
            "exec {program} campaign merge {directory} --out {table}"
        )?;
        Ok(script)
    }
}

/// A job that is queued again reads its script anew: it finds the old one or the new one, never half of one.
fn write(out: &Path, name: &str, text: &str) -> Result<PathBuf> {
    let path = out.join(name);
    output::write(&path, text, Existing::IsReplaced)?;
    Ok(path)
}

fn head(name: &str, out: &Path, log: &str) -> Result<String> {
    let mut head = "#!/bin/sh\n".to_owned();
    writeln!(head, "#SBATCH --job-name={}", one_word(name))?;
    let log = out.join(log);
    let log = log
        .to_str()
        .context("the directory's name is not Unicode")?;
    if log.contains(char::is_whitespace) {
        bail!(
            "--out {}: Slurm takes no file with a space in its name",
            out.display()
        );
    }
    writeln!(head, "#SBATCH --output={log}")?;
    Ok(head)
}

/// The job's number.
fn submit(script: &Path, options: &[&str]) -> Result<String> {
    let mut command = Command::new("sbatch");
    command.arg("--parsable").args(options).arg(script);
    let output = command
        .output()
        .context("sbatch: is Slurm installed here? --dry-run writes the scripts alone")?;
    if !output.status.success() {
        bail!("sbatch: {}", String::from_utf8_lossy(&output.stderr).trim());
    }
    let job = String::from_utf8_lossy(&output.stdout);
    // On a federation the cluster's name is behind it.
    Ok(job.trim().split(';').next().unwrap_or_default().to_owned())
}

/// For a shell.
fn quoted(path: &Path) -> Result<String> {
    let text = path
        .to_str()
        .with_context(|| format!("{}: is not Unicode", path.display()))?;
    Ok(format!("'{}'", text.replace('\'', r"'\''")))
}

/// As a name of a job and a file.
fn one_word(name: &str) -> String {
    let plain = |c: char| {
        if c.is_ascii_alphanumeric() || "-_".contains(c) {
            c
        } else {
            '_'
        }
    };
    name.chars().map(plain).collect()
}
