//! Sources as a person reads them: code and documents cite papers by a key, screens and pages by author, year and title.

/// A paper that is cited by a key (docs/design/references.md).
pub struct Source {
    /// The key.
    pub key: &'static str,
    /// Authors and year, where it has one.
    pub author: &'static str,
    /// Title, shortened.
    pub title: &'static str,
}

/// Every key of a paper.
pub const SOURCES: [Source; 5] = [
    Source {
        key: "S0",
        author: "Kenno et al. 2020",
        title: "Identification Method of Error Motions and Geometric Errors of a Rotary Axis by R-Test",
    },
    Source {
        key: "S1",
        author: "Oyama, Ibaraki and Otsubo",
        title: "Measurement and compensation of motion errors on 5-axis machine tool by R-test",
    },
    Source {
        key: "S2",
        author: "Ibaraki and Knapp 2012",
        title: "Indirect Measurement of Volumetric Accuracy for Three-Axis and Five-Axis Machine Tools: A Review",
    },
    Source {
        key: "S3",
        author: "Hayashi et al. 2021",
        title: "Forward Kinematics Model for Evaluation of Machining Performance of Robot Type Machine Tool",
    },
    Source {
        key: "S4",
        author: "Ibaraki, Kakino et al.",
        title: "Identification of Motion Error Sources on Five-axis Machine Tools by Ball-bar Measurements (1st Report)",
    },
];

/// A text with authors in place of keys.
pub fn with_authors(text: &str) -> String {
    replaced(text, |source| source.author.to_owned())
}

/// A list of sources with author, year and title in place of keys; documents of this repository are left out.
pub fn sources(list: &str) -> String {
    let public = list.split("; ").filter(|part| !part.starts_with("docs/"));
    let named = public.map(|part| replaced(part, |source| format!("{}: {}", source.author, source.title)));
    named.collect::<Vec<_>>().join("; ")
}

fn replaced(text: &str, name: impl Fn(&Source) -> String) -> String {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut out = String::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let begins = !out.ends_with(is_word);
        let found = SOURCES.iter().filter(|_| begins).find_map(|source| {
            let after = rest.strip_prefix(source.key)?;
            (!after.starts_with(is_word)).then_some((source, after))
        });
        match found {
            Some((source, after)) => {
                let place = [" §", " eq.", " table", " Fig."].iter().any(|place| after.starts_with(place));
                let comma = if place { "," } else { "" };
                out += &name(source);
                out += comma;
                rest = after;
            }
            None => {
                out.push(first);
                rest = &rest[first.len_utf8()..];
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::REGISTRY;

    #[test]
    fn a_key_becomes_author_year_and_title_and_nothing_else_changes() {
        assert_eq!(with_authors("ISO 230-7; S0 §3"), "ISO 230-7; Kenno et al. 2020, §3");
        assert_eq!(with_authors("Places (S1 Fig. 5, 8)"), "Places (Oyama, Ibaraki and Otsubo, Fig. 5, 8)");
        assert_eq!(with_authors("S1x, XS1, EB0S1 and µS1"), "S1x, XS1, EB0S1 and µS1");
        let list = sources("S2 eq. 1; docs/design/physics.md §5; ISO 230-2");
        assert!(list.starts_with("Ibaraki and Knapp 2012: Indirect"), "{list}");
        assert!(list.ends_with("A Review, eq. 1; ISO 230-2"), "{list}");
    }

    #[test]
    fn the_sources_of_no_effect_hold_a_key_or_a_path() {
        for effect in REGISTRY {
            let list = sources(effect.about.source);
            let words: Vec<&str> = list.split(|c: char| !c.is_alphanumeric()).collect();
            assert!(SOURCES.iter().all(|source| !words.contains(&source.key)), "{list}");
            assert!(!list.contains("docs/"), "{list}");
            for shown in [effect.about.explanation, effect.about.cause] {
                assert_eq!(with_authors(shown), shown, "what is shown as it stands names no key");
            }
        }
    }

    #[test]
    fn every_author_stands_in_the_references() {
        let references = include_str!("../../../docs/design/references.md");
        for source in &SOURCES {
            let entry = references.lines().find(|line| line.starts_with(&format!("- **{}**", source.key)));
            let title = |text: &str| text.to_lowercase().chars().take(40).collect::<String>();
            assert!(entry.unwrap().to_lowercase().contains(&title(source.title)), "{}", source.key);
        }
    }
}
