//! `trunnion check-config`: every problem of the configuration and of what it names, before anything runs.

mod reach;

use crate::commands::daemon::prepare;
use crate::outcome::Outcome;
use crate::terminal;
use anyhow::{Context, bail};
use reach::{Reached, reach};
use std::collections::BTreeSet;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use trunnion_acquire::credentials;
use trunnion_core::Secret;
use trunnion_core::input::Document;
use trunnion_core::secret::holds_secret;
use trunnion_service::config::Config;
use trunnion_service::cycles::Choice;
use trunnion_service::page::Access;
use trunnion_service::slow_probes::too_slow;

/// Check a configuration and what it names
///
/// Files are read, those of passwords, certificates and keys too, and the folder of the recordings is tried. Ports, controllers and the broker
/// are looked for, 3 s at most. A folder that cannot be written or a file that cannot be read is a failure (exit code 1). A secret that
/// every user of this computer can read is named. A port, controller or broker that is not there is a state: it is said, the service
/// waits for it, and the exit code stays 0.
///
/// Example: trunnion check-config config/trunnion.toml
#[derive(clap::Args)]
pub struct Args {
    /// Configuration file
    #[arg(value_name = "FILE", default_value = "config/trunnion.toml")]
    config: PathBuf,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let prepared = prepare(&args.config)?;
    let devices = prepared.config.devices.len();
    let named = secret_files(&prepared.config).into_iter().filter_map(|file| open_secret(&file));
    let remarks = open_to_others(&args.config, &prepared.config.text)?.into_iter().chain(named);
    remarks.for_each(|remark| terminal::remark(&remark));
    let slow = |choice: &Choice| too_slow(&prepared.config.devices, &choice.plan);
    prepared.cycles.all().filter_map(slow).for_each(|remark| terminal::remark(&remark));
    if let Some(lan) = prepared.config.page.as_ref().and_then(|page| page.lan.as_ref()) {
        Access::of_lan(lan).context("[page] cannot let other computers in")?;
    }
    let Reached { failures, absent } = reach(&prepared.config);
    absent.iter().for_each(|absent| terminal::remark(absent));
    if !failures.is_empty() {
        bail!("{}: {}", args.config.display(), failures.join("\n"));
    }
    let cycles: Vec<&str> = prepared.cycles.names().collect();
    let several = if cycles.len() == 1 { "cycle" } else { "cycles" };
    let machine = prepared.cycles.machine();
    terminal::print(&format!(
        "{}: good; machine {machine}, {several} {}, {devices} devices{}\n",
        args.config.display(),
        cycles.join(", "),
        match absent.len() {
            0 => String::new(),
            1 => "; one thing is not there now".into(),
            count => format!("; {count} things are not there now"),
        }
    ))?;
    Ok(Outcome::Done)
}

/// What to say of a file with a password in it that other users of the computer can read.
fn open_to_others(file: &Path, text: &str) -> anyhow::Result<Option<String>> {
    Ok((others_read(file)? && holds_secret(text)).then(|| {
        format!(
            "{0}: holds a password that every user of this computer can read; chmod 640 {0}, or move it to a password_file",
            file.display()
        )
    }))
}

/// What to say of a file that is a password, a key or a token, and that other users of the computer can read. One that cannot be
/// looked at is reported where it is read.
fn open_secret(file: &Path) -> Option<String> {
    let is_open = others_read(file).unwrap_or(false);
    is_open.then(|| {
        format!("{0}: is a secret that every user of this computer can read; chmod 640 {0}", file.display())
    })
}

fn others_read(file: &Path) -> std::io::Result<bool> {
    Ok(std::fs::metadata(file)?.permissions().mode() & 0o004 != 0)
}

/// Every file of a password, a key or a token that the configuration names, once.
fn secret_files(config: &Config) -> BTreeSet<PathBuf> {
    let file = config.file.display().to_string();
    let Ok(document) = Document::parse(&file, &config.text) else { return BTreeSet::new() };
    let root = document.root();
    let (page, mqtt) = (root.optional_table("page"), root.optional_table("mqtt"));
    let tls = mqtt.as_ref().and_then(|mqtt| mqtt.optional_table("tls"));
    let tables = page.into_iter().chain(mqtt).chain(tls).chain(root.tables("device"));
    let keys = ["password_file", "token_file", "key_file"];
    let secrets: Vec<Secret> =
        tables.flat_map(|table| keys.map(|key| Secret::read_file(&table, key))).flatten().collect();
    secrets.iter().filter_map(credentials::file).collect()
}
