//! The structure of the crate as DESIGN.md describes it: layers, no circles, short files.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

const MAX_LINES: usize = 400;

/// From the lowest: a module uses only modules of lower layers, or its own.
const LAYERS: [&[&str]; 8] = [
    &["format"],
    &["error"],
    &["arrays", "points", "interrupt", "threads", "simd"],
    &["assignment", "accuracy", "consistency"],
    &["point_sets", "diagnostics", "vessel"],
    &["trajectories", "tracking"],
    &["monte_carlo"],
    &["lib"],
];

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// Every file below a folder, by its module path: `point_sets::ospa`.
fn files(folder: &Path, prefix: &str, found: &mut BTreeMap<String, PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let stem = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let name = if prefix.is_empty() { stem.clone() } else { format!("{prefix}::{stem}") };
        if path.is_dir() {
            files(&path, &name, found);
        } else if path.extension().is_some_and(|e| e == "rs") && stem != "tests" {
            found.insert(if stem == "mod" { prefix.to_owned() } else { name }, path);
        }
    }
}

fn all() -> BTreeMap<String, PathBuf> {
    let mut found = BTreeMap::new();
    files(&source(), "", &mut found);
    found
}

/// The code of a file without its tests and comments.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let text = text.split("#[cfg(test)]").next().unwrap();
    let lines = text.lines().map(|line| line.split("//").next().unwrap());
    lines.collect::<Vec<_>>().join("\n")
}

/// The paths that `use` declarations name, groups written out.
fn used_paths(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for statement in text.split(';') {
        let Some(start) = statement.rfind("use ") else { continue };
        let path: String = statement[start + 4..].split_whitespace().collect();
        let (base, group) = path.split_once("::{").unwrap_or((path.as_str(), ""));
        found.push(base.to_owned());
        let group = group.trim_end_matches('}');
        found.extend(group.split(',').map(|name| format!("{base}::{name}")));
    }
    found
}

/// Which files a file uses.
fn uses(name: &str, path: &Path, known: &BTreeMap<String, PathBuf>) -> BTreeSet<String> {
    let parent = match path.file_stem().unwrap().to_str().unwrap() {
        "mod" => name.to_owned(),
        _ => name.rsplit_once("::").map_or(String::new(), |(parent, _)| parent.to_owned()),
    };
    let mut found = BTreeSet::new();
    for path in used_paths(&code(path)) {
        let absolute = if let Some(rest) = path.strip_prefix("crate::") {
            rest.to_owned()
        } else if let Some(rest) = path.strip_prefix("super::") {
            if parent.is_empty() { rest.to_owned() } else { format!("{parent}::{rest}") }
        } else {
            continue;
        };
        // The longest part of the path that is a file.
        let parts: Vec<&str> = absolute.split("::").collect();
        let mut candidates = (1..=parts.len()).rev().map(|n| parts[..n].join("::"));
        if let Some(file) = candidates.find(|file| known.contains_key(file)) {
            found.insert(file);
        }
    }
    found.remove(name);
    found
}

fn graph() -> BTreeMap<String, BTreeSet<String>> {
    let known = all();
    known.iter().map(|(name, path)| (name.clone(), uses(name, path, &known))).collect()
}

#[test]
fn no_file_uses_itself_through_others() {
    let mut graph = graph();
    assert!(graph.values().map(BTreeSet::len).sum::<usize>() > 150, "the graph is read");
    loop {
        let is_done =
            |(name, uses): (&String, &BTreeSet<String>)| uses.is_empty().then(|| name.clone());
        let done: Vec<String> = graph.iter().filter_map(is_done).collect();
        if done.is_empty() {
            break;
        }
        for name in &done {
            graph.remove(name);
        }
        graph.values_mut().for_each(|uses| uses.retain(|name| !done.contains(name)));
    }
    assert!(graph.is_empty(), "in a circle, or above one: {graph:?}");
}

#[test]
fn modules_use_lower_layers() {
    let layer = |name: &str| {
        let top = name.split("::").next().unwrap();
        LAYERS.iter().position(|names| names.contains(&top)).unwrap_or_else(|| panic!("{top}"))
    };
    for (name, uses) in graph() {
        for other in uses {
            let own = name.split("::").next() == other.split("::").next();
            let shared = layer(&name) == 2 && layer(&other) == 2;
            assert!(own || shared || layer(&other) < layer(&name), "{name} uses {other}");
        }
    }
}

#[test]
fn files_are_read_in_one_sitting() {
    let binding = source().join("../../py/src");
    let mut found = all();
    files(&binding, "binding", &mut found);
    for (name, path) in found {
        let lines = fs::read_to_string(path).unwrap().lines().count();
        assert!(lines < MAX_LINES, "{name} has {lines} lines");
    }
}
