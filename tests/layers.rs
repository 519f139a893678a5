//! Imports point one way: a file may use its own module and those of a lower rank, nothing else.
//!
//! The order is that of the design (cli -> viewer -> measure -> render -> cpu, reference, skip, sample, mode -> gpu,
//! octree, transfer, camera -> volume -> error), with ranks of their own where modules of one group use one another.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Every module, by rank.
const LAYERS: &[&[&str]] = &[
    &["error"],
    // Ray arithmetic knows no volume: readers, tables and samplers are generic over its numbers.
    &["lattice", "text_file", "atomic_file"],
    &["volume"],
    &["camera", "transfer", "gpu"],
    &["sample", "mode"],
    // Activity of a block depends on the mode and on the sampler's apron, so culling stands above both.
    // A scene names the three choices but no way to draw.
    &["octree", "scene"],
    // Methods read the occupancy that culling leaves.
    &["skip"],
    &["reference", "cpu"],
    // Picture files know pictures, not who drew them.
    &["render", "output"],
    &["measure"],
    &["report"],
    &["viewer"],
    &["cli"],
];

/// Names that other modules leave at the crate's root.
const ROOT_NAMES: &[(&str, &str)] = &[
    ("Error", "error"),
    ("Result", "error"),
    ("with_voxels", "volume"),
];

fn rank(module: &str) -> Option<usize> {
    LAYERS.iter().position(|layer| layer.contains(&module))
}

/// Identifiers and single characters of Rust source, without comments, literals and lifetimes.
fn tokens(source: &str) -> Vec<String> {
    let chars: Vec<char> = source.chars().collect();
    let at = |i: usize| chars.get(i).copied().unwrap_or('\0');
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut tokens = Vec::new();
    let mut i = 0;
    while i < chars.len() {
        let start = i;
        match at(i) {
            '/' if at(i + 1) == '/' => {
                while i < chars.len() && at(i) != '\n' {
                    i += 1;
                }
            }
            '/' if at(i + 1) == '*' => {
                let mut depth = 0;
                while i < chars.len() {
                    match (at(i), at(i + 1)) {
                        ('/', '*') => (depth, i) = (depth + 1, i + 2),
                        ('*', '/') => (depth, i) = (depth - 1, i + 2),
                        _ => i += 1,
                    }
                    if depth == 0 {
                        break;
                    }
                }
            }
            'r' if at(i + 1) == '"'
                || (at(i + 1) == '#' && (at(i + 2) == '"' || at(i + 2) == '#')) =>
            {
                let hashes = chars[i + 1..].iter().take_while(|&&c| c == '#').count();
                i += hashes + 2;
                let ends = |i: usize| at(i) == '"' && (1..=hashes).all(|h| at(i + h) == '#');
                while i < chars.len() && !ends(i) {
                    i += 1;
                }
                i += hashes + 1;
            }
            '"' => {
                i += 1;
                while i < chars.len() && at(i) != '"' {
                    i += if at(i) == '\\' { 2 } else { 1 };
                }
                i += 1;
            }
            '\'' if at(i + 1) == '\\' || at(i + 2) == '\'' => {
                i += if at(i + 1) == '\\' { 3 } else { 2 };
                while i < chars.len() && at(i) != '\'' {
                    i += 1;
                }
                i += 1;
            }
            c if is_word(c) => {
                while is_word(at(i)) {
                    i += 1;
                }
                tokens.push(chars[start..i].iter().collect());
            }
            c => {
                if !c.is_whitespace() {
                    tokens.push(c.to_string());
                }
                i += 1;
            }
        }
    }
    tokens
}

/// The first names after `crate::` (or another path to the root) whose tokens start at `i`: several where they are a
/// group.
fn names_after(tokens: &[String], mut i: usize) -> Vec<&str> {
    let token = |i: usize| tokens.get(i).map_or("", String::as_str);
    if token(i) != "{" {
        return vec![token(i)];
    }
    let mut names = Vec::new();
    let mut depth = 0;
    loop {
        match token(i) {
            "{" => {
                depth += 1;
                if depth == 1 {
                    names.push(token(i + 1));
                }
            }
            "}" => depth -= 1,
            "," if depth == 1 && token(i + 1) != "}" => names.push(token(i + 1)),
            "" => break,
            _ => {}
        }
        if depth == 0 {
            break;
        }
        i += 1;
    }
    names
}

/// The root's names that a file uses. `depth` is how many modules the file's own lies below the root.
fn root_names(source: &str, depth: usize) -> Vec<String> {
    let tokens = tokens(source);
    let token = |i: usize| tokens.get(i).map_or("", String::as_str);
    let path_follows = |i: usize| token(i) == ":" && token(i + 1) == ":";
    let mut names = Vec::new();
    // Braces that are open, and whether each opened a module.
    let mut open: Vec<bool> = Vec::new();
    let mut i = 0;
    while i < tokens.len() {
        match token(i) {
            "{" => open.push(i >= 2 && token(i - 2) == "mod"),
            "}" => {
                open.pop();
            }
            "crate" | "hollowcast" if path_follows(i + 1) => {
                names.extend(names_after(&tokens, i + 3));
            }
            "super" if path_follows(i + 1) => {
                let mut climbed = 1;
                while token(i + 3) == "super" && path_follows(i + 4) {
                    climbed += 1;
                    i += 3;
                }
                let inline = open.iter().filter(|&&module| module).count();
                if climbed >= depth + inline {
                    names.extend(names_after(&tokens, i + 3));
                }
            }
            _ => {}
        }
        i += 1;
    }
    names.into_iter().map(str::to_owned).collect()
}

/// What is wrong with the imports of the file of `module` whose source this is; empty where nothing is.
fn violations(module: &str, depth: usize, source: &str) -> Vec<String> {
    let Some(own) = rank(module) else {
        return vec![format!("module {module} has no rank in LAYERS")];
    };
    let mut wrong = Vec::new();
    for name in root_names(source, depth) {
        let used = ROOT_NAMES
            .iter()
            .find(|(n, _)| *n == name)
            .map_or(name.as_str(), |(_, m)| m);
        match rank(used) {
            _ if used == module => {}
            Some(rank) if rank < own => {}
            Some(_) => wrong.push(format!("{module} uses {used}, which is not below it")),
            None => wrong.push(format!("{module} uses {used}, which has no rank in LAYERS")),
        }
    }
    wrong
}

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("src can be listed") {
        let path = entry.expect("src can be listed").path();
        if path.is_dir() {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn imports_point_one_way() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    rust_files(&src, &mut files);
    files.sort();
    assert!(files.len() > 10);
    let mut report = String::new();
    for file in files {
        let relative = file.strip_prefix(&src).expect("it was found there");
        let mut path: Vec<String> = relative
            .with_extension("")
            .iter()
            .map(|part| part.to_string_lossy().into_owned())
            .collect();
        if path.len() > 1 && path.last().is_some_and(|last| last == "mod") {
            path.pop();
        }
        // The roots of the library and the command stand above all modules; binaries of their own too.
        if ["lib", "main", "bin"].contains(&path[0].as_str()) {
            continue;
        }
        let source = std::fs::read_to_string(&file).expect("source is UTF-8");
        for wrong in violations(&path[0], path.len(), &source) {
            let _ = writeln!(report, "src/{}: {wrong}", relative.display());
        }
    }
    assert!(report.is_empty(), "\n{report}");
}

#[test]
fn every_way_to_name_a_higher_layer_is_found() {
    let wrong = |module: &str, depth: usize, source: &str| violations(module, depth, source).len();
    assert_eq!(wrong("volume", 1, "use crate::render::Renderer;"), 1);
    assert_eq!(
        wrong(
            "volume",
            1,
            "use crate::{error::{Error, Result}, skip, mode::Mode};"
        ),
        2
    );
    assert_eq!(
        wrong(
            "volume",
            1,
            "fn f() { crate::skip::Skip::Box; $crate::camera::f() }"
        ),
        2
    );
    assert_eq!(wrong("volume", 2, "use super::super::scene::Scene;"), 1);
    assert_eq!(wrong("volume", 1, "use super::scene::Scene;"), 1);
    assert_eq!(
        wrong("volume", 1, "mod tests { use super::super::scene::Scene; }"),
        1
    );
    assert_eq!(wrong("skip", 1, "use crate::unheard_of::Thing;"), 1);
    assert_eq!(wrong("unheard_of", 1, ""), 1);
    // A module of the same rank is not below.
    assert_eq!(wrong("sample", 1, "use crate::mode::Mode;"), 1);
}

#[test]
fn what_is_below_or_only_looks_like_an_import_is_allowed() {
    let source = r#"
        //! Not `use crate::cli::x`.
        /* nor /* crate::cli */ crate::cli */
        use crate::{Error, octree::Occupancy};
        use crate::skip::traversal::Line;
        use super::Listed;
        pub(crate) fn f<'a>(c: char) -> &'a str {
            if c == '"' || c == '\'' { "crate::cli\" crate::cli" } else { r"crate::cli\" }
        }
        mod tests { use super::*; use super::super::Listed; }
    "#;
    assert_eq!(violations("skip", 2, source), Vec::<String>::new());
    let raw = "const TEXT: &str = r#\"a\" crate::cli::x\"#;";
    assert_eq!(violations("skip", 2, raw), Vec::<String>::new());
}
