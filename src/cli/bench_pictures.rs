//! The pictures of `hollowcast bench`.

use hollowcast::measure::compare::settings_on;
use hollowcast::measure::suite::{self, PictureRecord, PictureRow, Record, Shown, What};
use hollowcast::mode::MODES;
use hollowcast::render::MethodChoice;
use hollowcast::{Error, Result};

use super::bench::{Bench, Planned, has, settings};
use super::suite_words;

impl Bench<'_> {
    /// Draws a row of pictures of a group's scene, if it is not in the results yet.
    pub(super) fn show(&mut self, row: &PictureRow, planned: &Planned) -> Result<()> {
        let place = self.backends.iter().position(|n| *n == row.backend);
        let Some(renderer) = place.filter(|_| !self.has_pictures(row)) else {
            return Ok(());
        };
        self.load(planned)?;
        let shown = self.shown(row, planned, renderer)?;
        let Some(first) = shown.first() else {
            let scene = row.scene.escape_debug();
            let backend = &row.backend;
            eprintln!(
                "notice: no picture of \"{scene}\": {backend} has none of its methods in this mode"
            );
            return Ok(());
        };
        let about = PictureRecord {
            command: self.truth_command(row, planned.group.scene),
            scene: row.scene.clone(),
            backend: row.backend.clone(),
            method: String::new(),
            block: row.block,
            step: row.step.clone(),
            mode: row.mode.clone(),
            what: What::Picture,
            scale: 1.0,
            size: [row.size; 2],
            png: String::new(),
        };
        let truths = &mut self.loaded.as_mut().expect("loaded just above").truths;
        let truth = truths.of(&first.settings, |_| ())?;
        let pictures = suite::pictures(&mut self.renderers[renderer], &shown, &truth, &about)?;
        self.results.pictures.extend(pictures.iter().cloned());
        self.writer.append(&[Record::Pictures { pictures }])?;
        Ok(())
    }

    /// The words that all pictures of a row begin with.
    fn words(&self, row: &PictureRow, scene: usize) -> Vec<String> {
        let mut words = self.suite.scenes[scene].words(&self.places[scene].path);
        words.extend(["--size".to_owned(), row.size.to_string()]);
        if row.mode != MODES[0].name {
            words.extend(["--mode".to_owned(), row.mode.clone()]);
        }
        words
    }

    fn truth_command(&self, row: &PictureRow, scene: usize) -> String {
        let output = ["-o".to_owned(), "truth.png".to_owned()];
        let words: Vec<String> = self.words(row, scene).into_iter().chain(output).collect();
        suite_words::line("truth", &self.places[scene].word, &words)
    }

    /// Whether a row is in the results.
    fn has_pictures(&self, row: &PictureRow) -> bool {
        self.results.pictures.iter().any(|p| {
            let of_row = (&row.scene, &row.backend, &row.step, &row.mode, row.block);
            (&p.scene, &p.backend, &p.step, &p.mode, p.block) == of_row
                && p.size == [row.size; 2]
                && row.methods.contains(&p.method)
        })
    }

    /// The methods of a row that the renderer has.
    fn shown(&self, row: &PictureRow, planned: &Planned, renderer: usize) -> Result<Vec<Shown>> {
        let place = &self.places[planned.group.scene];
        let volume = &self.loaded.as_ref().expect("loaded by the caller").volume;
        let renderer = &self.renderers[renderer];
        let mut shown = Vec::new();
        for method in &row.methods {
            let words = self.words(row, planned.group.scene);
            let block = row.block.to_string();
            let with = |flags: [&str; 4]| {
                let values = [&row.step, &row.backend, method, &block];
                let pairs = flags.iter().zip(values);
                let more = pairs.flat_map(|(flag, value)| [(*flag).to_owned(), value.clone()]);
                words.iter().cloned().chain(more).collect::<Vec<String>>()
            };
            // compare takes lists where render takes one.
            let of_compare = with(["--steps", "--backends", "--methods", "--blocks"]);
            let of_render = with(["--step", "--backend", "--method", "--block"]);
            let args = suite_words::parsed(&of_compare).map_err(|reason| {
                Error::setting(format!("picture of \"{}\"", row.scene), reason)
            })?;
            let (_, mode) = args.scene.transfer_and_mode(volume)?;
            let camera = args.scene.camera.camera(volume, 0.0);
            let settings = settings(&args, mode, volume, camera)?;
            if let MethodChoice::Only(skip) = args.methods[0]
                && has(renderer, skip, &settings)
            {
                shown.push(Shown {
                    command: suite_words::line("render", &place.word, &of_render),
                    method: method.clone(),
                    settings: settings_on(renderer.info().backend, &settings),
                });
            }
        }
        Ok(shown)
    }
}
