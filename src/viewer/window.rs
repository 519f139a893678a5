//! The window of the system.

use std::path::PathBuf;

use eframe::egui::{self, ThemePreference, ViewportBuilder};

use crate::error::{Error, Result};

use super::app::App;
use super::session::{self, Kept, Recent};

/// What the window begins with.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Volumes to open, as the command names them.
    pub volumes: Vec<String>,
    /// A session to restore.
    pub session: Option<PathBuf>,
    /// A light theme in place of a dark one.
    pub light: bool,
    /// How much larger everything is drawn.
    pub scale: f32,
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        self.show(ui);
    }
}

/// Opens the window, and returns when it is closed.
///
/// # Errors
/// [`Error::Io`], [`Error::File`] where the session cannot be read; [`Error::Setting`] where no window can be opened.
pub fn run(options: Options) -> Result<()> {
    let kept = options.session.as_deref().map(session::read).transpose()?;
    let native = eframe::NativeOptions {
        viewport: ViewportBuilder::default()
            .with_title("hollowcast")
            .with_app_id("hollowcast")
            .with_inner_size([1280.0, 720.0])
            .with_min_inner_size([800.0, 500.0])
            .with_drag_and_drop(true),
        // Pictures are in eight bits before they are painted: noise would only make them others, and take time.
        dithering: false,
        ..eframe::NativeOptions::default()
    };
    let begin = move |creation: &eframe::CreationContext<'_>| {
        begin(&creation.egui_ctx, &options, kept.unwrap_or_default())
    };
    eframe::run_native("hollowcast", native, Box::new(begin)).map_err(|error| {
        let error = one_line(&error.to_string());
        // Before the last colon stands where in the windowing library it was found.
        let reason = error.rsplit(": ").next().unwrap_or(&error);
        Error::setting("display", format!("no window could be opened: {reason}"))
    })
}

fn begin(
    context: &egui::Context,
    options: &Options,
    kept: Vec<Kept>,
) -> Result<Box<dyn eframe::App>, Box<dyn std::error::Error + Send + Sync>> {
    context.set_theme(if options.light {
        ThemePreference::Light
    } else {
        ThemePreference::Dark
    });
    context.set_zoom_factor(options.scale);
    let mut app = App::new(context, Recent::load())?;
    app.restore(kept);
    for volume in &options.volumes {
        app.open(volume);
    }
    Ok(Box::new(app))
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
