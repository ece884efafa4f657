//! The table of calls in docs/use/page.md has every call of the page, and no other.

use std::collections::BTreeSet;
use std::path::Path;

/// `GET /api/runs/{name}` of every `.route(…)` in the files of the page.
pub fn routes() -> BTreeSet<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/page");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let texts = files.filter(|path| path.is_file()).map(|path| std::fs::read_to_string(path).unwrap());
    let mut found = BTreeSet::new();
    for text in texts {
        for route in text.split(".route(").skip(1) {
            let (path, rest) = route.split_once(',').unwrap();
            // The one that `guard` lets in without the token has a name there.
            let path = path.trim().trim_matches('"').replace("LOGIN", "/api/login");
            let methods = rest.split(".route(").next().unwrap();
            for (call, method) in [("get(", "GET"), ("post(", "POST"), ("delete(", "DELETE")] {
                let ends = methods.find("))").unwrap_or(methods.len());
                if methods[..ends].contains(call) && path.starts_with("/api/") {
                    found.insert(format!("{method} {path}"));
                }
            }
        }
    }
    found
}

/// The same of the first column of the table; `…` is the call before it in its row, without the last part.
fn table() -> BTreeSet<String> {
    let text = include_str!("../../../../docs/use/page.md");
    let (_, table) = text.split_once("| call | answer | command |").unwrap();
    let rows = table.lines().skip(2).take_while(|line| line.starts_with('|'));
    let mut found = BTreeSet::new();
    for row in rows {
        let cell = row.split('|').nth(1).unwrap();
        let mut before = String::new();
        for code in cell.split('`').skip(1).step_by(2).filter(|code| code.contains('/')) {
            let call = match code.strip_prefix("…/") {
                Some(rest) => format!("{}/{rest}", before.rsplit_once('/').unwrap().0),
                None => code.into(),
            };
            let named = |(word, name): (&str, &str), call: &str| {
                call.split('/')
                    .map(|part| if part == word { name } else { part })
                    .collect::<Vec<_>>()
                    .join("/")
            };
            let names = [("NAME", "{name}"), ("EFFECT", "{effect}"), ("METHOD", "{method}")];
            found.insert(names.into_iter().fold(call.clone(), |call, pair| named(pair, &call)));
            before = call;
        }
    }
    found
}

#[test]
fn every_call_is_in_the_table() {
    let (routes, table) = (routes(), table());
    assert!(routes.len() > 20, "a walk that finds nothing proves nothing: {routes:?}");
    assert_eq!(routes, table);
}
