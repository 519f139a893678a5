//! Asking for a path: typed, or browsed for in the system's own dialog; and what is done with it.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use eframe::egui::{Align2, DragValue, Key, TextEdit, Ui, Window, vec2};

use crate::camera::Camera;
use crate::error::{Error, Result};
use crate::output::write_atomically;
use crate::transfer::TransferFunction;
use crate::volume::Source;

use super::app::App;
use super::dialogs::Dialog;
use super::document::Document;
use super::jobs::Job;
use super::rows;
use super::session;

/// What a path is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PathFor {
    /// A volume to open.
    Volume,
    /// A picture to write.
    Picture,
    /// A folder for the pictures of an orbit.
    Orbit,
    /// A transfer function to read.
    LoadTransfer,
    /// A transfer function to write.
    SaveTransfer,
    /// A session to read.
    Session,
    /// A session to write.
    SaveSession,
}

/// A path, typed or browsed for, and what else is to be known.
#[derive(Debug)]
pub(super) struct PathDialog {
    purpose: PathFor,
    text: String,
    size: Option<[u32; 2]>,
    transparent: bool,
    count: u32,
    browsing: bool,
    /// Whether the text has had the keyboard.
    focused: bool,
}

impl PathFor {
    fn title(self) -> &'static str {
        match self {
            Self::Volume => "Open a volume",
            Self::Picture => "Save a picture",
            Self::Orbit => "Save an orbit",
            Self::LoadTransfer => "Read a transfer function",
            Self::SaveTransfer => "Write the transfer function",
            Self::Session => "Restore a session",
            Self::SaveSession => "Save the session",
        }
    }

    fn hint(self) -> &'static str {
        match self {
            Self::Volume => "a file (NRRD, MetaImage, NIfTI, raw), or phantom:NAME:SIZE",
            Self::Picture => ".png, .npy or .exr",
            Self::Orbit => "a folder for 0000.png, 0001.png, …",
            Self::LoadTransfer | Self::SaveTransfer => "a TOML file of control points",
            Self::Session | Self::SaveSession => "a TOML file",
        }
    }

    fn usual(self) -> &'static str {
        match self {
            Self::Volume | Self::LoadTransfer | Self::Session => "",
            Self::Picture => "picture.png",
            Self::Orbit => "orbit",
            Self::SaveTransfer => "transfer.toml",
            Self::SaveSession => "session.toml",
        }
    }

    fn writes(self) -> bool {
        matches!(self, Self::Picture | Self::SaveTransfer | Self::SaveSession)
    }
}

impl Dialog {
    /// Asks for a path.
    pub(super) fn path(purpose: PathFor) -> Self {
        Self::Path(PathDialog {
            purpose,
            text: purpose.usual().to_owned(),
            size: None,
            transparent: false,
            count: 60,
            browsing: false,
            focused: false,
        })
    }
}

/// What the system's dialog was closed with.
pub(super) enum Picked {
    /// A path.
    Path(PathBuf),
    /// None: it was cancelled.
    Nothing,
    /// None, sooner than anyone could cancel it: there is no such dialog here.
    NotShown,
}

/// Nobody closes a dialog sooner.
const SEEN: Duration = Duration::from_millis(400);

/// Takes the path that the system's dialog was closed with.
pub(super) fn take_picked(app: &mut App) {
    while let Ok(picked) = app.picked.1.try_recv() {
        if let Some(Dialog::Path(dialog)) = &mut app.dialog {
            dialog.browsing = false;
            match picked {
                Picked::Path(path) => dialog.text = path.display().to_string(),
                Picked::Nothing => {}
                Picked::NotShown => app.complain(&Error::setting(
                    "dialog",
                    "the system shows none here (a desktop portal or zenity would); type the path",
                )),
            }
        }
    }
}

/// Asks for a path, and does what it was asked for.
pub(super) fn show(app: &mut App, ui: &Ui, mut dialog: PathDialog) {
    let mut is_open = true;
    let mut done = false;
    let purpose = dialog.purpose;
    if dialog.size.is_none() {
        dialog.size = app.full_size();
    }
    Window::new(purpose.title())
        .open(&mut is_open)
        .collapsible(false)
        .resizable(false)
        .anchor(Align2::CENTER_CENTER, vec2(0.0, 0.0))
        .show(ui.ctx(), |ui| {
            let label = ui.label(purpose.hint());
            let text = TextEdit::singleline(&mut dialog.text).desired_width(420.0);
            let response = ui
                .add(text)
                .labelled_by(label.id)
                .on_hover_text(purpose.hint());
            if !std::mem::replace(&mut dialog.focused, true) {
                response.request_focus();
            }
            done |= response.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
            options(app, ui, &mut dialog);
            ui.horizontal(|ui| {
                done |= ui.button("OK").on_hover_text(purpose.title()).clicked();
                let browse = eframe::egui::Button::new("Browse…");
                let browse = ui.add_enabled(!dialog.browsing, browse);
                if rows::tip(browse, "the system's own dialog").clicked() {
                    dialog.browsing = true;
                    browse_for(app, purpose, &dialog.text);
                }
            });
        });
    if done && !dialog.text.trim().is_empty() {
        if let Err(error) = app.carry_out(&dialog) {
            app.complain(&error);
        }
    } else if is_open {
        app.dialog = Some(Dialog::Path(dialog));
    }
}

/// What else is to be said of pictures.
fn options(app: &mut App, ui: &mut Ui, dialog: &mut PathDialog) {
    if !matches!(dialog.purpose, PathFor::Picture | PathFor::Orbit) {
        return;
    }
    let Some(size) = &mut dialog.size else {
        return;
    };
    ui.horizontal(|ui| {
        for (n, name) in size.iter_mut().zip(["width", "height"]) {
            let label = ui.label(name);
            ui.add(DragValue::new(n).range(1..=16384))
                .labelled_by(label.id)
                .on_hover_text("in pixels");
        }
        ui.checkbox(&mut dialog.transparent, "transparent")
            .on_hover_text("leave the background out");
        if dialog.purpose == PathFor::Orbit {
            let label = ui.label("pictures");
            ui.add(DragValue::new(&mut dialog.count).range(2..=3600))
                .labelled_by(label.id)
                .on_hover_text("evenly around the z axis");
        }
    });
    let copy = ui
        .button("copy the command line")
        .on_hover_text("that draws the same picture, bit for bit");
    if copy.clicked() {
        app.copy_command(dialog.text.trim(), *size, dialog.transparent);
    }
}

/// Opens the system's dialog, in a thread of its own.
fn browse_for(app: &App, purpose: PathFor, text: &str) {
    let sender = app.picked.0.clone();
    let context = app.context.clone();
    let name = Path::new(text)
        .file_name()
        .map(|n| n.to_string_lossy().into_owned());
    std::thread::spawn(move || {
        let mut dialog = rfd::FileDialog::new().set_title(purpose.title());
        if let Some(name) = name {
            dialog = dialog.set_file_name(name);
        }
        let asked = Instant::now();
        let picked = match purpose {
            PathFor::Orbit => dialog.pick_folder(),
            _ if purpose.writes() => dialog.save_file(),
            _ => dialog.pick_file(),
        };
        let picked = match picked {
            Some(path) => Picked::Path(path),
            None if asked.elapsed() < SEEN => Picked::NotShown,
            None => Picked::Nothing,
        };
        // A window that is gone needs no path.
        let _ = sender.send(picked);
        context.request_repaint();
    });
}

impl App {
    /// Writes the picture at a size, as the dialog does.
    ///
    /// # Errors
    /// For clip planes that are out of range.
    pub fn save_picture(&mut self, path: PathBuf, size: [u32; 2], transparent: bool) -> Result<()> {
        if let Some(shot) = self.shot(size, transparent)? {
            self.start_job(Job::Save(Box::new(shot), path));
        }
        Ok(())
    }

    /// Writes numbered pictures all around the z axis into a folder, as the dialog does.
    ///
    /// # Errors
    /// As [`Self::save_picture`].
    pub fn save_orbit(
        &mut self,
        folder: PathBuf,
        size: [u32; 2],
        transparent: bool,
        count: u32,
    ) -> Result<()> {
        let (Some(document), Some(shot)) = (self.document(), self.shot(size, transparent)?) else {
            return Ok(());
        };
        let voxel_size = document.volume.voxel_size();
        let turn = |i: u32| 360.0 * f64::from(i) / f64::from(count);
        let view = |i: u32| document.view.turned(turn(i), voxel_size).camera(voxel_size);
        let views: Vec<Camera> = (0..count).map(view).collect();
        self.start_job(Job::Orbit(Box::new(shot), views, folder));
        Ok(())
    }

    /// Writes what is open, and how it is looked at.
    ///
    /// # Errors
    /// [`Error::Io`] where the file cannot be written.
    pub fn save_session(&mut self, path: &Path) -> Result<()> {
        let kept: Vec<_> = self.documents.iter().map(Document::kept).collect();
        let text = session::to_toml(&kept)?;
        self.write_text(path, &text)
    }

    fn carry_out(&mut self, dialog: &PathDialog) -> Result<()> {
        let path = PathBuf::from(dialog.text.trim());
        let size = dialog.size.unwrap_or([512; 2]);
        match dialog.purpose {
            PathFor::Volume => self.open(Source::new(dialog.text.trim())),
            PathFor::Picture => self.save_picture(path, size, dialog.transparent)?,
            PathFor::Orbit => self.save_orbit(path, size, dialog.transparent, dialog.count)?,
            PathFor::LoadTransfer => {
                let transfer = TransferFunction::from_file(&path)?;
                if let Some(document) = self.document_mut() {
                    document.look.transfer = transfer;
                    document.selected = None;
                }
            }
            PathFor::SaveTransfer => {
                if let Some(document) = self.document() {
                    let text = document.look.transfer.to_toml();
                    self.write_text(&path, &text)?;
                }
            }
            PathFor::Session => {
                let kept = session::read(&path)?;
                self.restore(kept);
            }
            PathFor::SaveSession => self.save_session(&path)?,
        }
        Ok(())
    }

    fn write_text(&mut self, path: &Path, text: &str) -> Result<()> {
        write_atomically(path, |file| {
            std::io::Write::write_all(file, text.as_bytes())
        })?;
        self.say(format!("wrote {}", path.display()));
        Ok(())
    }
}
