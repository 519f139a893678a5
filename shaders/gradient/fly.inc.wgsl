// Gradients as they are asked for: central differences of the sampled field. Twin of sample::Gradients::Fly.

// Over two voxels, per local unit, of data values (in units of the table). No loop: drivers bound the iterations of all
// loops together.
fn gradient(at: vec3f) -> vec3f {
    let x = sample_x(at + vec3f(1.0, 0.0, 0.0)) - sample_x(at - vec3f(1.0, 0.0, 0.0));
    let y = sample_x(at + vec3f(0.0, 1.0, 0.0)) - sample_x(at - vec3f(0.0, 1.0, 0.0));
    let z = sample_x(at + vec3f(0.0, 0.0, 1.0)) - sample_x(at - vec3f(0.0, 0.0, 1.0));
    return vec3f(x, y, z) * view.grid_from_local * mode.direction;
}
