//! Shader composition: `#import path` pulls in a piece once; `{NAME}` in a path is a choice.

use std::collections::BTreeSet;

use crate::error::{Error, Result};

macro_rules! shaders {
    ($($path:literal),* $(,)?) => {
        /// Every shader of the project: its path under `shaders/` without the ending, and its text.
        const SHADERS: &[(&str, &str)] = &[$(($path, include_str!(concat!("../../shaders/", $path, ".wgsl")))),*];
    };
}

shaders![
    "beams",
    "faces",
    "gradients",
    "march",
    "present",
    "segments",
    "slices",
    "blend/highest.inc",
    "blend/under.inc",
    "bound/highest.inc",
    "bound/none.inc",
    "count/contributing.inc",
    "count/off.inc",
    "count/on.inc",
    "cue/off.inc",
    "cue/on.inc",
    "fetch/exact.inc",
    "fetch/filter.inc",
    "gradient/exact.inc",
    "gradient/filter.inc",
    "gradient/fly.inc",
    "mode/emission_absorption.inc",
    "mode/grey.inc",
    "mode/mean.inc",
    "mode/minip.inc",
    "mode/mip.inc",
    "mode/normals.inc",
    "mode/phong.inc",
    "mode/shaded.inc",
    "mode/two_surfaces.inc",
    "sample/exact.inc",
    "sample/hardware.inc",
    "sample/nearest.inc",
    "sample/post.inc",
    "sample/pre.inc",
    "sample/pre_integrated.inc",
    "sample/tricubic.inc",
    "sample/tricubic_exact.inc",
    "shared/beams.inc",
    "shared/blocks.inc",
    "shared/bspline.inc",
    "shared/first_hit.inc",
    "shared/highest.inc",
    "shared/lanes.inc",
    "shared/march_settings.inc",
    "shared/mode_settings.inc",
    "shared/ray.inc",
    "shared/surface.inc",
    "shared/view.inc",
    "shared/walk.inc",
    "shared/window.inc",
    "skip/adaptive.inc",
    "skip/beam_cells.inc",
    "skip/bounds.inc",
    "skip/distance_map.inc",
    "skip/grid_dda.inc",
    "skip/octree_encoded.inc",
    "skip/oracle.inc",
    "skip/segment_list.inc",
    "skip/two_step.inc",
    "step/one.inc",
    "step/several.inc",
    "store/bricks.inc",
    "store/volume.inc",
];

/// The text of pass `root` with all imports resolved. `choices` fills `{NAME}`s in import paths.
///
/// # Errors
/// [`Error::Gpu`] that names the import that does not exist.
pub fn compose(root: &str, choices: &[(&str, &str)]) -> Result<String> {
    let mut text = String::new();
    append(root, choices, &mut BTreeSet::new(), &mut text)?;
    Ok(text)
}

fn append(
    path: &str,
    choices: &[(&str, &str)],
    seen: &mut BTreeSet<String>,
    text: &mut String,
) -> Result<()> {
    let source = SHADERS
        .iter()
        .find(|(name, _)| *name == path)
        .map(|(_, source)| source);
    let source = source.ok_or_else(|| Error::Gpu(format!("there is no shader {path}")))?;
    for line in source.lines() {
        let Some(import) = line.strip_prefix("#import ") else {
            text.push_str(line);
            text.push('\n');
            continue;
        };
        let mut import = format!("{}.inc", import.trim());
        for (name, choice) in choices {
            import = import.replace(&format!("{{{name}}}"), choice);
        }
        if seen.insert(import.clone()) {
            append(&import, choices, seen, text)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod branches;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shader_file_is_in_the_list() {
        fn visit(dir: &std::path::Path, found: &mut Vec<String>, root: &std::path::Path) {
            for entry in std::fs::read_dir(dir).unwrap().map(Result::unwrap) {
                let path = entry.path();
                if path.is_dir() {
                    visit(&path, found, root);
                } else {
                    let name = path
                        .strip_prefix(root)
                        .unwrap()
                        .to_str()
                        .unwrap()
                        .replace('\\', "/");
                    found.push(
                        name.strip_suffix(".wgsl")
                            .expect("only WGSL lies in shaders/")
                            .to_owned(),
                    );
                }
            }
        }
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
        let mut found = Vec::new();
        visit(&root, &mut found, &root);
        found.sort();
        let mut listed: Vec<_> = SHADERS.iter().map(|(name, _)| (*name).to_owned()).collect();
        listed.sort();
        assert_eq!(found, listed);
    }

    #[test]
    fn every_permutation_parses_and_validates() {
        let names = |folder: &str| -> Vec<&str> {
            let strip = |(name, _): &(&'static str, &str)| -> Option<&'static str> {
                name.strip_prefix(folder)?.strip_suffix(".inc")
            };
            SHADERS.iter().filter_map(strip).collect()
        };
        let mut composed = vec![
            compose("faces", &[]).unwrap(),
            compose("gradients", &[]).unwrap(),
            compose("present", &[]).unwrap(),
            compose("segments", &[("BOUND", "none")]).unwrap(),
        ];
        let classifications = ["post", "pre", "pre_integrated"];
        let mut samplers = names("sample/");
        samplers.retain(|name| !classifications.contains(name));
        let slices = |sampler, classification, mode, blend| {
            let choices = [
                ("SAMPLER", sampler),
                ("MODE", mode),
                ("CUE", "off"),
                ("CLASSIFICATION", classification),
                ("BLEND", blend),
            ];
            compose("slices", &choices).unwrap()
        };
        for &sampler in &samplers {
            for classification in classifications {
                composed.push(slices(
                    sampler,
                    classification,
                    "emission_absorption",
                    "under",
                ));
            }
            composed.push(slices(sampler, "post", "grey", "under"));
            for mode in ["mip", "minip"] {
                composed.push(slices(sampler, "post", mode, "highest"));
            }
        }
        let march_of =
            |store, skip, (sampler, classification), mode, bound, count, gradient, cue| {
                let choices = [
                    ("SKIP", skip),
                    ("SAMPLER", sampler),
                    ("CLASSIFICATION", classification),
                    ("MODE", mode),
                    ("BOUND", bound),
                    ("COUNT", count),
                    ("GRADIENT", gradient),
                    ("CUE", cue),
                    ("STORE", store),
                ];
                compose("march", &choices).unwrap()
            };
        let march = |skip, how, mode, bound, count, gradient, cue| {
            march_of("volume", skip, how, mode, bound, count, gradient, cue)
        };
        for skip in names("skip/") {
            for &sampler in &samplers {
                for mode in names("mode/") {
                    let bounds = if ["mip", "minip"].contains(&mode) {
                        &["none", "highest"][..]
                    } else {
                        &["none"]
                    };
                    for count in names("count/") {
                        for bound in bounds {
                            let post = (sampler, "post");
                            composed.push(march(skip, post, mode, bound, count, "fly", "off"));
                        }
                    }
                }
                // Modes with a table.
                for classification in ["pre", "pre_integrated"] {
                    for mode in ["emission_absorption", "shaded"] {
                        let how = (sampler, classification);
                        composed.push(march(skip, how, mode, "none", "off", "fly", "off"));
                    }
                }
            }
        }
        // Gradients and cues are the modes' alone.
        for mode in names("mode/") {
            for gradient in names("gradient/") {
                for cue in names("cue/") {
                    let how = ("hardware", "post");
                    composed.push(march("bounds", how, mode, "none", "off", gradient, cue));
                }
            }
        }
        // Bricks hold what one sampler reads for one classification.
        for skip in ["beam_cells", "oracle"] {
            for mode in names("mode/") {
                for count in ["off", "on"] {
                    let how = ("exact", "post");
                    composed.push(march_of(
                        "bricks", skip, how, mode, "none", count, "fly", "off",
                    ));
                }
            }
        }
        for text in composed {
            let module = naga::front::wgsl::parse_str(&text)
                .unwrap_or_else(|e| panic!("{}", e.emit_to_string(&text)));
            naga::valid::Validator::new(
                naga::valid::ValidationFlags::all(),
                naga::valid::Capabilities::empty(),
            )
            .validate(&module)
            .unwrap_or_else(|e| panic!("{}", e.emit_to_string(&text)));
            assert_eq!(super::branches::on_uniforms(&module), [""; 0], "{text}");
        }
    }

    #[test]
    fn an_unknown_import_is_named() {
        let error = compose("march", &[("SKIP", "nowhere")])
            .unwrap_err()
            .to_string();
        assert!(error.contains("skip/nowhere"), "{error}");
    }
}
