//! `trunnion cycle`: what a person does at the machine, to the service that runs there.

use crate::outcome::Outcome;
use crate::{load, terminal};
use anyhow::Context;
use serde_json::Value;
use std::path::PathBuf;
use trunnion::results::{CycleState, PageStatus, Published, ReadyNow};
use trunnion_service::caller::Caller;
use trunnion_service::config::Config;

/// Choose, begin or abort a cycle of the service that runs on this computer, or see where it is
///
/// The service has the devices; `record` needs them for itself. It is called where `[page]` of its configuration listens.
///
/// Example: trunnion cycle begin low --config config/trunnion.toml
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    call: Call,
    /// Configuration with which the service runs
    #[arg(long, value_name = "FILE", default_value = "config/trunnion.toml", global = true)]
    config: PathBuf,
    /// Print JSON
    #[arg(long, global = true)]
    json: bool,
}

#[derive(clap::Subcommand)]
enum Call {
    /// Where the service is with its cycle
    Status,
    /// Which cycle begins next, whatever program runs
    Choose {
        /// Name of the cycle; nothing: as the program says
        #[arg(default_value = "")]
        cycle: String,
    },
    /// Begin a cycle without waiting for its program
    Begin {
        /// Name of the cycle; nothing: the one that serves every program
        #[arg(default_value = "")]
        cycle: String,
    },
    /// End the cycle that is measured; what was read is kept
    Abort,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let config = Config::parse(&args.config, &load::read(&args.config)?)?;
    let page = config.page.with_context(|| {
        format!("{} has no table [page], so the service takes no calls", args.config.display())
    })?;
    let caller = Caller::new(&page)?;
    let runtime = tokio::runtime::Runtime::new().context("cannot start the runtime")?;
    let status = runtime.block_on(async {
        match &args.call {
            Call::Status => caller.status().await,
            Call::Choose { cycle } => caller.choose(cycle).await,
            Call::Begin { cycle } => caller.begin(cycle).await,
            Call::Abort => caller.abort().await,
        }
    })?;
    let asked_to_begin = matches!(args.call, Call::Begin { .. });
    match args.json {
        true => terminal::print_json(&status)?,
        false => terminal::print(&text(&status, asked_to_begin))?,
    }
    Ok(Outcome::Done)
}

fn text(status: &PageStatus, asked_to_begin: bool) -> String {
    let cycle = status.topics.get("cycle").unwrap_or(&Value::Null);
    let words = |key: &str| cycle[key].as_str().unwrap_or_default();
    let (ready, against) = readiness(status);
    // Before the first cycle its state is that of the devices; afterwards that of the newest cycle.
    let state = match words("state") {
        "" => "no cycle",
        state if state == CycleState::Ready.as_str() => ready,
        state => state,
    };
    let mut text = format!("{}: {state}", status.name);
    for (key, before) in [("cycle", " "), ("run", ", run "), ("why", ": ")] {
        if !words(key).is_empty() {
            text += &format!("{before}{}", words(key));
        }
    }
    if words("state") != CycleState::Measuring.as_str() {
        against.iter().for_each(|why| text += &format!("\n  against a cycle: {why}"));
    }
    if asked_to_begin && !["measuring", "refused"].contains(&words("state")) {
        text += "\n  asked to begin; it has not begun yet: see `trunnion cycle status` before asking again";
    }
    if let Some(chosen) = status.topics.get("status").and_then(|status| status["chosen"].as_str()) {
        text += &format!("\n  begins next: {chosen}, as it was chosen");
    }
    let names: Vec<&str> = status.cycles.iter().map(|cycle| cycle.name.as_str()).collect();
    text + &format!("\n  cycles: {}\n", names.join(", "))
}

/// Whether a cycle may begin, and what stands against it: what MQTT `ready` says.
fn readiness(status: &PageStatus) -> (&'static str, Vec<String>) {
    let topic = status.topics.get(ReadyNow::TOPIC).cloned();
    let Some(now) = topic.and_then(|now| serde_json::from_value::<ReadyNow>(now).ok()) else {
        return ("waits for its devices", Vec::new());
    };
    (if now.ready { "ready" } else { "not ready" }, now.why)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;
    use std::collections::BTreeMap;

    #[test]
    fn a_service_without_its_devices_is_not_ready() {
        let check = |cycle: Value, ready: Option<Value>, expected: &str| {
            let mut topics = BTreeMap::from([("cycle".to_owned(), cycle)]);
            topics.extend(ready.map(|ready| ("ready".to_owned(), ready)));
            let status = PageStatus { name: "machine-1".into(), topics, ..PageStatus::default() };
            assert_eq!(text(&status, false), format!("machine-1: {expected}\n  cycles: \n"));
        };
        let why = "probe-1: there is no value yet";
        let absent = json!({ "ready": false, "why": [why] });
        let waits = || json!({ "state": "ready" });
        check(waits(), Some(absent.clone()), &format!("not ready\n  against a cycle: {why}"));
        check(waits(), Some(json!({ "ready": true, "why": [] })), "ready");
        check(waits(), None, "waits for its devices");
        let done = json!({ "state": "done", "cycle": "low", "run": "a" });
        check(done, Some(absent.clone()), &format!("done low, run a\n  against a cycle: {why}"));
        check(json!({ "state": "measuring", "cycle": "low" }), Some(absent), "measuring low");
    }
}
