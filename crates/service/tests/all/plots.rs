//! The guide to the plots has a section for every part of the view Result that unfolds, under the name that it has there.

use std::path::Path;

#[test]
fn every_plot_of_the_result_has_its_section_in_the_guide() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = |path: &str| std::fs::read_to_string(here.join(path)).unwrap();
    let (script, guide) = (text("src/page/assets/result.js"), text("../../docs/use/plots.md"));
    // `["sweeps", "Residual over single axes"],` of the list, and `detail(["maps", "Residual over …"])`.
    let list = script.split("const DETAILS = [").nth(1).unwrap().split("];").next().unwrap();
    let rows = list.lines().filter(|line| line.trim().starts_with('['));
    let single = script.split("detail([").skip(1).map(|rest| rest.split(']').next().unwrap());
    let titles: Vec<&str> = rows.chain(single).map(|row| row.split('"').nth(3).unwrap()).collect();
    assert!(titles.len() > 5, "{titles:?}");
    for title in titles {
        assert!(guide.contains(&format!("\n## {title}\n")), "docs/use/plots.md lacks \"{title}\"");
    }
}
