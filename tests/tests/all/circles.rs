//! No circle of files: inside a crate, what two files both need is a leaf below them.
//!
//! An arrow leads from a file to each file of its crate that it takes a name from: by `use` and `pub use`, or by a
//! path in the text. `mod x;` alone is no arrow, and tests are not read. A name that a file only passes on is taken
//! from where it is defined.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use trunnion_tests::workspace_root;

/// The names of a path; that of a module begins at the root of its crate.
type Names = Vec<String>;
/// Which file takes names from which.
type Arrows = BTreeMap<PathBuf, BTreeSet<PathBuf>>;

/// A file of a crate.
struct Source {
    path: PathBuf,
    module: Names,
    /// What it imports or passes on: the name here, and where it comes from; `None` when from another crate.
    imports: Vec<(String, Option<Names>)>,
    /// Paths of its crate in the text.
    paths: Vec<Names>,
}

#[test]
fn no_crate_has_a_circle_of_files() {
    let root = workspace_root();
    let mut folders: Vec<PathBuf> =
        std::fs::read_dir(root.join("crates")).unwrap().map(|entry| entry.unwrap().path()).collect();
    folders.extend([root.join("hil-sim"), root.join("tests")]);
    folders.sort();
    let folders = folders.iter().map(|folder| folder.join("src")).filter(|folder| folder.is_dir());
    let found: Vec<String> = folders.flat_map(|folder| circles(&arrows(&sources(&folder)))).collect();
    assert!(found.is_empty(), "{} circles of files:\n{}", found.len(), found.join("\n"));
}

#[test]
fn a_circle_is_found_however_its_names_are_taken() {
    let check = |text: &str, expected: &[&str]| {
        let source = |path: &str, module: &[&str], text: &str| {
            Source::read(path.into(), module.iter().map(|name| (*name).to_owned()).collect(), text)
        };
        let sources = [
            source("a.rs", &["a"], text),
            source("a/child.rs", &["a", "child"], ""),
            source("b.rs", &["b"], "mod leaf; pub use leaf::Name; use std::fmt;"),
            source("b/leaf.rs", &["b", "leaf"], ""),
        ];
        let arrows = arrows(&sources);
        let to: Vec<_> = arrows[Path::new("a.rs")].iter().map(|path| path.to_str().unwrap()).collect();
        assert_eq!(to, expected, "{text}");
    };
    check("mod child;", &[]);
    check("mod child; pub use child::Name;", &["a/child.rs"]);
    check("mod child;\nfn f() { child::g() }", &["a/child.rs"]);
    check("use crate::{b::{A, B}, a::child};", &["a/child.rs", "b.rs"]);
    check("use super::b::*;", &["b.rs"]);
    check("use crate::b::Name;", &["b/leaf.rs"]);
    check("use crate::b::fmt;", &[]);
    check("fn f() -> crate::b::T { 0 } // crate::a::child::x", &["b.rs"]);
    check("const S: &str = \"crate::b::T\";", &[]);
    check("mod inside { use super::T; }\nuse super::b::T;", &["b.rs"]);
    check("#[cfg(test)]\nmod tests {\n    use crate::b::T;\n}\n", &[]);
    let arrows = Arrows::from([
        ("x.rs".into(), BTreeSet::from(["y.rs".into()])),
        ("y.rs".into(), BTreeSet::from(["x.rs".into(), "z.rs".into()])),
        ("z.rs".into(), BTreeSet::new()),
    ]);
    assert_eq!(circles(&arrows), ["2 files\n  x.rs -> y.rs\n  y.rs -> x.rs"]);
}

/// The files of a crate with their modules and code; tests are left out.
fn sources(folder: &Path) -> Vec<Source> {
    let (mut files, mut stack) = (Vec::new(), vec![folder.to_path_buf()]);
    while let Some(path) = stack.pop() {
        let stem = path.file_stem().unwrap().to_str().unwrap();
        if path.is_dir() {
            if stem != "tests" {
                stack.extend(std::fs::read_dir(&path).unwrap().map(|entry| entry.unwrap().path()));
            }
        } else if path.extension().is_some_and(|extension| extension == "rs") && stem != "tests" {
            let mut module: Names = path
                .strip_prefix(folder)
                .unwrap()
                .with_extension("")
                .iter()
                .map(|part| part.to_str().unwrap().to_owned())
                .collect();
            if matches!(module.last().map(String::as_str), Some("mod" | "lib" | "main")) {
                module.pop();
            }
            let text = std::fs::read_to_string(&path).unwrap();
            files.push(Source::read(
                path.strip_prefix(workspace_root()).unwrap().to_path_buf(),
                module,
                &text,
            ));
        }
    }
    files
}

fn arrows(sources: &[Source]) -> Arrows {
    let by_module: BTreeMap<&Names, &Source> =
        sources.iter().map(|source| (&source.module, source)).collect();
    let taken = |source: &Source| {
        let imported = source.imports.iter().filter_map(|(_, path)| path.as_ref());
        let files = imported.chain(&source.paths).filter_map(|path| file_of(path, &by_module, 0));
        files.filter(|target| *target != source.path).collect()
    };
    sources.iter().map(|source| (source.path.clone(), taken(source))).collect()
}

/// The file in which what the path means is defined; `None` when in another crate.
fn file_of(path: &[String], by_module: &BTreeMap<&Names, &Source>, depth: usize) -> Option<PathBuf> {
    let known = |length: &usize| by_module.contains_key(&path[..*length].to_vec());
    let length = (0..=path.len()).rev().find(known)?;
    let source = by_module[&path[..length].to_vec()];
    let passed_on = path.get(length).and_then(|name| source.imports.iter().find(|(here, _)| here == name));
    match passed_on {
        Some((_, from)) if depth < 10 => {
            file_of(&[from.as_ref()?, &path[length + 1..]].concat(), by_module, depth + 1)
        }
        _ => Some(source.path.clone()),
    }
}

impl Source {
    fn read(path: PathBuf, module: Names, text: &str) -> Self {
        let tokens = tokens(text);
        let declared = |pair: &[String]| (pair[0] == "mod").then(|| pair[1].clone());
        let children: BTreeSet<String> = tokens.windows(2).filter_map(declared).collect();
        let from_root = |path: Names, inline: &[(String, usize)]| -> Option<Names> {
            let inline: Names = inline.iter().map(|(name, _)| name.clone()).collect();
            let mut from = match path[0].as_str() {
                "crate" => Vec::new(),
                "self" | "super" => [module.clone(), inline].concat(),
                child if children.contains(child) => [module.clone(), vec![child.to_owned()]].concat(),
                _ => return None,
            };
            for name in path.iter().skip(usize::from(path[0] != "super")) {
                match name.as_str() {
                    "super" => drop(from.pop()),
                    "self" => {}
                    name => from.push(name.to_owned()),
                }
            }
            Some(from)
        };
        let (mut imports, mut paths, mut at) = (Vec::new(), Vec::new(), 0);
        // Modules written inside the file, with the depth of braces at which each ends.
        let (mut inline, mut depth) = (Vec::new(), 0);
        while at < tokens.len() {
            match tokens[at].as_str() {
                "mod" if tokens.get(at + 2).is_some_and(|sign| sign == "{") => {
                    inline.push((tokens[at + 1].clone(), depth));
                }
                "{" => depth += 1,
                "}" => {
                    depth -= 1;
                    inline.retain(|(_, ends)| *ends < depth);
                }
                _ => {}
            }
            let next = tokens.get(at + 1).map_or("", String::as_str);
            if tokens[at] == "use" && next != "<" {
                let mut tree = Vec::new();
                at = read_tree(&tokens, at + 1, Vec::new(), &mut tree);
                imports.extend(tree.into_iter().map(|(name, path)| (name, from_root(path, &inline))));
            } else if tokens[at] == "in" && at > 0 && tokens[at - 1] == "(" {
                at += tokens[at..].iter().position(|token| token == ")").unwrap_or(1); // `pub(in crate::a)`
            } else if next == "::" {
                let mut path = vec![tokens[at].clone()];
                while tokens.get(at + 1).is_some_and(|next| next == "::") && tokens.len() > at + 2 {
                    path.push(tokens[at + 2].clone());
                    at += 2;
                }
                paths.extend(from_root(path, &inline));
                at += 1;
            } else {
                at += 1;
            }
        }
        Self { path, module, imports, paths }
    }
}

/// Follows a path of `use` and the braces it ends with; gives where it ends.
fn read_tree(tokens: &[String], mut at: usize, mut path: Names, tree: &mut Vec<(String, Names)>) -> usize {
    let sign = |at: usize| tokens.get(at).map_or("", String::as_str);
    loop {
        if sign(at) == "{" {
            at += 1;
            while !matches!(sign(at), "}" | "") {
                at = if sign(at) == "," { at + 1 } else { read_tree(tokens, at, path.clone(), tree) };
            }
            return at + 1;
        }
        path.push(sign(at).to_owned());
        at += 1;
        if sign(at) == "as" {
            tree.push((sign(at + 1).to_owned(), path));
            return at + 2;
        }
        if sign(at) != "::" {
            let name = path.iter().rev().find(|name| *name != "self").cloned();
            tree.push((name.unwrap_or_default(), path));
            return at;
        }
        at += 1;
    }
}

/// Words and signs of the code: comments, texts and the tests at the end are left out.
fn tokens(text: &str) -> Vec<String> {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let chars: Vec<char> = text.chars().collect();
    let (mut tokens, mut at) = (Vec::new(), 0);
    while at < chars.len() {
        let rest = &chars[at..];
        let count = |is: fn(&char) -> bool| rest.iter().take_while(|c| is(c)).count();
        match rest {
            ['/', '/', ..] => at += count(|c| *c != '\n'),
            ['/', '*', ..] => {
                at += rest.windows(2).position(|pair| pair == ['*', '/']).unwrap_or(rest.len()) + 2
            }
            ['r', '#', '"', ..] => {
                at += 3 + rest[3..].windows(2).position(|pair| pair == ['"', '#']).unwrap_or(rest.len()) + 2;
            }
            ['"', ..] => {
                at += 1;
                while at < chars.len() && chars[at] != '"' {
                    at += if chars[at] == '\\' { 2 } else { 1 };
                }
                at += 1;
            }
            ['\'', '\\', _, '\'', ..] => at += 4,
            ['\'', _, '\'', ..] => at += 3,
            [':', ':', ..] => {
                tokens.push("::".into());
                at += 2;
            }
            [c, ..] if c.is_alphanumeric() || *c == '_' => {
                let length = count(|c| c.is_alphanumeric() || *c == '_');
                tokens.push(rest[..length].iter().collect());
                at += length;
            }
            [c, ..] => {
                if !c.is_whitespace() {
                    tokens.push(c.to_string());
                }
                at += 1;
            }
            [] => break,
        }
    }
    tokens
}

/// Every largest set of files that reach each other, with the arrows that tie it.
fn circles(arrows: &Arrows) -> Vec<String> {
    let reach = |from: &PathBuf| {
        let (mut reached, mut stack) = (BTreeSet::new(), vec![from]);
        while let Some(file) = stack.pop() {
            stack.extend(
                arrows.get(file).into_iter().flatten().filter(|next| reached.insert((*next).clone())),
            );
        }
        reached
    };
    let reached: BTreeMap<&PathBuf, BTreeSet<PathBuf>> =
        arrows.keys().map(|file| (file, reach(file))).collect();
    let mut circles = BTreeSet::new();
    for (file, to) in &reached {
        if to.contains(*file) {
            circles.insert(to.iter().filter(|other| reached[other].contains(*file)).collect::<BTreeSet<_>>());
        }
    }
    let show = |circle: &BTreeSet<&PathBuf>| {
        let mut text = format!("{} files", circle.len());
        for file in circle {
            for to in arrows[*file].iter().filter(|to| circle.contains(to)) {
                text += &format!("\n  {} -> {}", file.display(), to.display());
            }
        }
        text
    };
    circles.iter().map(show).collect()
}
