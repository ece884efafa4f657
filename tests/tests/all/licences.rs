//! Licences and duplicates of the dependencies: what deny.toml allows, what THIRD-PARTY.md lists.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;
use trunnion_tests::section::write_or_compare;
use trunnion_tests::workspace_root;

#[test]
fn third_party_lists_every_licence() {
    let tree = Tree::of_workspace();
    assert!(tree.packages.len() > 100, "{} packages", tree.packages.len());
    let program = tree.reached_from("trunnion-cli");
    let table = |of_program: bool| {
        let rows = tree.outside().filter(|package| program.contains(&package.id) == of_program);
        let rows: String = rows.map(Package::row).collect();
        format!("| crate | version | licence |\n|---|---|---|\n{rows}")
    };
    let copyleft = tree.outside().filter(|package| package.licence.contains("MPL"));
    let copyleft: String = copyleft.map(|package| format!("- {}\n", package.name)).collect();
    write_or_compare("THIRD-PARTY.md", "mpl", &copyleft);
    write_or_compare("THIRD-PARTY.md", "program", &table(true));
    write_or_compare("THIRD-PARTY.md", "build", &table(false));
}

#[test]
fn every_licence_is_allowed_and_every_allowance_is_needed() {
    let allowed = Rules::read().licences;
    let mut needed = BTreeSet::new();
    for package in Tree::of_workspace().outside() {
        let granted = granted(&package.licence, &|id| allowed.contains(id));
        let granted = granted.unwrap_or_else(|| {
            panic!("{} {}: {} is not allowed by deny.toml", package.name, package.version, package.licence)
        });
        needed.extend(granted);
    }
    assert_eq!(allowed, needed, "deny.toml allows licences that nothing needs");
}

#[test]
fn a_second_version_has_a_reason() {
    let tree = Tree::of_workspace();
    let skipped = Rules::read().skipped;
    let mut versions: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for package in tree.outside() {
        versions.entry(&package.name).or_default().insert(&package.version);
    }
    let mut used = BTreeSet::new();
    for (name, versions) in versions.iter().filter(|(_, versions)| versions.len() > 1) {
        let mut kept = versions.clone();
        for skip in skipped.iter().filter(|(skipped, _)| skipped == name) {
            kept.retain(|version| !starts(version, &skip.1));
            used.insert(skip);
        }
        assert!(
            kept.len() == 1,
            "{name} {versions:?}: use one version, or name the others with a reason in deny.toml"
        );
    }
    let unused: Vec<_> = skipped.iter().filter(|skip| !used.contains(*skip)).collect();
    assert!(unused.is_empty(), "deny.toml skips what is no second version: {unused:?}");
}

#[test]
fn an_accepted_advisory_is_of_a_crate_that_is_there_and_has_its_record() {
    let record = workspace_root().join("docs/decisions/0014-accepted-advisories.md");
    let record = std::fs::read_to_string(record).unwrap();
    let tree = Tree::of_workspace();
    let advisories = Rules::read().advisories;
    for (id, name) in &advisories {
        assert!(
            tree.outside().any(|package| package.name == *name),
            "{id}: {name} is gone; so is its advisory"
        );
        assert!(record.contains(&format!("| {id} | `{name}`")), "{id} of {name} has no row in the record");
    }
    assert_eq!(
        record.matches("| RUSTSEC-").count(),
        advisories.len(),
        "the record has others than deny.toml"
    );
}

#[test]
fn expressions_are_read_as_spdx_does() {
    let allowed = |id: &str| ["MIT", "Unicode-3.0"].contains(&id);
    let check = |expression: &str, expected: Option<&[&str]>| {
        let expected = expected.map(|ids| ids.iter().map(|id| (*id).to_string()).collect());
        assert_eq!(granted(expression, &allowed), expected, "{expression}");
    };
    check("MIT", Some(&["MIT"]));
    check("GPL-3.0-only", None);
    check("MIT OR GPL-3.0-only", Some(&["MIT"]));
    check("GPL-3.0-only/MIT", Some(&["MIT"]));
    check("MIT AND GPL-3.0-only", None);
    check("(GPL-3.0-only OR MIT) AND Unicode-3.0", Some(&["MIT", "Unicode-3.0"]));
    check("MIT AND Unicode-3.0 OR GPL-3.0-only", Some(&["MIT", "Unicode-3.0"]));
    check("MIT WITH LLVM-exception", None);
    check("", None);
}

/// What deny.toml says.
struct Rules {
    licences: BTreeSet<String>,
    /// Name and beginning of the version.
    skipped: Vec<(String, String)>,
    /// Identifier and crate.
    advisories: Vec<(String, String)>,
}

impl Rules {
    fn read() -> Self {
        let text = std::fs::read_to_string(workspace_root().join("deny.toml")).unwrap();
        let rules: toml::Table = text.parse().unwrap();
        let allowed = rules["licenses"]["allow"].as_array().unwrap();
        let skip = |entry: &toml::Value| {
            assert!(
                entry["reason"].as_str().is_some_and(|reason| !reason.is_empty()),
                "{entry} has no reason"
            );
            let (name, version) = entry["crate"].as_str().unwrap().split_once('@').unwrap();
            (name.to_string(), version.to_string())
        };
        let advisory = |entry: &toml::Value| {
            let (name, _) = entry["reason"].as_str().unwrap().split_once(": ").unwrap();
            (entry["id"].as_str().unwrap().to_string(), name.to_string())
        };
        Self {
            advisories: rules["advisories"]["ignore"].as_array().unwrap().iter().map(advisory).collect(),
            licences: allowed.iter().map(|id| id.as_str().unwrap().to_string()).collect(),
            skipped: rules["bans"]["skip"].as_array().unwrap().iter().map(skip).collect(),
        }
    }
}

struct Package {
    id: String,
    name: String,
    version: String,
    licence: String,
    repository: Option<String>,
    is_ours: bool,
    /// Ids of what it is linked with.
    links: Vec<String>,
}

impl Package {
    fn row(&self) -> String {
        let name = match &self.repository {
            Some(address) => format!("[{}]({address})", self.name),
            None => self.name.clone(),
        };
        format!("| {name} | {} | {} |\n", self.version, self.licence)
    }
}

/// The packages that the workspace is built from.
struct Tree {
    packages: Vec<Package>,
}

impl Tree {
    fn of_workspace() -> Self {
        let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
        let output = Command::new(cargo)
            .args(["metadata", "--format-version", "1", "--locked", "--all-features"])
            .args(["--filter-platform", "x86_64-unknown-linux-gnu"])
            .current_dir(workspace_root())
            .output()
            .unwrap();
        assert!(output.status.success(), "cargo metadata: {}", String::from_utf8_lossy(&output.stderr));
        let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
        let text = |value: &Value| value.as_str().map(str::to_string);
        let nodes = metadata["resolve"]["nodes"].as_array().unwrap();
        let links: BTreeMap<&str, Vec<String>> =
            nodes.iter().map(|node| (node["id"].as_str().unwrap(), linked(node))).collect();
        let package = |package: &Value| Package {
            id: text(&package["id"]).unwrap(),
            name: text(&package["name"]).unwrap(),
            version: text(&package["version"]).unwrap(),
            licence: text(&package["license"]).unwrap_or_default(),
            repository: text(&package["repository"]),
            is_ours: package["source"].is_null(),
            links: links.get(package["id"].as_str().unwrap()).cloned().unwrap_or_default(),
        };
        let mut packages: Vec<Package> =
            metadata["packages"].as_array().unwrap().iter().map(package).collect();
        packages.sort_by(|a, b| (&a.name, &a.version).cmp(&(&b.name, &b.version)));
        Self { packages }
    }

    fn outside(&self) -> impl Iterator<Item = &Package> {
        self.packages.iter().filter(|package| !package.is_ours)
    }

    /// Ids of the packages that are linked into the package of this name, macros included.
    fn reached_from(&self, name: &str) -> BTreeSet<String> {
        let start = self.packages.iter().find(|package| package.name == name).unwrap();
        let mut reached = BTreeSet::new();
        let mut open = vec![start.id.clone()];
        while let Some(id) = open.pop() {
            let package = self.packages.iter().find(|package| package.id == id).unwrap();
            if reached.insert(id) {
                open.extend(package.links.iter().cloned());
            }
        }
        reached
    }
}

/// Normal dependencies of a node: neither of its build nor of its tests.
fn linked(node: &Value) -> Vec<String> {
    let is_normal = |dependency: &&Value| {
        dependency["dep_kinds"]
            .as_array()
            .is_some_and(|kinds| kinds.iter().any(|kind| kind["kind"].is_null()))
    };
    let dependencies = node["deps"].as_array().unwrap().iter().filter(is_normal);
    dependencies.map(|dependency| dependency["pkg"].as_str().unwrap().to_string()).collect()
}

/// True when `version` is `start` or goes on after it.
fn starts(version: &str, start: &str) -> bool {
    version.strip_prefix(start).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// The licences under which an SPDX expression is allowed, the first choice that is; `None` where none is.
fn granted(expression: &str, allowed: &dyn Fn(&str) -> bool) -> Option<BTreeSet<String>> {
    let expression = expression.trim().replace('/', " OR ");
    if let Some(parts) = split(&expression, " OR ") {
        return parts.iter().find_map(|part| granted(part, allowed));
    }
    if let Some(parts) = split(&expression, " AND ") {
        let all: Option<Vec<_>> = parts.iter().map(|part| granted(part, allowed)).collect();
        return all.map(|sets| sets.into_iter().flatten().collect());
    }
    if let Some(inside) = expression.strip_prefix('(').and_then(|rest| rest.strip_suffix(')')) {
        return granted(inside, allowed);
    }
    allowed(&expression).then(|| BTreeSet::from([expression.clone()]))
}

/// The parts of an expression between operators that are in no parentheses; `None` where there is none.
fn split(expression: &str, operator: &str) -> Option<Vec<String>> {
    let mut parts = vec![String::new()];
    for piece in expression.split(operator) {
        let last = parts.last_mut().expect("never empty");
        let open = |text: &str| text.matches('(').count() > text.matches(')').count();
        if open(last) {
            *last += operator;
            *last += piece;
        } else if last.is_empty() {
            *last = piece.to_string();
        } else {
            parts.push(piece.to_string());
        }
    }
    (parts.len() > 1).then_some(parts)
}
