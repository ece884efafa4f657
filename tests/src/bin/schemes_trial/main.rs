//! `schemes-trial`: every measurement scheme over many seeds. Writes its table in docs/measured/schemes.md.

use anyhow::Context;
use clap::Parser;
use trunnion_tests::schemes::judged::Found;
use trunnion_tests::schemes::rows::{Row, rows};
use trunnion_tests::schemes::{NOISES, SECTION, Tried, line, trial};
use trunnion_tests::section::Section;
use trunnion_tests::workspace_root;

/// How far the numbers of every scheme are from the injected values, in standard uncertainties
#[derive(Parser)]
struct Args {
    /// Trials of each scheme with each noise
    #[arg(long, default_value_t = 30)]
    seeds: u64,
    /// The first of them
    #[arg(long, default_value_t = 1)]
    first: u64,
    /// Only schemes of cycles whose names hold this, or of methods
    #[arg(long, default_value = "")]
    only: String,
    /// Print rms z of every parameter, and its rms error next to its rms u
    #[arg(long)]
    parameters: bool,
    /// Write the table into docs/measured/schemes.md instead of standard output; schemes that are not tried keep their lines
    #[arg(long)]
    write: bool,
}

const DOCUMENT: &str = "docs/measured/schemes.md";

fn main() -> anyhow::Result<()> {
    let args = Args::parse();
    let of_method = |row: &Row| row.method.is_some_and(|method| method.contains(&args.only));
    for row in rows().filter(|row| row.cycle.contains(&args.only) || of_method(row)) {
        let begun = std::time::Instant::now();
        let mut tried = Vec::new();
        for (kind, _) in NOISES {
            let mut of_kind = Tried::default();
            for seed in args.first..args.first + args.seeds {
                match trial(row, kind, seed) {
                    Ok(found) => of_kind.found.extend(found),
                    Err(why) => {
                        eprintln!("{} {seed}: {why:#}", row.cycle);
                        of_kind.failed += 1;
                    }
                }
            }
            if args.parameters {
                print_parameters(&of_kind);
            }
            tried.push(of_kind);
        }
        let line = line(row, args.seeds, &tried);
        eprint!("{:.0} s {line}", begun.elapsed().as_secs_f64());
        if args.write { write(row.scheme, &line)? } else { print!("{line}") }
    }
    Ok(())
}

/// rms z of each parameter by itself; rms error over rms u: 1 where u is right on average over the runs, however it differs from run to run.
fn print_parameters(tried: &Tried) {
    let mut names: Vec<&str> = tried.found.iter().map(|found| found.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    for name in names {
        let found = tried.found.iter().filter(|found| found.name == name).cloned().collect();
        let of_name = Tried { found, failed: 0 };
        let rms = |of: fn(&Found) -> f64| {
            (of_name.found.iter().map(|found| of(found).powi(2)).sum::<f64>() / of_name.found.len() as f64)
                .sqrt()
        };
        let (error, u) = (rms(|found| found.value - found.expected), rms(|found| found.u));
        let unit = &of_name.found[0].unit;
        eprintln!(
            "  {name}: rms z {:.2}, rms error {error:.4} {unit}, rms u {u:.4}, {:.2}",
            of_name.rms_z(),
            error / u
        );
    }
}

/// Writes a line at once: a trial that is stopped loses nothing.
fn write(scheme: &str, line: &str) -> anyhow::Result<()> {
    let path = workspace_root().join(DOCUMENT);
    let document = std::fs::read_to_string(&path)?;
    let section = Section::of(&document, SECTION).context("the document has its section")?;
    let begins = |line: &&str| rows().position(|row| line.starts_with(&format!("| {} |", row.scheme)));
    let (mut lines, head): (Vec<&str>, Vec<&str>) =
        section.inside.split_inclusive('\n').partition(|line| begins(line).is_some());
    lines.retain(|old| !old.starts_with(&format!("| {scheme} |")));
    lines.push(line);
    lines.sort_by_key(begins);
    std::fs::write(&path, section.with(&(head.concat() + &lines.concat())))?;
    Ok(())
}
