//! The window of the system.

use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::PathBuf;
use std::rc::Rc;

use eframe::egui::{self, ThemePreference, ViewportBuilder};
use eframe::egui_wgpu::WgpuConfiguration;

use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::volume::Source;

use super::app::{App, Carried};
use super::direct::WindowGpu;
use super::session::{self, Kept, Recent};

/// What the window begins with.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Volumes to open.
    pub volumes: Vec<Source>,
    /// A session to restore.
    pub session: Option<PathBuf>,
    /// A light theme in place of a dark one.
    pub light: bool,
    /// How much larger everything is drawn.
    pub scale: f32,
}

/// The window while it is open, and what of it outlives its device.
struct Window {
    app: App,
    gpu: Gpu,
    survivor: Survivor,
}

/// Where a window whose device was lost leaves what was open in it.
type Survivor = Rc<RefCell<Option<Carried>>>;

impl eframe::App for Window {
    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        visuals.panel_fill.to_normalized_gamma_f32()
    }

    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        if self.gpu.is_lost() {
            ui.send_viewport_cmd(egui::ViewportCommand::Close);
        } else {
            self.app.show(ui);
        }
    }
}

impl Drop for Window {
    fn drop(&mut self) {
        // However it ends: painting on a lost device may panic before the window can be closed.
        if self.gpu.is_lost() {
            *self.survivor.borrow_mut() = Some(self.app.carry_on());
        }
    }
}

/// Opens the window, and returns when it is closed. A window whose device is lost is opened anew, with all that was open.
///
/// # Errors
/// [`Error::Io`], [`Error::File`] where the session cannot be read; [`Error::Setting`] where no window can be opened.
pub fn run(options: &Options) -> Result<()> {
    let mut kept = options.session.as_deref().map(session::read).transpose()?;
    let survivor = Survivor::default();
    let mut carried: Option<Carried> = None;
    loop {
        let opened = Opened {
            kept: kept.take().unwrap_or_default(),
            carried: carried.take(),
        };
        let (options, left) = (options.clone(), Rc::clone(&survivor));
        let begin = move |creation: &eframe::CreationContext<'_>| {
            let window = begin(creation, &options, opened, left)?;
            Ok(Box::new(window) as Box<dyn eframe::App>)
        };
        let shown = catch_unwind(AssertUnwindSafe(|| show(begin)));
        carried = survivor.borrow_mut().take();
        match (shown, &carried) {
            (_, Some(_)) => tracing::warn!("the window's device was lost: opening the window anew"),
            (Ok(shown), None) => return shown,
            (Err(panic), None) => resume_unwind(panic),
        }
    }
}

type Begun = std::result::Result<Box<dyn eframe::App>, Box<dyn std::error::Error + Send + Sync>>;

fn show(begin: impl FnOnce(&eframe::CreationContext<'_>) -> Begun + 'static) -> Result<()> {
    let native = eframe::NativeOptions {
        viewport: ViewportBuilder::default()
            .with_title("hollowcast")
            .with_app_id("hollowcast")
            .with_inner_size([1280.0, 720.0])
            .with_min_inner_size([800.0, 500.0])
            .with_drag_and_drop(true),
        // Pictures are in eight bits before they are painted: noise would only make them others, and take time.
        dithering: false,
        wgpu_options: WgpuConfiguration {
            wgpu_setup: WindowGpu::setup(),
            ..WgpuConfiguration::default()
        },
        ..eframe::NativeOptions::default()
    };
    eframe::run_native("hollowcast", native, Box::new(begin)).map_err(|error| {
        let error = one_line(&error.to_string());
        // Before the last colon stands where in the windowing library it was found.
        let reason = error.rsplit(": ").next().unwrap_or(&error);
        Error::setting("display", format!("no window could be opened: {reason}"))
    })
}

/// What a window begins with besides its options.
struct Opened {
    kept: Vec<Kept>,
    carried: Option<Carried>,
}

fn begin(
    creation: &eframe::CreationContext<'_>,
    options: &Options,
    opened: Opened,
    survivor: Survivor,
) -> std::result::Result<Window, Box<dyn std::error::Error + Send + Sync>> {
    let context = &creation.egui_ctx;
    context.set_theme(if options.light {
        ThemePreference::Light
    } else {
        ThemePreference::Dark
    });
    context.set_zoom_factor(options.scale);
    let state = creation.wgpu_render_state.as_ref();
    let window = WindowGpu::new(state.ok_or("the window has no device")?);
    let gpu = window.gpu.clone();
    let direct = (!gpu.is_software()).then_some(window);
    let mut app = App::new(context, Recent::load(), direct)?;
    if let Some(carried) = opened.carried {
        app.go_on_with(carried);
    } else {
        app.restore(opened.kept);
        for source in &options.volumes {
            app.open(source.clone());
        }
    }
    Ok(Window { app, gpu, survivor })
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
