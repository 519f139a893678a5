//! What a suite is refused for before anything of it is measured.

use std::path::Path;

use super::file::{Suite, Sweep};
use crate::error::{Error, Result};
use crate::mode::MODES;
use crate::octree::BLOCKS;
use crate::render::{BackendChoice, MethodChoice};

/// Flags of `hollowcast compare` that a scene's `flags` cannot hold: sweeps and scenes say them, or bench reads them not.
const OWN: &[&str] = &[
    "--tf",
    "--camera",
    "--size",
    "--mode",
    "--modes",
    "--sampler",
    "--classification",
    "--ert",
    "--views",
    "--steps",
    "--backends",
    "--methods",
    "--blocks",
    "--repeat",
    "--against",
    "--reference-views",
    "--reference-size",
    "--renderer",
    "--slices",
    "--json",
];

/// Cases that a suite may come to: days of measuring.
const MAX_CASES: f64 = 10_000.0;

impl Sweep {
    /// How many cases it comes to at most; those that stand for one another are not taken off.
    fn cases(&self) -> f64 {
        [
            self.scenes.len(),
            self.backends.len(),
            self.methods.len(),
            self.blocks.len(),
            self.steps.len(),
            self.samplers.len(),
            self.classifications.len().max(1),
            self.modes.len(),
            self.ert.len(),
            self.sizes.len(),
        ]
        .into_iter()
        .map(|n| n as f64)
        .product()
    }
}

impl Suite {
    /// Checks what can be told without a volume.
    ///
    /// # Errors
    /// [`Error::Setting`] naming the field.
    pub(super) fn check(&self) -> Result<()> {
        at_least_one("repeat", self.repeat > 0)?;
        at_least_one("scene", !self.scenes.is_empty())?;
        at_least_one("sweep", !self.sweeps.is_empty())?;
        for (i, scene) in self.scenes.iter().enumerate() {
            let field = |name: &str| format!("scene \"{}\": {name}", scene.name.escape_debug());
            if self.scenes[..i].iter().any(|s| s.name == scene.name) {
                return Err(Error::setting(field("name"), "another scene has it too"));
            }
            at_least_one(&field("views"), scene.views > 0)?;
            if let Some(stand_in) = &scene.stand_in
                && !stand_in.starts_with("phantom:")
            {
                return Err(Error::setting(
                    field("stand_in"),
                    "expected phantom:NAME:SIZE",
                ));
            }
            if Path::new(&scene.volume).is_absolute() {
                let reason = "expected a file's name in the folder of data, or phantom:NAME:SIZE";
                return Err(Error::setting(field("volume"), reason));
            }
            let name = |word| str::split(word, '=').next().unwrap_or_default();
            if let Some(flag) = scene
                .flags
                .iter()
                .map(String::as_str)
                .map(name)
                .find(|f| OWN.contains(f))
            {
                let reason = format!("{flag} is the suite's own to say, or not read by bench");
                return Err(Error::setting(field("flags"), reason));
            }
        }
        for (i, sweep) in self.sweeps.iter().enumerate() {
            let field = |name: &str| format!("sweep {}: {name}", i + 1);
            for (name, is_empty) in [
                ("scenes", sweep.scenes.is_empty()),
                ("backends", sweep.backends.is_empty()),
                ("methods", sweep.methods.is_empty()),
                ("blocks", sweep.blocks.is_empty()),
                ("steps", sweep.steps.is_empty()),
                ("samplers", sweep.samplers.is_empty()),
                ("modes", sweep.modes.is_empty()),
                ("ert", sweep.ert.is_empty()),
                ("sizes", sweep.sizes.is_empty()),
                ("repeat", sweep.repeat == Some(0)),
            ] {
                at_least_one(&field(name), !is_empty)?;
            }
            for scene in &sweep.scenes {
                self.check_scene(&field("scenes"), scene)?;
            }
            check_names(&field("backends"), &sweep.backends, is_backend)?;
            check_names(&field("methods"), &sweep.methods, is_method)?;
        }
        let cases = self.sweeps.iter().map(Sweep::cases).sum::<f64>();
        if cases > MAX_CASES {
            let reason = format!("{cases} cases; at most {MAX_CASES} are possible");
            return Err(Error::setting("sweep", reason));
        }
        let groups = self.groups();
        if groups.is_empty() {
            let reason =
                "there is nothing to measure: no backend has any of the methods with the rest";
            return Err(Error::setting("sweep", reason));
        }
        for (i, picture) in self.pictures.iter().enumerate() {
            let field = |name: &str| format!("picture {}: {name}", i + 1);
            self.check_scene(&field("scene"), &picture.scene)?;
            at_least_one(&field("methods"), !picture.methods.is_empty())?;
            let backend = std::slice::from_ref(&picture.backend);
            check_names(&field("backend"), backend, is_backend)?;
            check_names(&field("methods"), &picture.methods, is_method)?;
            let mode = std::slice::from_ref(&picture.mode);
            check_names(&field("mode"), mode, |name| {
                MODES.iter().any(|row| row.name == name)
            })?;
            if !BLOCKS.contains(&picture.block) {
                let reason = "expected 2, 4, 8, 16, 32 or 64 voxels";
                return Err(Error::setting(field("block"), reason));
            }
            if picture
                .methods
                .iter()
                .any(|m| m == MethodChoice::Auto.name())
            {
                let reason = "auto draws what another method draws: name that";
                return Err(Error::setting(field("methods"), reason));
            }
            let scene = self.scene(&picture.scene);
            if !groups.iter().any(|g| Some(g.scene) == scene) {
                let reason = "nothing is measured of it: name it in a sweep";
                return Err(Error::setting(field("scene"), reason));
            }
            if !(1..=1024).contains(&picture.size) {
                return Err(Error::setting(field("size"), "expected 1 to 1024 pixels"));
            }
        }
        Ok(())
    }

    fn check_scene(&self, field: &str, name: &str) -> Result<()> {
        check_names(field, &[name.to_owned()], |n| self.scene(n).is_some())
    }
}

fn is_backend(name: &str) -> bool {
    BackendChoice::ALL.iter().any(|b| b.name() == name)
}

fn is_method(name: &str) -> bool {
    MethodChoice::from_name(name).is_some()
}

fn check_names(field: &str, names: &[String], is_known: impl Fn(&str) -> bool) -> Result<()> {
    match names.iter().find(|name| !is_known(name)) {
        Some(name) => {
            let reason = format!("there is no \"{}\"", name.escape_debug());
            Err(Error::setting(field, reason))
        }
        None => Ok(()),
    }
}

fn at_least_one(field: &str, has: bool) -> Result<()> {
    if has {
        Ok(())
    } else {
        Err(Error::setting(field, "must be at least one"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"
name = "small"
[[scene]]
name = "ball"
volume = "phantom:sphere:16"
[[scene]]
name = "cube"
volume = "phantom:menger:27"
[[sweep]]
scenes = ["ball"]
backends = ["cpu"]
methods = ["box", "hull"]
steps = ["0.5"]
[[picture]]
scene = "ball"
backend = "cpu"
methods = ["box"]
step = "1"
size = 16
"#;

    #[test]
    fn what_would_vanish_is_refused() {
        assert!(Suite::from_toml(GOOD).is_ok());
        for (from, to, named) in [
            (
                "size = 16",
                "size = 16\nmode = \"mop\"",
                "picture 1: mode: there",
            ),
            (
                "size = 16",
                "size = 16\nblock = 5",
                "picture 1: block: expected",
            ),
            ("[\"box\"]", "[\"auto\"]", "picture 1: methods: auto"),
            (
                "scene = \"ball\"",
                "scene = \"cube\"",
                "picture 1: scene: nothing is measured",
            ),
            (
                "steps = [\"0.5\"]",
                "steps = [\"0.5\"]\nsamplers = [\"hardware\"]",
                "sweep: there is nothing to measure",
            ),
            (
                "volume = \"phantom:sphere:16\"",
                "volume = \"phantom:sphere:16\"\nflags = [\"--renderer=slices\"]",
                "scene \"ball\": flags: --renderer is",
            ),
        ] {
            assert!(GOOD.contains(from));
            let error = Suite::from_toml(&GOOD.replace(from, to)).unwrap_err();
            let line = error.to_string();
            assert!(error.is_bad_input() && line.starts_with(named), "{line}");
        }
    }
}
