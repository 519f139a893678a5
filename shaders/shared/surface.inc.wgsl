// Surfaces: where a ray crosses them, how they lie there, and how they are lit. Twin of mode::surface.
#import shared/mode_settings
#import gradient/{GRADIENT}
#import cue/{CUE}

// Halvings of the step in which a surface is crossed (surface::HALVINGS).
const HALVINGS = 10u;

fn is_inside(x: f32, iso: f32) -> bool {
    return (x - iso) * mode.direction >= 0.0;
}

// How many steps before sample k, which is inside, the interpolated field comes to `iso`; the one before k is not inside.
// To 2^-11 of a step.
fn crossing(ray: Ray, k: u32, iso: f32) -> f32 {
    let at = lattice(ray, k);
    var inside = 0.0;
    var outside = 1.0;
    for (var i = 0u; i < HALVINGS; i++) {
        let middle = 0.5 * (inside + outside);
        let goes_in = is_inside(sample_x(at - middle * ray.delta), iso);
        inside = select(inside, middle, goes_in);
        outside = select(middle, outside, goes_in);
    }
    return 0.5 * (inside + outside);
}

// The colour of the surface at `iso`, faded as the depth asks at which the ray meets it before sample k (at the first sample
// where it begins inside).
fn cued_surface(color: vec3f, ray: Ray, k: u32, iso: f32) -> vec3f {
    if !CUES {
        return color;
    }
    return cued(color, f32(k) - select(crossing(ray, k, iso), 0.0, k <= ray.k_near), ray);
}

// The unit direction from a ray's samples to its eye.
fn to_eye(ray: Ray) -> vec3f {
    let back = -ray.delta / (view.step * view.grid_from_local);
    return back / sqrt(dot(back, back));
}

// The normal of the (inner) surface where the ray comes to it before sample k: towards less. Towards the eye where the data
// have no gradient, and where the ray begins inside: there it meets no surface but a cut.
fn surface_normal(ray: Ray, k: u32, eye: vec3f) -> vec3f {
    let g = gradient(lattice(ray, k) - crossing(ray, k, mode.iso) * ray.delta);
    let length = sqrt(dot(g, g));
    let is_cut = k <= ray.k_near;
    return select(-g / max(length, 1e-20), eye, is_cut || length <= mode.least_gradient);
}

// What a surface sends to the eye of light that is as bright as 1: the factor of its colour, and the highlight (Blinn
// and Phong).
fn reflected(normal: vec3f, eye: vec3f) -> vec2f {
    let light = select(mode.light, eye, mode.light_is_eye != 0u);
    let sum = light + eye;
    // Light from straight behind has no direction halfway.
    let between = sum / max(sqrt(dot(sum, sum)), 1e-6);
    let gloss = exp2(mode.shininess * log2(max(dot(normal, between), 1e-4)));
    return vec2f(mode.ambient + mode.diffuse * max(dot(normal, light), 0.0), mode.specular * gloss);
}

// The (inner) surface's colour, lit, where the ray comes to it before sample k.
fn lit_surface(ray: Ray, k: u32) -> vec3f {
    let eye = to_eye(ray);
    let light = reflected(surface_normal(ray, k, eye), eye);
    return cued_surface(mode.color * light.x + light.y, ray, k, mode.iso);
}
