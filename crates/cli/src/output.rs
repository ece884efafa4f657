//! Files that commands write, and findings shown, written as JSON or put on a page.

use crate::terminal;
use anyhow::Context;
use std::path::Path;
use trunnion::report::{findings_html, findings_text};
use trunnion::results::Findings;

/// Writes a text file.
pub fn write(path: &Path, text: &str) -> anyhow::Result<()> {
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

/// Says which page was written, if any.
pub fn report_page(page: Option<&Path>) -> anyhow::Result<()> {
    page.map_or(Ok(()), |page| terminal::print(&format!("page: {}\n", page.display())))
}

/// Prints what a method found as text or JSON, after its page where one is asked for.
pub fn findings(findings: &Findings, page: Option<&Path>, json: bool) -> anyhow::Result<()> {
    if let Some(path) = page {
        write(path, &findings_html(findings, &trunnion::page::label()))?;
    }
    if json {
        return terminal::print_json(findings);
    }
    terminal::print(&findings_text(findings))?;
    report_page(page)
}
