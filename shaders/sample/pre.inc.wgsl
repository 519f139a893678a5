// Pre-classification: voxels have their colours, which are interpolated; the value between them is not asked for. Twin of
// sample::Classification::Pre.

fn classify(x: f32, k: u32, ray: Ray) -> vec4f {
    return sample_rgba(lattice(ray, k));
}
