//! The raster pass: hull faces into entry and exit depths, one pair of layers per segment.

use std::ops::Range;

use glam::DVec3;

use crate::error::Result;
use crate::gpu::Gpu;
use crate::gpu::shader::compose;
use crate::gpu::timer::{Place, SpanTimer};
use crate::octree::Hull;

/// The format of entries and exits: f32, and what the depth test compares.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// A hull in vertex buffers.
#[derive(Debug)]
pub(super) struct FaceBuffers {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    /// Per direction (axis * 2 + positive), the faces' planes in leaf blocks, ascending, and the first face's index.
    directions: [(u32, Vec<u16>); 6],
}

/// One corner of a face: x, y, z in leaf blocks, then axis and growth (see `shaders/faces.wgsl`).
type Vertex = [u16; 4];

impl FaceBuffers {
    /// Uploads a hull; `None` where it has no face.
    pub(super) fn new(gpu: &Gpu, hull: &Hull) -> Option<Self> {
        if hull.faces.is_empty() {
            return None;
        }
        let mut vertices: Vec<Vertex> = Vec::with_capacity(hull.faces.len() * 4);
        for face in &hull.faces {
            let axis = usize::from(face.axis);
            for corner in 0..4u16 {
                let high = [corner & 1, corner >> 1];
                let mut vertex: Vertex = [0; 4];
                vertex[axis] = face.plane;
                vertex[3] = u16::from(face.axis) | u16::from(face.positive) << (2 + axis);
                for (i, high) in high.into_iter().enumerate() {
                    let in_plane = (axis + 1 + i) % 3;
                    vertex[in_plane] = if high == 1 { face.max[i] } else { face.min[i] };
                    vertex[3] |= high << (2 + in_plane);
                }
                vertices.push(vertex);
            }
        }
        let indices: Vec<u32> = (0..hull.faces.len() as u32)
            .flat_map(|f| [0, 1, 2, 2, 1, 3].map(|i| f * 4 + i))
            .collect();
        let buffer = |label, usage, contents: &[u8]| {
            let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: contents.len() as u64,
                usage: usage | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            gpu.queue.write_buffer(&buffer, 0, contents);
            buffer
        };
        Some(Self {
            vertices: buffer(
                "hull corners",
                wgpu::BufferUsages::VERTEX,
                bytemuck::cast_slice(&vertices),
            ),
            indices: buffer(
                "hull triangles",
                wgpu::BufferUsages::INDEX,
                bytemuck::cast_slice(&indices),
            ),
            directions: std::array::from_fn(|d| {
                let range = hull.by_direction[d].clone();
                (
                    range.start as u32,
                    hull.faces[range].iter().map(|f| f.plane).collect(),
                )
            }),
        })
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        self.vertices.size() + self.indices.size()
    }

    /// Index ranges of the faces that look at the viewer (`front`) or away: faces of one direction are sorted by
    /// plane, so each direction gives one range.
    fn ranges(&self, viewer: &Viewer, front: bool) -> Vec<Range<u32>> {
        let mut ranges = Vec::new();
        for (direction, (first, planes)) in self.directions.iter().enumerate() {
            let (axis, positive) = (direction / 2, direction % 2 == 1);
            // Faces grow outward, so they lie a little farther out than their plane says.
            let outward = if positive { viewer.grow } else { -viewer.grow };
            // A plane is below the viewer where the viewer lies on its positive side.
            let below = planes
                .partition_point(|&p| viewer.is_above(axis, viewer.position(axis, p) + outward))
                as u32;
            let range = if positive == front {
                0..below
            } else {
                below..planes.len() as u32
            };
            if !range.is_empty() {
                ranges.push((first + range.start) * 6..(first + range.end) * 6);
            }
        }
        ranges
    }
}

/// Where faces are seen from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Viewer {
    /// The eye, for rays through one point.
    pub(super) eye: DVec3,
    /// The direction of all rays where they are parallel.
    pub(super) parallel: Option<DVec3>,
    /// How far faces grow, in local units.
    pub(super) grow: f64,
    /// Edges of a leaf block in local units.
    pub(super) block_size: DVec3,
    /// Edges of the volume's box in local units.
    pub(super) extent: DVec3,
}

impl Viewer {
    /// Local coordinate of a plane between blocks; the last block may stick out of the volume.
    fn position(&self, axis: usize, plane: u16) -> f64 {
        (f64::from(plane) * self.block_size[axis]).min(self.extent[axis])
    }

    /// Whether the viewer is on the positive side of the plane at `position` on `axis`.
    fn is_above(&self, axis: usize, position: f64) -> bool {
        match self.parallel {
            Some(direction) => direction[axis] < 0.0,
            None => self.eye[axis] > position,
        }
    }
}

/// The pipelines of the pass.
#[derive(Debug)]
pub(super) struct FacesPass {
    entry: wgpu::RenderPipeline,
    exit: wgpu::RenderPipeline,
}

/// What entry layers are cleared to: no face.
const NO_ENTRY: f32 = 1.0;
/// What exit layers are cleared to: no face.
const NO_EXIT: f32 = 0.0;

impl FacesPass {
    /// Compiles the pass. `view_layout` binds the view uniform at group 0.
    pub(super) fn new(gpu: &Gpu, view_layout: &wgpu::BindGroupLayout) -> Result<Self> {
        let module = gpu
            .device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("faces"),
                source: wgpu::ShaderSource::Wgsl(compose("faces", &[])?.into()),
            });
        let layout = gpu
            .device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("faces"),
                bind_group_layouts: &[Some(view_layout)],
                immediate_size: 0,
            });
        let pipeline = |label, compare| {
            gpu.device
                .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                    label: Some(label),
                    layout: Some(&layout),
                    vertex: wgpu::VertexState {
                        module: &module,
                        entry_point: Some("vertex"),
                        compilation_options: wgpu::PipelineCompilationOptions::default(),
                        buffers: &[Some(wgpu::VertexBufferLayout {
                            array_stride: size_of::<Vertex>() as u64,
                            step_mode: wgpu::VertexStepMode::Vertex,
                            attributes: &wgpu::vertex_attr_array![0 => Uint16x4],
                        })],
                    },
                    primitive: wgpu::PrimitiveState::default(),
                    depth_stencil: Some(wgpu::DepthStencilState {
                        format: FORMAT,
                        depth_write_enabled: Some(true),
                        depth_compare: Some(compare),
                        stencil: wgpu::StencilState::default(),
                        bias: wgpu::DepthBiasState::default(),
                    }),
                    multisample: wgpu::MultisampleState::default(),
                    fragment: Some(wgpu::FragmentState {
                        module: &module,
                        entry_point: Some("fragment"),
                        compilation_options: wgpu::PipelineCompilationOptions::default(),
                        targets: &[],
                    }),
                    multiview_mask: None,
                    cache: None,
                })
        };
        Ok(Self {
            entry: pipeline("entry", wgpu::CompareFunction::Less),
            exit: pipeline("exit", wgpu::CompareFunction::Greater),
        })
    }

    /// Draws the entry and exit layers of every part, near part first.
    pub(super) fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        bounds: &BoundsTexture,
        view_group: &wgpu::BindGroup,
        parts: &[Option<&FaceBuffers>],
        viewer: &Viewer,
        (timer, span): (&SpanTimer, u32),
    ) {
        for (layer, view) in bounds.layers[..parts.len() * 2].iter().enumerate() {
            let is_entry = layer % 2 == 0;
            let place = Place {
                span,
                first: layer == 0,
                last: layer + 1 == parts.len() * 2,
            };
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(if is_entry { "entry" } else { "exit" }),
                color_attachments: &[],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view,
                    depth_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(if is_entry { NO_ENTRY } else { NO_EXIT }),
                        store: wgpu::StoreOp::Store,
                    }),
                    stencil_ops: None,
                }),
                timestamp_writes: timer.render(place),
                occlusion_query_set: None,
                multiview_mask: None,
            });
            let Some(faces) = parts[layer / 2] else {
                continue;
            };
            pass.set_pipeline(if is_entry { &self.entry } else { &self.exit });
            pass.set_bind_group(0, view_group, &[]);
            pass.set_vertex_buffer(0, faces.vertices.slice(..));
            pass.set_index_buffer(faces.indices.slice(..), wgpu::IndexFormat::Uint32);
            for range in faces.ranges(viewer, is_entry) {
                pass.draw_indexed(range, 0, 0..1);
            }
        }
    }
}

/// Entry and exit depths: layers 2i and 2i + 1 for segment i.
#[derive(Debug)]
pub(super) struct BoundsTexture {
    /// All layers, for the marcher.
    pub(super) all: wgpu::TextureView,
    layers: Vec<wgpu::TextureView>,
    size: [u32; 2],
}

impl BoundsTexture {
    /// Bounds of `segments` segments for a target of `size` pixels.
    pub(super) fn new(gpu: &Gpu, size: [u32; 2], segments: usize) -> Self {
        // An array view wants at least two layers on every backend: one segment has them.
        let layer_count = segments.max(1) as u32 * 2;
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("bounds"),
            size: wgpu::Extent3d {
                width: size[0],
                height: size[1],
                depth_or_array_layers: layer_count,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let layers = (0..layer_count)
            .map(|layer| {
                texture.create_view(&wgpu::TextureViewDescriptor {
                    label: Some("bounds layer"),
                    dimension: Some(wgpu::TextureViewDimension::D2),
                    base_array_layer: layer,
                    array_layer_count: Some(1),
                    ..Default::default()
                })
            })
            .collect();
        let all = texture.create_view(&wgpu::TextureViewDescriptor {
            label: Some("bounds"),
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        Self { all, layers, size }
    }

    /// Whether it serves a target of this size and this many segments.
    pub(super) fn serves(&self, size: [u32; 2], segments: usize) -> bool {
        self.size == size && self.layers.len() >= segments * 2
    }
}
