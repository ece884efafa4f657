//! `trunnion report`: a report to be filed.

use super::add::today;
use crate::load::{ModelArgs, RunArgs};
use crate::one_of::one_of;
use crate::outcome::Outcome;
use crate::{load, output, terminal};
use std::path::PathBuf;
use trunnion::Filing;
use trunnion::files::may_be_replaced;
use trunnion::report::{Issuer, Language, dcc_xml, report_html};
use trunnion_core::Day;
use trunnion_service::print;

/// Write a report to be filed: a page made to be printed, and a PDF
///
/// The first page says what is wrong, how large, how sure, what to do, and whether the tolerance is kept. Then follow
/// machine and recording (with its SHA-256), where the model fails and why, what was not observable, and every table.
///
/// Example: trunnion report run.mcap --model machine.model.toml -o report.html --pdf report.pdf --operator "Ada"
///
/// The tolerance is that of the machine file (tolerance_um) unless --tolerance-um gives another.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    runs: RunArgs,
    #[command(flatten)]
    model: ModelArgs,
    /// Page to write; without it, NAME.report.html next to the first recording
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// PDF to print from it, with a Chromium or Chrome of this computer
    #[arg(long, value_name = "FILE", long_help = print::HELP)]
    pdf: Option<PathBuf>,
    /// Language of headings, tables and verdicts: en, de, ja
    #[arg(long, value_name = "CODE", default_value = "en", value_parser = language)]
    language: Language,
    /// Who measured
    #[arg(long, value_name = "NAME")]
    operator: Option<String>,
    /// Serial number of the machine; without it, that of the machine file in the recording
    #[arg(long, value_name = "TEXT")]
    serial: Option<String>,
    /// How far the tool may be off against the table, um
    #[arg(long, value_name = "UM", value_parser = tolerance)]
    tolerance_um: Option<f64>,
    /// Digital calibration certificate to write (DCC 3.3.0, XML)
    #[arg(long, value_name = "FILE", requires = "country")]
    dcc: Option<PathBuf>,
    #[command(flatten)]
    issuer: IssuerArgs,
    /// Print JSON (format trunnion-report/1)
    #[arg(long)]
    json: bool,
}

/// What a certificate says in addition.
#[derive(clap::Args)]
struct IssuerArgs {
    /// Who calibrates
    #[arg(long, value_name = "NAME", requires = "dcc")]
    laboratory: Option<String>,
    /// Whose machine it is
    #[arg(long, value_name = "NAME", requires = "dcc")]
    customer: Option<String>,
    /// Country of the laboratory, two letters of ISO 3166-1; a certificate needs it
    #[arg(long, value_name = "CODE", requires = "dcc", value_parser = country)]
    country: Option<String>,
    /// Day of the measurement; a certificate needs it where a recording has none
    #[arg(long, value_name = "YYYY-MM-DD", requires = "dcc", value_parser = day)]
    measured: Option<String>,
}

/// A code that ISO 3166-1 leaves to users (§8.1.3: AA, QM to QZ, XA to XZ, ZZ) is no country, and readers of certificates refuse it.
fn country(text: &str) -> Result<String, String> {
    match text.as_bytes() {
        b"AA" | b"ZZ" | [b'Q', b'M'..=b'Z'] | [b'X', b'A'..=b'Z'] => {
            Err("ISO 3166-1 gives this code to no country; allowed: two capital letters, such as DE or JP"
                .into())
        }
        [b'A'..=b'Z', b'A'..=b'Z'] => Ok(text.into()),
        _ => Err("allowed: two capital letters, such as DE or JP".into()),
    }
}

fn day(text: &str) -> Result<String, String> {
    let day = Day::parse(text).map(|day| day.to_string());
    day.ok_or_else(|| "allowed: a day such as 2026-11-23".into())
}

fn language(code: &str) -> Result<Language, String> {
    one_of(&Language::NAMES, code)
}

fn tolerance(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|um| trunnion::TOLERANCE_UM.contains(um));
    let (least, most) = (trunnion::TOLERANCE_UM.start(), trunnion::TOLERANCE_UM.end());
    number.ok_or_else(|| format!("allowed: {least}..={most}"))
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let outputs =
        [("-o", args.output.as_deref()), ("--pdf", args.pdf.as_deref()), ("--dcc", args.dcc.as_deref())];
    output::not_an_input(&outputs, args.runs.paths(&args.model))?;
    args.pdf.as_deref().map_or(Ok(()), may_be_replaced)?;
    let loaded = load::runs(&args.runs)?;
    let (outcome, experiment) = (loaded.judgement(), loaded.experiment);
    let filing = Filing {
        serial: args.serial.clone(),
        operator: args.operator.clone(),
        tolerance_um: args.tolerance_um,
        written: today()?,
    };
    let compared = experiment.fit(&args.model.stated_model(&experiment)?)?.compare();
    let compared = compared.with_losses(&load::kept_losses(&args.runs.runs)).with_best();
    let mut outcome = outcome.with_verdict(compared.diagnosed().results().verdict);
    let mut report = compared.report(&args.runs.runs, &filing)?;
    let page = args.output.clone().unwrap_or_else(|| args.runs.runs[0].with_extension("report.html"));
    output::write(&page, &report_html(&report, args.language))?;
    report.html = Some(page.display().to_string());
    if let Some(pdf) = &args.pdf {
        output::write(pdf, &print::pdf(&page, &|| false)?)?;
        report.pdf = Some(pdf.display().to_string());
        report.pdf_lacks = print::lacks(&page, &|| false)?;
        if report.pdf_lacks.is_some() {
            outcome = Outcome::DataLoss;
        }
    }
    if let Some(dcc) = &args.dcc {
        let IssuerArgs { laboratory, customer, country, measured } = &args.issuer;
        let [laboratory, customer, country, measured] =
            [laboratory, customer, country, measured].map(Clone::clone);
        let issuer = Issuer { laboratory, customer, country, measured };
        output::write(dcc, &dcc_xml(&report, &issuer)?)?;
        report.dcc = Some(dcc.display().to_string());
    }
    if args.json {
        terminal::print_json(&report)?;
        return Ok(outcome);
    }
    terminal::print(&trunnion::report::report_text(&report))?;
    Ok(outcome)
}
