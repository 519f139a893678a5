// No depth cueing.

const CUES = false;

fn cued(color: vec3f, k: f32, ray: Ray) -> vec3f {
    return color;
}
