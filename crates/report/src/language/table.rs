//! English, German, Japanese. `{}` stands for what a text says about one machine: names, numbers, another entry.

mod annex;
mod catalogue;
mod effects;
mod findings;
mod first_page;
mod mistakes;
mod next;

/// All entries, in the order of the report.
pub fn entries() -> impl Iterator<Item = &'static [&'static str; 3]> {
    [
        first_page::ENTRIES,
        findings::ENTRIES,
        effects::ENTRIES,
        catalogue::ENTRIES,
        annex::ENTRIES,
        next::ENTRIES,
        mistakes::ENTRIES,
    ]
    .into_iter()
    .flatten()
}
