//! One piece of a picture: what is written, rasterised and marched for it.

use super::before::{self, Listing};
use super::dispatch::dispatches;
use super::faces::BoundsTexture;
use super::march::{Count, March, SETTINGS_STRIDE};
use super::tiles::{TileMask, joined, tile_runs};
use super::uniforms::{mode_of, settings_of, view_of, viewer_of};
use super::{CAST, GpuBackend, Job, Piece, RASTER};
use crate::error::{Error, Result};
use crate::gpu::abi::MarchSettings;
use crate::gpu::timer::Place;
use crate::skip::Skip;

impl GpuBackend {
    /// Draws one piece of the picture and leaves it on the device.
    pub(super) fn draw_piece(&mut self, job: &Job, piece: &Piece, count: Count) -> Result<()> {
        let Some(volume) = &self.volume else {
            return Err(Error::Gpu("no volume was set".to_owned()));
        };
        if job.scene.sampler.is_filtered() && !volume.filterable {
            return Err(Error::setting(
                "sampler",
                format!(
                    "{} does not filter this volume's format; use exact",
                    self.gpu.info.name
                ),
            ));
        }
        if let Some(slices) = &job.slices {
            return self.draw_slices(job, slices, piece, count == Count::On);
        }
        let gpu = &self.gpu;
        let gradients = job.gradient_edge().and(self.gradients.as_ref());
        let frame = job.scene.frame;

        // The tiles that can show anything.
        let clip_from_local = job.camera.clip_from_local(frame.size);
        let (tile_list, run_list) = if let Some(masks) = job.masks {
            let (tiles, runs) = tile_runs(masks, frame, piece.origin, piece.size);
            let most = gpu.device.limits().max_storage_buffer_binding_size;
            if size_of_val(&runs[..]) as u64 > most {
                joined(tiles, &runs)
            } else {
                (tiles, runs)
            }
        } else {
            let mut mask = TileMask::new(piece.size);
            for &[low, high] in job.active {
                mask.mark(&clip_from_local, frame.size, piece.origin, [low, high]);
            }
            (mask.list(), Vec::new())
        };

        // Uniforms.
        let view = view_of(job, volume, piece, &clip_from_local);
        let dispatches = dispatches(job, tile_list.len() as u32, gpu.is_software());
        let settings: Vec<u8> = dispatches
            .iter()
            .flat_map(|d| {
                let settings = settings_of(job, d);
                let mut bytes = bytemuck::bytes_of(&settings).to_vec();
                bytes.resize(SETTINGS_STRIDE as usize, 0);
                bytes
            })
            .collect();
        let pixels = u64::from(piece.size[0]) * u64::from(piece.size[1]);
        let views = self.views.write(gpu, &[view]);
        let settings_buffer = self.settings.write(gpu, &settings);
        let tiles = self.tiles.write(gpu, &tile_list);
        let runs = self.runs.write(gpu, &run_list);
        let target = self.target.reserve(gpu, pixels * 16);
        let resumes = dispatches.iter().any(|d| d.resume || d.store_progress);
        let progress = self
            .progress
            .reserve(gpu, if resumes { pixels * 4 } else { 0 });
        let counted = if count == Count::On { pixels * 16 } else { 0 };
        let work = self.work.reserve(gpu, counted);
        let blocks = self.blocks.holding(gpu, job.block_words());
        let ray_bytes = before::ray_bytes(job, piece.size);
        let rays = gpu.checked(|| self.rays.reserve(gpu, ray_bytes))?;
        let (table, colors) = self.classes.bound(gpu, job);
        let mode = self.mode.write(gpu, &[mode_of(job, volume, gradients)]);

        // What is not read is bound all the same: to the voxels, to a texel.
        let gradient_view = gradients.map_or(&volume.view, |g| &g.view);
        let bricks = self.bricks.of(job);
        let brick_views = self.bricks.bound(job);

        let segments = job.parts.len();
        if self
            .bounds
            .as_ref()
            .is_none_or(|b| !b.serves(piece.size, segments))
        {
            self.bounds = Some(gpu.checked(|| BoundsTexture::new(gpu, piece.size, segments))?);
        }
        let bounds = self.bounds.as_ref().expect("made just above");

        // What the oracle marches is found by box.
        let is_first = count == Count::Contributing;
        let march = March {
            skip: if is_first { Skip::Box } else { job.skip }.method().shader,
            sampler: job.scene.sampler,
            mode: job.scene.mode.row().shader,
            classification: job.scene.classification,
            is_bounded: job.blocks.is_some_and(|words| words.has_majorants),
            count,
            gradient: job.gradient(),
            is_cued: job.scene.depth_cue > 0.0,
            reads_bricks: bricks.is_some() && !is_first,
        };
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor {
                label: Some("frame"),
            });
        encoder.clear_buffer(target, 0, Some(pixels * 16));
        if count == Count::On {
            encoder.clear_buffer(work, 0, Some(counted));
        }
        if is_first {
            encoder.clear_buffer(rays, 0, Some(ray_bytes));
        }
        if segments > 0 {
            let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("view"),
                layout: &self.view_layout,
                entries: &[wgpu::BindGroupEntry {
                    binding: 0,
                    resource: views.as_entire_binding(),
                }],
            });
            let parts: Vec<_> = job
                .parts
                .iter()
                .map(|p| self.kept_faces[&p.key].as_ref())
                .collect();
            let viewer = viewer_of(job);
            self.faces.draw(
                &mut encoder,
                bounds,
                &group,
                &parts,
                &viewer,
                (&self.timer, RASTER),
            );
            self.timer.resolve(&mut encoder, RASTER);
        }
        let scene_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("march scene"),
            layout: &self.march.scene_layout,
            entries: &[
                bind(0, views.as_entire_binding()),
                bind(
                    1,
                    wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                        buffer: settings_buffer,
                        offset: 0,
                        size: wgpu::BufferSize::new(size_of::<MarchSettings>() as u64),
                    }),
                ),
                bind(2, tiles.as_entire_binding()),
                bind(3, target.as_entire_binding()),
                bind(4, progress.as_entire_binding()),
                bind(5, wgpu::BindingResource::TextureView(&volume.view)),
                bind(6, wgpu::BindingResource::Sampler(&volume.filter)),
                bind(7, table.as_entire_binding()),
                bind(8, mode.as_entire_binding()),
                bind(9, wgpu::BindingResource::TextureView(gradient_view)),
                bind(10, wgpu::BindingResource::TextureView(colors)),
            ],
        });
        let skip_group = |[notes, runs, reads]: [&wgpu::Buffer; 3]| {
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("march skip"),
                layout: &self.march.skip_layout,
                entries: &[
                    bind(0, wgpu::BindingResource::TextureView(&bounds.all)),
                    bind(1, notes.as_entire_binding()),
                    bind(2, runs.as_entire_binding()),
                    bind(3, reads.as_entire_binding()),
                    bind(4, wgpu::BindingResource::TextureView(&brick_views.places)),
                    bind(5, wgpu::BindingResource::TextureView(&brick_views.texels)),
                ],
            })
        };
        let before_march = skip_group([rays, runs, blocks]);
        let march_group = match job.skip {
            _ if is_first => before_march.clone(),
            Skip::Oracle | Skip::SegmentList => skip_group([work, runs, rays]),
            Skip::BeamCells => skip_group([work, rays, blocks]),
            _ => skip_group([work, runs, blocks]),
        };
        let last = dispatches.len() - 1;
        if let Some(listing) = Listing::of(job.skip) {
            let pipeline = self.march.listing(gpu, listing)?;
            let groups = [&scene_group, &before_march];
            before::list(
                &mut encoder,
                (listing, pipeline),
                groups,
                &dispatches,
                &self.timer,
            );
            self.timer.resolve(&mut encoder, RASTER);
        }
        let pipeline = self.march.pipeline(gpu, march)?;
        for (i, dispatch) in dispatches.iter().enumerate() {
            let place = Place {
                span: CAST,
                first: i == 0,
                last: i == last,
            };
            {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: Some("march"),
                    timestamp_writes: self.timer.compute(place),
                });
                if dispatch.tile_count > 0 {
                    pass.set_pipeline(pipeline);
                    pass.set_bind_group(0, &scene_group, &[(i as u64 * SETTINGS_STRIDE) as u32]);
                    pass.set_bind_group(1, &march_group, &[]);
                    dispatch.launch(&mut pass, 1);
                }
            }
            if i == last {
                self.timer.resolve(&mut encoder, CAST);
            } else if dispatch.submit {
                // Each on its own, so that a watchdog sees short work and a cancelled frame ends soon.
                gpu.queue.submit([encoder.finish()]);
                gpu.wait()?;
                if self.progress_of_job.is_cancelled() {
                    return Err(Error::Cancelled);
                }
                encoder = gpu
                    .device
                    .create_command_encoder(&wgpu::CommandEncoderDescriptor {
                        label: Some("frame, continued"),
                    });
            }
        }
        gpu.queue.submit([encoder.finish()]);
        Ok(())
    }
}

pub(super) fn bind(binding: u32, resource: wgpu::BindingResource<'_>) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource }
}
