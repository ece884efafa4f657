//! Numbers of programs on controls that keep programs by them.

use crate::nc_programs::{STATIC, coarse, machine};
use trunnion_cycles::nc::{DIALECTS, Program};
use trunnion_cycles::{CourseRules, Cycle};

#[test]
fn fanuc_programs_have_numbers_of_their_own_that_follow_from_their_names() {
    let fanuc = DIALECTS.iter().find(|dialect| dialect.name == "fanuc").unwrap();
    let numbered = |text: &str, name: &str, rules: &CourseRules| -> u32 {
        let cycle = Cycle::parse("c.toml", &text.replace("small-static", name)).unwrap();
        let text = (fanuc.write)(&Program::of_cycle(&cycle, &machine(&cycle), rules).unwrap(), 3);
        let number = text.strip_prefix("%\nO").and_then(|text| text.get(..4)).unwrap();
        assert!(text.contains(&format!("(NUMBER {number} ")), "{text}");
        number.parse().unwrap()
    };
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/cycles");
    let names = std::fs::read_dir(folder).unwrap().map(|file| {
        let text = std::fs::read_to_string(file.unwrap().path()).unwrap();
        let name = text.lines().find_map(|line| line.strip_prefix("name = \"")).unwrap();
        name.trim_end_matches('"').to_owned()
    });
    let tcp = CourseRules { tool_point: true, ..coarse() };
    let numbers: Vec<u32> = names
        .chain(["sign-of-the-correction".into()])
        .flat_map(|name| [numbered(STATIC, &name, &coarse()), numbered(STATIC, &name, &tcp)])
        .collect();
    let distinct: std::collections::BTreeSet<u32> = numbers.iter().copied().collect();
    assert_eq!(distinct.len(), numbers.len(), "{numbers:?}");
    assert!(numbers.iter().all(|number| (1000..=7999).contains(number)), "{numbers:?}");
    let asked = CourseRules { program_number: Some(42), ..coarse() };
    assert_eq!(numbered(STATIC, "small-static", &asked), 42);
}
