//! `trunnion correct`: what to enter into the control, what to check first, what to expect.

use crate::load::{Loaded, ModelArgs, RunArgs, TrustedArgs};
use crate::outcome::Outcome;
use crate::{load, output, terminal};
use anyhow::{Context, bail};
use std::path::{Path, PathBuf};
use trunnion::cycles::dialect;
use trunnion::report::compensation::{FORMATS, Format, Signs, format};
use trunnion::report::{correction_judged_text, correction_text};
use trunnion::results::number::plain;
use trunnion::results::{Correction, CorrectionValues, SelfTest, Verdict};
use trunnion::{Corrected, Fit};

/// Write what corrects the machine in its control
///
/// Says where to enter it, which pose shows the sign, what to expect, and how to undo it. What the control cannot take is named.
/// A control: fanuc, heidenhain, linuxcnc, siemens. Tables of errors for other programs: csv, etalon, isg.
///
/// Example: trunnion correct run.mcap --model machine.model.toml --control siemens -o correction.mpf
///
/// The sign, in four poses: trunnion correct run.mcap --control siemens -o correction.mpf --self-test sign.toml;
/// trunnion nc-program sign.toml --dialect siemens --tcp; run it with the correction, then trunnion correct run.mcap --control siemens --judge sign.mcap
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    runs: TrustedArgs,
    #[command(flatten)]
    model: ModelArgs,
    /// Control, or format of tables
    #[arg(long, alias = "format", value_parser = names())]
    control: String,
    /// Write corrections (-error) instead of errors; tables only
    #[arg(long)]
    corrections: bool,
    /// Go on although the model is inadequate (diagnose finds something that it lacks) or could not be judged
    #[arg(long)]
    although_inadequate: bool,
    /// Go on although the errors at the measured poses do not fall by what the control takes
    #[arg(long)]
    although_not_better: bool,
    /// Cycle of four poses to write, which shows whether the sign is right
    #[arg(long, value_name = "CYCLE.TOML", requires = "output")]
    self_test: Option<PathBuf>,
    /// Judge runs measured with the correction: does it act, and with which sign? Writes nothing
    #[arg(long, value_name = "RUN", num_args = 1.., conflicts_with_all = ["output", "self_test"])]
    judge: Vec<PathBuf>,
    /// File to write; without it, standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print JSON (format trunnion-correction/1; trunnion-correction-judged/1 with --judge)
    #[arg(long)]
    json: bool,
}

fn names() -> Vec<&'static str> {
    FORMATS.iter().map(|format| format.name).collect()
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let control = format(&args.control).context("the command line allows known controls only")?;
    if args.json && args.output.is_none() && args.judge.is_empty() {
        bail!("--json prints the answer in place of the file: name the file with -o");
    }
    let outputs = [("-o", args.output.as_deref()), ("--self-test", args.self_test.as_deref())];
    output::not_an_input(&outputs, args.runs.runs.paths(&args.model))?;
    let values = values(args, control)?;
    let Loaded { experiment, outcome } = load::trusted_runs(&args.runs)?;
    let fit = experiment.fit(&args.model.stated_model(&experiment)?)?;
    if !args.judge.is_empty() {
        return judge(args, &fit.correction(control, values, Verdict::NotJudged)?);
    }
    let verdict = adequate(args, &fit)?;
    let corrected = fit.correction(control, values, verdict)?;
    if !args.although_not_better {
        better(&corrected.results(String::new()))?;
    }
    let outcome = if verdict == Verdict::NoiseFloor { outcome } else { outcome.or_withheld() };
    let Some(path) = &args.output else {
        terminal::print_verbatim(corrected.text())?;
        return Ok(outcome);
    };
    output::write(path, corrected.text())?;
    let answer = Correction {
        self_test: args
            .self_test
            .as_ref()
            .map(|cycle| self_test(&corrected, cycle, control.name))
            .transpose()?,
        ..corrected.results(path.display().to_string())
    };
    if args.json {
        terminal::print_json(&answer)?;
    } else {
        terminal::print(&correction_text(&answer))?;
    }
    Ok(outcome)
}

fn values(args: &Args, control: &Format) -> anyhow::Result<CorrectionValues> {
    match (args.corrections, control.signs) {
        (false, _) => Ok(CorrectionValues::Error),
        (true, Signs::Either) => Ok(CorrectionValues::Correction),
        (true, Signs::OfTheControl) => {
            bail!("--corrections is for tables; {} asks for one sign, which is written", control.name)
        }
    }
}

/// The verdict on the model; refuses one that lacks something, or was not judged.
fn adequate(args: &Args, fit: &Fit) -> anyhow::Result<Verdict> {
    let (verdict, why) = fit.verdict();
    match verdict {
        Verdict::NotJudged if !args.although_inadequate => bail!(
            "nothing was written, because the model was not judged. {why} `--although-inadequate` goes on all the same"
        ),
        Verdict::MissingEffect | Verdict::UnnamedStructure if !args.although_inadequate => bail!(
            "nothing was written, because the model is inadequate. {why} Add what it lacks (trunnion diagnose, trunnion add); \
             `--although-inadequate` goes on all the same"
        ),
        Verdict::NoiseFloor if why.is_empty() => {}
        Verdict::NoiseFloor => terminal::remark(&why),
        _ => terminal::remark(&format!("The model is not shown to be adequate. {why}")),
    }
    Ok(verdict)
}

/// Refuses a correction that does not lower the errors.
fn better(answer: &Correction) -> anyhow::Result<()> {
    if let Some(expected) = answer.expected.as_ref().filter(|expected| expected.is_no_better()) {
        let left_out: Vec<&str> = answer.left_out.iter().map(|left| left.effect.as_str()).collect();
        bail!(
            "nothing was written, because the errors do not fall: {} µm rms now, {} µm with what {} takes; it does not take {}. \
             `--although-not-better` goes on all the same",
            plain(expected.before_um),
            plain(expected.after_um),
            answer.control,
            left_out.join(", ")
        );
    }
    Ok(())
}

fn self_test(corrected: &Corrected, path: &Path, control: &str) -> anyhow::Result<SelfTest> {
    let (answer, cycle) = corrected.self_test()?;
    output::write(path, &cycle)?;
    let cycle = path.display().to_string();
    // What acts in the transformation alone shows under it alone.
    let program = dialect(control).map(|dialect| {
        let tcp = if dialect.tool_point.is_some() { " --tcp" } else { "" };
        format!("trunnion nc-program {cycle} --dialect {}{tcp}", dialect.name)
    });
    Ok(SelfTest { cycle, program, ..answer })
}

fn judge(args: &Args, corrected: &Corrected) -> anyhow::Result<Outcome> {
    let loaded = load::runs(&RunArgs::of(args.judge.clone()))?;
    let (outcome, experiment) = (loaded.stated_judgement(), loaded.experiment);
    let answer = corrected.judge(&experiment)?;
    if args.json {
        terminal::print_json(&answer)?;
    } else {
        terminal::print(&correction_judged_text(&answer))?;
    }
    Ok(outcome)
}
