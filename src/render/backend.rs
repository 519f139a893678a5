//! Which backend draws, and opening it.

use std::sync::Arc;

use super::auto::Chooser;
use super::classes::Classes;
use super::gpu::GpuBackend;
use super::structures::Structures;
use super::{Backend, Renderer, cache, self_check};
use crate::cpu;
use crate::error::Result;
use crate::gpu::{AdapterKind, Gpu};
use crate::scene::{Picture, Progress};

/// Which backend to take.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BackendChoice {
    /// A hardware GPU if there is one, else the CPU. A software adapter only when asked for by [`Self::Gpu`].
    Auto,
    /// The best adapter there is, hardware or software.
    Gpu,
    /// The CPU, with SIMD.
    Cpu,
    /// The CPU in f64: slow, and what the others are measured against.
    Reference,
}

impl BackendChoice {
    /// All choices.
    pub const ALL: &[Self] = &[Self::Auto, Self::Gpu, Self::Cpu, Self::Reference];

    /// The name used by flags and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Gpu => "gpu",
            Self::Cpu => "cpu",
            Self::Reference => "reference",
        }
    }
}

/// What draws the pictures.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BackendInfo {
    /// `gpu` or `reference`.
    pub backend: &'static str,
    /// The adapter's name, or the processor's number of threads.
    pub adapter: String,
    /// Driver name and version.
    pub driver: String,
    /// Whether it runs on the CPU.
    pub is_software: bool,
}

impl Renderer {
    /// Opens a backend.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where an adapter was asked for and there is none.
    pub fn new(choice: BackendChoice) -> Result<Self> {
        let progress = Arc::<Progress>::default();
        match choice {
            BackendChoice::Gpu => Self::on(
                GpuBackend::open(AdapterKind::Any, Arc::clone(&progress))?,
                progress,
            ),
            BackendChoice::Auto => {
                match GpuBackend::open(AdapterKind::Hardware, Arc::clone(&progress)) {
                    Ok(backend) => Self::on(backend, progress),
                    Err(error) => {
                        tracing::info!("{error}; drawing on the CPU");
                        Self::new(BackendChoice::Cpu)
                    }
                }
            }
            BackendChoice::Cpu => Ok(Self::with_backend(
                Backend::Cpu(Box::new(Picture {
                    size: [0, 0],
                    rgba: Vec::new(),
                })),
                BackendInfo {
                    backend: "cpu",
                    adapter: format!(
                        "{} threads, {}",
                        rayon::current_num_threads(),
                        cpu::Path::best().name()
                    ),
                    driver: format!("hollowcast {}", env!("CARGO_PKG_VERSION")),
                    is_software: true,
                },
                progress,
            )),
            BackendChoice::Reference => Ok(Self::with_backend(
                Backend::Reference,
                BackendInfo {
                    backend: "reference",
                    adapter: format!("{} threads", rayon::current_num_threads()),
                    driver: format!("hollowcast {}", env!("CARGO_PKG_VERSION")),
                    is_software: true,
                },
                progress,
            )),
        }
    }

    /// Draws on a device that the caller owns; see [`Gpu::from_device`].
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the device cannot compile the passes.
    pub fn with_device(gpu: Gpu) -> Result<Self> {
        let progress = Arc::<Progress>::default();
        Self::on(
            GpuBackend::with_device(gpu, Arc::clone(&progress))?,
            progress,
        )
    }

    /// On this backend, less what its self-check withdraws.
    fn on(backend: GpuBackend, progress: Arc<Progress>) -> Result<Self> {
        let info = &backend.gpu().info;
        let info = BackendInfo {
            backend: "gpu",
            adapter: info.name.clone(),
            driver: format!("{} {}", info.driver, info.driver_info)
                .trim()
                .to_owned(),
            is_software: backend.gpu().is_software(),
        };
        let mut renderer = Self::with_backend(Backend::Gpu(Box::new(backend)), info, progress);
        renderer.chooser.is_probing = true;
        renderer.withdrawn =
            self_check::withdrawn(&mut renderer, cache::file("self-check.json").as_deref())?;
        for skip in &renderer.withdrawn {
            tracing::warn!(
                "{} failed the self-check on this adapter: box is drawn instead",
                skip.method().name
            );
        }
        renderer.chooser.is_probing = false;
        renderer.forget_volume();
        Ok(renderer)
    }

    fn with_backend(backend: Backend, info: BackendInfo, progress: Arc<Progress>) -> Self {
        Self {
            backend,
            info,
            volume: None,
            structures: Structures::default(),
            transfer: None,
            table: None,
            classes: Classes::default(),
            progress,
            withdrawn: Vec::new(),
            chooser: Chooser::default(),
        }
    }
}
