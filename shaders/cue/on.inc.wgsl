// Depth cueing: colours fade to black from the nearest to the farthest point of the box. Twin of mode::DepthCue.
#import shared/mode_settings

const CUES = true;

// The premultiplied colour of what lies at sample k, or between samples. Its opacity stays: what is hidden stays hidden.
fn cued(color: vec3f, k: f32, ray: Ray) -> vec3f {
    let depth = (ray.t_box + (k + 0.5) * view.step) / ray.length;
    return color * (1.0 - mode.cue_strength * clamp((depth - mode.cue_start) * mode.cue_scale, 0.0, 1.0));
}
