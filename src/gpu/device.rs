//! The adapter and its device: what it is, what it can do, what its limits are.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::{Error, Result};

/// Which adapters to take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AdapterKind {
    /// Only one that is hardware.
    Hardware,
    /// Hardware if there is one, else a software driver.
    Any,
}

/// A device with its queue and what is known of its adapter.
#[derive(Debug, Clone)]
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// Adapter and driver names.
    pub info: wgpu::AdapterInfo,
    lost: Arc<AtomicBool>,
}

/// Features that are used where the adapter has them.
const WANTED: wgpu::Features = wgpu::Features::TEXTURE_FORMAT_16BIT_NORM
    .union(wgpu::Features::FLOAT32_FILTERABLE)
    .union(wgpu::Features::FLOAT32_BLENDABLE)
    .union(wgpu::Features::TIMESTAMP_QUERY);

impl Gpu {
    /// Opens the best adapter of a kind: hardware before software, discrete before integrated.
    ///
    /// # Errors
    /// [`Error::Gpu`] where there is none or its device cannot be made.
    pub fn open(kind: AdapterKind) -> Result<Self> {
        let instance =
            wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
        adapters.retain(|adapter| kind == AdapterKind::Any || !is_software(&adapter.get_info()));
        let adapter = best(&adapters).ok_or_else(|| {
            Error::Gpu(match kind {
                AdapterKind::Hardware => "no hardware adapter found".to_owned(),
                AdapterKind::Any => {
                    "no adapter found; install a driver (Debian: mesa-vulkan-drivers)".to_owned()
                }
            })
        })?;
        let request = adapter.request_device(&descriptor(adapter));
        let (device, queue) =
            pollster::block_on(request).map_err(|error| Error::Gpu(error.to_string()))?;
        Ok(Self::from_device(device, queue, adapter.get_info()))
    }

    /// Wraps a device that the caller owns.
    ///
    /// It should have the features `TEXTURE_FORMAT_16BIT_NORM` (16-bit volumes without conversion),
    /// `FLOAT32_FILTERABLE` (the hardware sampler on f32 volumes), `FLOAT32_BLENDABLE` (slices) and `TIMESTAMP_QUERY`, where its adapter has them.
    pub fn from_device(device: wgpu::Device, queue: wgpu::Queue, info: wgpu::AdapterInfo) -> Self {
        let lost = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&lost);
        device.set_device_lost_callback(move |reason, message| {
            // What the program itself destroys, at its end or before, is no news to it.
            if reason != wgpu::DeviceLostReason::Destroyed {
                tracing::warn!("device lost: {message}");
            }
            flag.store(true, Ordering::Relaxed);
        });
        tracing::info!(adapter = info.name, driver = info.driver_info, backend = %info.backend, "device opened");
        Self {
            device,
            queue,
            info,
            lost,
        }
    }

    /// Whether the adapter is a software driver: it runs on the CPU.
    pub fn is_software(&self) -> bool {
        is_software(&self.info)
    }

    /// Whether the device was lost; a new one must be opened.
    pub fn is_lost(&self) -> bool {
        self.lost.load(Ordering::Relaxed)
    }

    /// Waits until all that was submitted is done.
    ///
    /// # Errors
    /// [`Error::Gpu`] where the device was lost.
    pub fn wait(&self) -> Result<()> {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|error| Error::Gpu(error.to_string()))?;
        if self.is_lost() {
            Err(Error::Gpu("the device was lost".to_owned()))
        } else {
            Ok(())
        }
    }

    /// Runs `work` and reports what the device found invalid or had no memory for.
    ///
    /// # Errors
    /// [`Error::Gpu`] with the device's words.
    pub fn checked<T>(&self, work: impl FnOnce() -> T) -> Result<T> {
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let validation = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let result = work();
        let validation = pollster::block_on(validation.pop());
        let memory = pollster::block_on(memory.pop());
        match memory.or(validation) {
            Some(error) => Err(Error::Gpu(
                error.to_string().lines().collect::<Vec<_>>().join(" "),
            )),
            None => Ok(result),
        }
    }
}

/// The best of some adapters: hardware before software, discrete before integrated.
pub fn best(adapters: &[wgpu::Adapter]) -> Option<&wgpu::Adapter> {
    let rank = |adapter: &&wgpu::Adapter| match adapter.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    };
    adapters.iter().min_by_key(rank)
}

/// The device to ask an adapter for: with what is used where it has it, and as large volumes and pictures as it takes.
pub fn descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
    wgpu::DeviceDescriptor {
        label: Some("hollowcast"),
        required_features: WANTED & adapter.features(),
        required_limits: adapter.limits(),
        ..Default::default()
    }
}

fn is_software(info: &wgpu::AdapterInfo) -> bool {
    info.device_type == wgpu::DeviceType::Cpu
}
